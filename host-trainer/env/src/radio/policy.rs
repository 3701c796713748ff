//! The int8 actor over a radio channel.

use super::channel::RadioChannel;
use super::error::RadioError;
use super::figures::RadioFigures;
use super::settings::RadioSettings;
use super::swarm::Swarm;
use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::actor::{ActorInput, Mode, QuantisedActor};
use firmware_core::agent::{AgentSettings, Decision};
use firmware_core::observation::{Neighbours, Observation};

/// Flies all UAVs of a world with one int8 actor, over a radio channel.
///
/// Each UAV is an on-board [`Agent`](firmware_core::agent::Agent) and knows the others only by the bytes that the
/// channel delivers, with the timing of a step on board: beacons are sent as the step begins; what has arrived
/// [`ENCODE_MS`](super::ENCODE_MS) later makes the observation, and features are sent; what has arrived by
/// [`DECIDE_MS`](super::DECIDE_MS) makes the decision. What arrives later counts in the next step. Ages are measured
/// from the beginning of the step, the moment that the beacons tell of.
///
/// Over a perfect channel that reaches 34 u or farther it equals [`crate::ActorPolicy`] to the bit.
#[derive(Clone, Debug)]
pub struct RadioPolicy<'a, O: ActorInput = Observation> {
    actor: QuantisedActor<'a, O>,
    /// Of the next episode.
    seed: u64,
    swarm: Swarm,
    observations: Vec<O>,
}

impl<'a, O: ActorInput> RadioPolicy<'a, O> {
    /// A policy for `uavs` UAVs with the seed that they share; the channel's random numbers follow from it too.
    ///
    /// # Errors
    /// [`RadioError`] when a parameter is out of range, or there are more UAVs than a channel has nodes.
    pub fn new(
        actor: QuantisedActor<'a, O>,
        seed: u64,
        mode: Mode,
        settings: &RadioSettings,
        uavs: usize,
    ) -> Result<Self, RadioError> {
        let shared = AgentSettings { mode, ..AgentSettings::new(&actor, 0, seed) };
        Ok(Self { actor, seed, swarm: Swarm::new(settings, uavs, shared)?, observations: vec![O::ZERO; uavs] })
    }

    /// Sets the policy seed of the next episode; it counts from [`Policy::begin`] on.
    pub const fn reseed(&mut self, seed: u64) {
        self.seed = seed;
    }

    /// Lets every UAV observe the present state of `world`, encode it, and exchange beacons and features. Call it once
    /// for each step.
    ///
    /// # Panics
    /// When `world` has another number of UAVs than [`Self::new`] was given.
    pub fn observe(&mut self, world: &World) {
        let Self { actor, swarm, observations, .. } = self;
        swarm.exchange(world, observations, |agent, observation, sequence| {
            agent.encode(actor, observation, sequence).expect("the agent was set up for this actor and has observed")
        });
    }

    /// Observations of all UAVs at the last [`Self::observe`].
    #[must_use]
    pub fn observations(&self) -> &[O] {
        &self.observations
    }

    /// The neighbours that UAV `i` believed in range at the last [`Self::observe`].
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn neighbours(&self, i: usize) -> &Neighbours {
        self.swarm.agents[i].neighbours()
    }

    /// The decision of UAV `i` for its observation and the features it had received at the last [`Self::observe`].
    ///
    /// # Panics
    /// When there is no UAV `i`, or [`Self::observe`] was not called in this episode.
    #[must_use]
    pub fn decide(&self, i: usize) -> Decision {
        self.swarm.agents[i].decide(&self.actor).expect("observe comes before decide")
    }

    /// The radio channel.
    #[must_use]
    pub const fn channel(&self) -> &RadioChannel {
        &self.swarm.channel
    }

    /// What the channel has done to the swarm in this episode.
    #[must_use]
    pub fn figures(&self) -> RadioFigures {
        self.swarm.figures()
    }
}

impl<O: ActorInput> Policy for RadioPolicy<'_, O> {
    fn begin(&mut self, _: &World) {
        self.swarm.begin(AgentSettings { policy_seed: self.seed, ..self.swarm.shared() });
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.observe(world);
        for (i, action) in actions.iter_mut().enumerate() {
            *action = self.decide(i).action;
        }
    }
}
