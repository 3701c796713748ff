//! One UAV's agent: everything between its radio, its sensors and its action.
//!
//! A step of an [`Agent`] goes like this; what travels between UAVs is in [`crate::message`]:
//!
//! 1. [`Agent::beacon`]: the own state, for the other UAVs;
//! 2. [`Agent::hear`]: the others' beacons, as the radio brings them;
//! 3. [`Agent::observe`]: the observation of the own state, the neighbours and the PoIs in view;
//! 4. [`Agent::encode`]: the observation becomes the own feature, for the other UAVs;
//! 5. [`Agent::hear`] again: the others' features;
//! 6. [`Agent::decide`]: own and neighbours' features become an action.
//!
//! The board, the MAVLink node and the evaluation over a radio fly by this one sequence. When a
//! step begins, how long each phase waits for messages, and where PoIs come from is up to them.
//!
//! An agent does not hold its actor: a board loads the actor after its memory is laid out, a
//! simulated swarm shares one among thousands of agents, and in training there is none yet. The
//! steps that need the actor borrow it.

use crate::action::Action;
use crate::actor::{ActorInput, Feature, Logits, Mode, NeighbourFeature, PolicyId, QuantisedActor};
use crate::geometry::{MAP_SIDE_U, State, TICKS_PER_U, Vec2};
use crate::message::{Beacon, FeatureMessage, Header, Message};
use crate::neighbour_table::{DEFAULT_STEP_MS, MessageOutcome, Moment, NeighbourTable};
use crate::observation::{BuildObservation, Neighbours, Scene};
use crate::random::tie_breaker;

/// Who an agent is, and what it shares with its swarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AgentSettings {
    /// Its id in the swarm.
    pub id: u16,
    /// The policy that it flies; features of others are not heard.
    pub policy: PolicyId,
    /// Steps for which a tie-breaker holds ([`QuantisedActor::tie_period`]).
    pub tie_period: u32,
    /// Seed of tie-breakers and sampled actions, the same on every UAV of the swarm.
    pub policy_seed: u64,
    /// How an action is taken from the logits.
    pub mode: Mode,
    /// Length of a step, ms (see [`NeighbourTable::new`]).
    pub step_ms: u16,
    /// Half the side of the map, ticks; the map's south-west corner is the origin.
    pub half_side: i32,
}

impl AgentSettings {
    /// UAV `id` of a swarm that flies `actor` with this policy seed. The rest is as in training:
    /// sampled actions, steps of [`DEFAULT_STEP_MS`] and a map of [`MAP_SIDE_U`].
    #[must_use]
    pub fn new<O: ActorInput>(actor: &QuantisedActor<'_, O>, id: u16, policy_seed: u64) -> Self {
        Self {
            id,
            policy: actor.policy_id(),
            tie_period: actor.tie_period(),
            policy_seed,
            mode: Mode::Sample,
            step_ms: DEFAULT_STEP_MS,
            half_side: MAP_SIDE_U as i32 * TICKS_PER_U / 2,
        }
    }
}

/// An agent's action for a step, and what it rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The step.
    pub step: u32,
    /// The action.
    pub action: Action,
    /// The logits that the action was taken from.
    pub logits: Logits,
    /// Neighbours whose features were aggregated, 0 to 16.
    pub features: u8,
}

/// Why an agent cannot encode or decide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AgentError {
    /// Another actor than the one that [`AgentSettings::policy`] names.
    #[error("this is not the actor whose policy the agent was set up for: set it up anew")]
    OtherActor,
    /// No observation was made yet: encoding comes after [`Agent::observe`].
    #[error("no step was observed yet: observe before encoding")]
    NotObserved,
    /// The present step's observation was not encoded: deciding comes after [`Agent::encode`].
    #[error("the step was not encoded yet: encode its observation before deciding")]
    NotEncoded,
}

/// One UAV's agent, about 2.5 KiB; see the [module](self) for its steps.
#[derive(Clone, Debug)]
pub struct Agent {
    settings: AgentSettings,
    table: NeighbourTable,
    /// In range at the last observation.
    neighbours: Neighbours,
    /// The step of the last observation.
    step: Option<u32>,
    /// What its encoder made of it.
    feature: Option<Feature>,
}

impl Agent {
    /// An agent that has heard nothing.
    #[must_use]
    pub const fn new(settings: AgentSettings) -> Self {
        Self {
            table: NeighbourTable::new(settings.id, settings.policy, settings.step_ms),
            settings,
            neighbours: Neighbours::new(),
            step: None,
            feature: None,
        }
    }

    /// Becomes [`Self::new`] in place, for boards whose stack has no room for an agent.
    pub fn reset(&mut self, settings: AgentSettings) {
        self.settings = settings;
        self.table.reset(settings.id, settings.policy, settings.step_ms);
        self.neighbours.clear();
        (self.step, self.feature) = (None, None);
    }

    /// What it was set up with.
    #[must_use]
    pub const fn settings(&self) -> &AgentSettings {
        &self.settings
    }

