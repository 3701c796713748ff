//! The int8 actor in a world: every UAV encodes its observation, aggregates its neighbours' features and decides as on
//! board, with every message arriving at once.

use crate::observe::{Neighbourhood, Observer, neighbour_features};
use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::actor::{ActorInput, Feature, Logits, Mode, QuantisedActor};
use firmware_core::observation::Observation;

/// Flies all UAVs of a world with one int8 actor, as if every message arrived at once and without loss.
/// [`crate::radio::RadioPolicy`] does the same over a lossy radio.
#[derive(Clone, Debug)]
pub struct ActorPolicy<'a, O: ActorInput = Observation> {
    actor: QuantisedActor<'a, O>,
    seed: u64,
    mode: Mode,
    observer: Observer,
    observations: Vec<O>,
    neighbourhoods: Vec<Neighbourhood>,
    features: Vec<Feature>,
}

impl<'a, O: ActorInput> ActorPolicy<'a, O> {
    /// A policy with the seed that all UAVs share; each draws its tie-breakers and actions from it by its id and the
    /// step.
    #[must_use]
    pub fn new(actor: QuantisedActor<'a, O>, seed: u64, mode: Mode) -> Self {
        Self {
            actor,
            seed,
            mode,
            observer: Observer::new(seed, actor.tie_period()),
            observations: Vec::new(),
            neighbourhoods: Vec::new(),
            features: Vec::new(),
        }
    }

    /// Observes and encodes the present state of `world`.
    pub fn observe(&mut self, world: &World) {
        let n = world.scenario().uavs;
        self.observations.resize(n, O::ZERO);
        self.neighbourhoods.resize(n, Neighbourhood::default());
        self.observer.observe(world, &mut self.observations, &mut self.neighbourhoods);
        self.features.clear();
        self.features.extend(self.observations.iter().map(|o| self.actor.encode(o)));
    }

    /// Observations of all UAVs at the last [`Self::observe`].
    #[must_use]
    pub fn observations(&self) -> &[O] {
        &self.observations
    }

    /// Neighbourhoods of all UAVs at the last [`Self::observe`].
    #[must_use]
    pub fn neighbourhoods(&self) -> &[Neighbourhood] {
        &self.neighbourhoods
    }

    /// Features of all UAVs at the last [`Self::observe`].
    #[must_use]
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// Logits of UAV `i` for its observation and its neighbours' features at the last [`Self::observe`].
    ///
    /// # Panics
    /// When the world observed had no UAV `i`.
    #[must_use]
    pub fn logits(&self, i: usize) -> Logits {
        let width = usize::from(self.actor.dimensions().feature);
        let neighbours = neighbour_features(&self.features, width, &self.neighbourhoods, i);
        self.actor.logits(&self.features[i], self.neighbourhoods[i].degree(), neighbours)
    }

    /// The action that UAV `i` takes by these logits at `step`: drawn or the greatest, as the mode says.
    #[must_use]
    pub fn choose(&self, logits: &Logits, i: usize, step: u32) -> Action {
        self.actor.choose(logits, self.mode, self.seed, i as u16, step)
    }
}

impl<O: ActorInput> Policy for ActorPolicy<'_, O> {
    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.observe(world);
        for (i, action) in actions.iter_mut().enumerate() {
            *action = self.choose(&self.logits(i), i, world.steps_done());
        }
    }
}
