//! Actor and critic with their parameters and optimisers.

use super::adam::Adam;
use crate::rollout::Workers;
use covey_net::{ActorCritic, ActorNet, CriticNet, ParameterLayout};
use firmware_core::actor::Aggregation;

/// A network that is being trained.
pub struct Trained<N> {
    /// The network with these parameters loaded, ready for forward and backward passes on CPUs.
    pub network: N,
    /// Its parameters, in the order of its [`ParameterLayout`].
    pub parameters: Vec<f32>,
    /// The optimiser's state.
    pub optimiser: Adam,
}

/// Actor and critic, which share nothing.
pub struct Learner {
    /// The shared actor of all UAVs.
    pub actor: Trained<ActorNet>,
    /// The central critic.
    pub critic: Trained<CriticNet>,
}

impl Learner {
    /// Networks of these layouts with these parameters and optimisers.
    ///
    /// # Panics
    /// When parameters are not as many as their layout has.
    pub fn new(
        layouts: &ActorCritic<ParameterLayout>,
        aggregation: Aggregation,
        parameters: ActorCritic<Vec<f32>>,
        optimisers: ActorCritic<Adam>,
    ) -> Self {
        let (mut actor, mut critic) = (ActorNet::new(&layouts.actor, aggregation), CriticNet::new(&layouts.critic));
        actor.load(&parameters.actor);
        critic.load(&parameters.critic);
        Self {
            actor: Trained { network: actor, parameters: parameters.actor, optimiser: optimisers.actor },
            critic: Trained { network: critic, parameters: parameters.critic, optimiser: optimisers.critic },
        }
    }

    /// The parameters of both.
    pub fn parameters(&self) -> ActorCritic<&[f32]> {
        ActorCritic { actor: &self.actor.parameters, critic: &self.critic.parameters }
    }

    /// A step of both optimisers against the sum of `partial_gradients`, taken in their order;
    /// it is left in the first of them. Returns each gradient's norm before it was clipped to
    /// `max_norm`.
    pub fn step(
        &mut self,
        partial_gradients: &mut [ActorCritic<Vec<f32>>],
        learning_rate: f64,
        max_norm: f64,
        threads: &Workers,
    ) -> ActorCritic<f64> {
        let (mut of_actor, mut of_critic) = (Vec::new(), Vec::new());
        for gradient in partial_gradients {
            of_actor.push(&mut gradient.actor);
            of_critic.push(&mut gradient.critic);
        }
        let both: [(&mut dyn Optimise, _); 2] = [(&mut self.actor, of_actor), (&mut self.critic, of_critic)];
        let norms = threads.run(both.into(), |_, (trained, mut gradients): (&mut dyn Optimise, Vec<_>)| {
            trained.step(sum_into_first(&mut gradients), learning_rate, max_norm)
        });
        ActorCritic { actor: norms[0], critic: norms[1] }
    }
}

/// Adds all vectors to the first; nothing if there are none.
fn sum_into_first<'g>(gradients: &'g mut [&mut Vec<f32>]) -> &'g [f32] {
    let [sum, rest @ ..] = gradients else { return &[] };
    for gradient in rest {
        sum.iter_mut().zip(gradient.iter()).for_each(|(s, g)| *s += g);
    }
    sum
}

/// [`Trained`] without its type of network.
trait Optimise: Send {
    /// A step of the optimiser, after which the network has the new parameters. Returns the
    /// gradient's norm before it was clipped.
    fn step(&mut self, gradient: &[f32], learning_rate: f64, max_norm: f64) -> f64;
}

impl Optimise for Trained<ActorNet> {
    fn step(&mut self, gradient: &[f32], learning_rate: f64, max_norm: f64) -> f64 {
        let norm = self.optimiser.step(&mut self.parameters, gradient, learning_rate, max_norm);
        self.network.load(&self.parameters);
        norm
    }
}

impl Optimise for Trained<CriticNet> {
    fn step(&mut self, gradient: &[f32], learning_rate: f64, max_norm: f64) -> f64 {
        let norm = self.optimiser.step(&mut self.parameters, gradient, learning_rate, max_norm);
        self.network.load(&self.parameters);
        norm
    }
}
