//! The int8 actor over a link.

use super::figures::RadioFigures;
use super::model::Radio;
use super::settings::{RadioError, RadioSettings};
use super::swarm::Swarm;
use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::actor::{ActorInput, Feature, Logits, Mode, QuantisedActor};
use firmware_core::message;
use firmware_core::observation::{Neighbours, Observation};

/// Flies all UAVs of a world with one actor, over a link.
///
/// Each UAV has a neighbour table of its own and knows the others only by the bytes that the
/// link brings it, in the order of a step on the air: beacons go out as the step begins; what
/// has arrived [`ENCODE_MS`](super::ENCODE_MS) later makes the observation, and features go
/// out; what has arrived by [`DECIDE_MS`](super::DECIDE_MS) makes the decision. What comes
/// later is there in the next step. Ages are measured from the beginning of the step, where the
/// state in the beacon is from.
///
/// Over a perfect link that reaches 34 u or farther it is [`crate::ActorPolicy`], to the bit.
#[derive(Clone, Debug)]
pub struct RadioPolicy<'a, O: ActorInput = Observation> {
    actor: QuantisedActor<'a, O>,
    seed: u64,
    mode: Mode,
    swarm: Swarm,
    observations: Vec<O>,
    features: Vec<Feature>,
}

impl<'a, O: ActorInput> RadioPolicy<'a, O> {
    /// `seed` is the policy seed that all UAVs share; the link's draws come from it too.
    ///
    /// # Errors
    /// Settings that cannot be, or more UAVs than a link has nodes.
    pub fn new(
        actor: QuantisedActor<'a, O>,
        seed: u64,
        mode: Mode,
        link: &RadioSettings,
        uavs: usize,
    ) -> Result<Self, RadioError> {
        let mut swarm = Swarm::new(link, uavs, actor.policy_id())?;
        swarm.begin(seed);
        let observations = vec![O::ZERO; uavs];
        let features = observations.iter().map(|o| actor.encode(o)).collect();
        Ok(Self { actor, seed, mode, swarm, observations, features })
    }

    /// Takes another policy seed for the next episode, from its [`Policy::begin`] on.
    pub const fn reseed(&mut self, seed: u64) {
        self.seed = seed;
    }

    /// The UAVs look, tell each other what they see and hear it, in the present state of
    /// `world`. Call it once a step.
    ///
    /// # Panics
    /// When `world` has not as many UAVs as [`Self::new`] was told.
    pub fn look(&mut self, world: &World) {
        let Self { actor, seed, swarm, observations, features, .. } = self;
        let tie = |id, step| actor.tie_breaker(*seed, id, step);
        swarm.look(world, tie, observations, |seen| {
            features[seen.index] = actor.encode(seen.observation);
            message::FeatureMessage::from_actor(seen.header, seen.degree, actor, &features[seen.index])
        });
    }

    /// Observations of all UAVs at the last [`Self::look`].
    #[must_use]
    pub fn observations(&self) -> &[O] {
        &self.observations
    }

    /// The neighbours that UAV `i` believed in range at the last [`Self::look`].
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn neighbours(&self, i: usize) -> &Neighbours {
        &self.swarm.boards[i].view
    }

    /// Logits of UAV `i` for what it saw and heard at the last [`Self::look`], at `step`.
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn logits(&self, i: usize, step: u32) -> Logits {
        let board = &self.swarm.boards[i];
        let heard = board.table.features(&board.view, step).map(|(_, feature)| feature);
        self.actor.logits(&self.features[i], board.degree(), heard)
    }

    /// The action of these logits for UAV `i` at `step`.
    #[must_use]
    pub fn choose(&self, logits: &Logits, i: usize, step: u32) -> Action {
        self.actor.choose(logits, self.mode, self.seed, i as u16, step)
    }

    /// The link.
    #[must_use]
    pub const fn radio(&self) -> &Radio {
        &self.swarm.radio
    }

    /// What the link has done to the swarm in this episode.
    #[must_use]
    pub fn figures(&self) -> RadioFigures {
        self.swarm.figures()
    }
}

impl<O: ActorInput> Policy for RadioPolicy<'_, O> {
    fn begin(&mut self, _: &World) {
        self.swarm.begin(self.seed);
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.look(world);
        let step = world.steps_done();
        for (i, action) in actions.iter_mut().enumerate() {
            *action = self.choose(&self.logits(i, step), i, step);
        }
    }
}