    /// The tie-breaker that it announces for `step`, −127 to 127.
    #[must_use]
    pub fn tie_breaker(&self, step: u32) -> i8 {
        tie_breaker(self.settings.policy_seed, self.settings.id, step, self.settings.tie_period)
    }

    /// The beacon that tells others the own state, measured at `now`. `sequence` numbers the
    /// beacons of this UAV and wraps around; with one beacon a step the low half of the step
    /// will do.
    #[must_use]
    pub fn beacon(&self, now: Moment, sequence: u16, own: State) -> Beacon {
        let header = Header { id: self.settings.id, sequence, step: now.step };
        Beacon::new(header, now.time_ms, own, self.tie_breaker(now.step))
    }

    /// Takes in a message that was heard at `now`, with the own position (ticks) at that time.
    pub fn hear(&mut self, message: &Message, own_position: Vec2, now: Moment) -> MessageOutcome {
        self.table.hear(message, own_position, now)
    }

    /// Builds the observation of the step `now`: of the own state, of the neighbours in range,
    /// each where its last beacon says that it is by then, and of the PoIs at the positions
    /// `pois` (ticks; those out of view are left out, their order does not matter).
    pub fn observe<O: BuildObservation>(&mut self, now: Moment, own: State, pois: impl IntoIterator<Item = Vec2>) -> O {
        self.table.view(own.position, now, &mut self.neighbours);
        (self.step, self.feature) = (Some(now.step), None);
        let AgentSettings { id, half_side, .. } = self.settings;
        let tie = self.tie_breaker(now.step);
        O::build(&Scene { id, own, tie, half_side, neighbours: &self.neighbours }, pois)
    }

    /// Encodes the observation of the step observed last. Returns the feature message for the
    /// other UAVs, or `None` when the policy uses no features of others. `sequence` numbers the
    /// features of this UAV as [`Self::beacon`]'s does its beacons.
    ///
    /// # Errors
    /// [`AgentError::OtherActor`], and [`AgentError::NotObserved`] before the first
    /// [`Self::observe`].
    pub fn encode<O: ActorInput>(
        &mut self,
        actor: &QuantisedActor<'_, O>,
        observation: &O,
        sequence: u16,
    ) -> Result<Option<FeatureMessage>, AgentError> {
        self.check(actor)?;
        let step = self.step.ok_or(AgentError::NotObserved)?;
        let feature = self.feature.insert(actor.encode(observation));
        let header = Header { id: self.settings.id, sequence, step };
        Ok(FeatureMessage::from_actor(header, degree(&self.neighbours), actor, feature))
    }

    /// Decides the step observed last, from the own feature and those heard of the neighbours
    /// in range that are young enough. Deciding again gives the same until more is heard.
    ///
    /// # Errors
    /// [`AgentError::OtherActor`], and [`AgentError::NotEncoded`] when the step observed last
    /// was not encoded.
    pub fn decide<O: ActorInput>(&self, actor: &QuantisedActor<'_, O>) -> Result<Decision, AgentError> {
        self.check(actor)?;
        let (Some(step), Some(own)) = (self.step, &self.feature) else { return Err(AgentError::NotEncoded) };
        let heard = self.features().map(|(_, feature)| feature);
        // At most 16.
        let features = heard.clone().count() as u8;
        let logits = actor.logits(own, self.degree(), heard);
        let AgentSettings { id, policy_seed, mode, .. } = self.settings;
        let action = actor.choose(&logits, mode, policy_seed, id, step);
        Ok(Decision { step, action, logits, features })
    }

    /// The step observed last.
    #[must_use]
    pub const fn observed_step(&self) -> Option<u32> {
        self.step
    }

    /// The own feature of the step observed last, once it is encoded.
    #[must_use]
    pub const fn feature(&self) -> Option<&Feature> {
        self.feature.as_ref()
    }

    /// The neighbours in range at the last observation, nearest first.
    #[must_use]
    pub const fn neighbours(&self) -> &Neighbours {
        &self.neighbours
    }

    /// The neighbours in range at the last observation plus the UAV itself, 1 to 17.
    #[must_use]
    pub fn degree(&self) -> u8 {
        degree(&self.neighbours)
    }

    /// The features heard of [`Self::neighbours`] with their ids, in that order. Neighbours
    /// without a feature young enough for the step observed last are left out.
    pub fn features(&self) -> impl Iterator<Item = (u16, NeighbourFeature<'_>)> + Clone {
        // Nobody is in range before the first observation.
        self.table.features(&self.neighbours, self.step.unwrap_or(0))
    }

    /// UAVs that it has heard of lately, in range or not.
    #[must_use]
    pub fn known(&self) -> usize {
        self.table.len()
    }

    fn check<O: ActorInput>(&self, actor: &QuantisedActor<'_, O>) -> Result<(), AgentError> {
        if actor.policy_id() == self.settings.policy { Ok(()) } else { Err(AgentError::OtherActor) }
    }
}

fn degree(neighbours: &Neighbours) -> u8 {
    // At most MAX_NEIGHBOURS + 1.
    neighbours.as_slice().len() as u8 + 1
}
