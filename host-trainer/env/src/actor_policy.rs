//! The int8 actor in a world: every UAV encodes, hears its neighbours and decides as on
//! board, with every message arriving at once.

use crate::observer::{Neighbourhood, Observer};
use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::actor::{ActorInput, Feature, Logits, Mode, NeighbourFeature, QuantisedActor};
use firmware_core::observation::Observation;

/// Flies all UAVs of a world with one actor.
#[derive(Clone, Debug)]
pub struct ActorPolicy<'a, O: ActorInput = Observation> {
    actor: QuantisedActor<'a, O>,
    seed: u64,
    mode: Mode,
    observer: Observer,
    observations: Vec<O>,
    links: Vec<Neighbourhood>,
    features: Vec<Feature>,
}

impl<'a, O: ActorInput> ActorPolicy<'a, O> {
    /// `seed` is the policy seed that all UAVs share; each draws from it by its id and
    /// the step.
    #[must_use]
    pub fn new(actor: QuantisedActor<'a, O>, seed: u64, mode: Mode) -> Self {
        Self {
            actor,
            seed,
            mode,
            observer: Observer::new(seed, actor.tie_period()),
            observations: Vec::new(),
            links: Vec::new(),
            features: Vec::new(),
        }
    }

    /// Observes and encodes the present state of `world`.
    pub fn look(&mut self, world: &World) {
        let n = world.scenario().uavs;
        self.observations.resize(n, O::ZERO);
        self.links.resize(n, Neighbourhood::default());
        self.observer.observe(world, &mut self.observations, &mut self.links);
        self.features.clear();
        self.features.extend(self.observations.iter().map(|o| self.actor.encode(o)));
    }

    /// Observations of all UAVs at the last [`Self::look`].
    #[must_use]
    pub fn observations(&self) -> &[O] {
        &self.observations
    }

    /// Neighbours of all UAVs at the last [`Self::look`].
    #[must_use]
    pub fn links(&self) -> &[Neighbourhood] {
        &self.links
    }

    /// Features of all UAVs at the last [`Self::look`].
    #[must_use]
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// Logits of UAV `i` for what it saw and heard at the last [`Self::look`].
    ///
    /// # Panics
    /// When the world seen had no such UAV.
    #[must_use]
    pub fn logits(&self, i: usize) -> Logits {
        let width = usize::from(self.actor.dimensions().feature);
        let neighbours = heard(&self.features, width, &self.links, i);
        self.actor.logits(&self.features[i], self.links[i].count + 1, neighbours)
    }

    /// The action of these logits for UAV `i` at `step`.
    #[must_use]
    pub fn choose(&self, logits: &Logits, i: usize, step: u32) -> Action {
        self.actor.choose(logits, self.mode, self.seed, i as u16, step)
    }
}

/// What UAV `i` hears of its neighbours when every message arrives: `features` (the first `width` numbers of each are
/// sent) and `links` are those of all UAVs.
///
/// # Panics
/// When there is no such UAV, a neighbour has no feature, or features are not so wide.
pub fn heard<'f>(
    features: &'f [Feature],
    width: usize,
    links: &'f [Neighbourhood],
    i: usize,
) -> impl Iterator<Item = NeighbourFeature<'f>> {
    links[i].as_slice().iter().map(move |&j| {
        let (feature, link) = (&features[usize::from(j)], &links[usize::from(j)]);
        NeighbourFeature {
            values: &feature.values[..width],
            degree: link.count + 1,
            attention_source: feature.attention_source,
        }
    })
}

impl<O: ActorInput> Policy for ActorPolicy<'_, O> {
    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.look(world);
        for (i, action) in actions.iter_mut().enumerate() {
            *action = self.choose(&self.logits(i), i, world.steps_done());
        }
    }
}
