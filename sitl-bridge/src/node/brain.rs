//! The part of a node that decides: steps, neighbours, observation, action.
//!
//! Within a step, by the vehicle's clock: at its beginning the state is measured and told to
//! the others; after [`Timing::encode_ms`] the UAV looks around, encodes what it sees and tells
//! that; after [`Timing::decide_ms`] it decides. What it decides on is the state at the step's
//! beginning, as in training; neighbours are taken to be where their beacons put them then.

use super::plan::Plan;
use super::record::{Counters, Decision, StepBegun, observation_hash};
use crate::mission::{Mission, PoiMap};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Feature};
use firmware_core::geometry::State;
use firmware_core::message::{self, Beacon, Header, Message};
use firmware_core::neighbour_table::{Moment, NeighbourTable};
use firmware_core::observation::{Neighbours, Scene, observe};
use std::sync::Arc;

/// Most messages that wait for a step to begin: two of each of a large swarm's UAVs.
const MAX_EARLY: usize = 128;

/// When things happen in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// From a step's beginning until it encodes, ms.
    pub encode_ms: u16,
    /// From a step's beginning until it decides, ms.
    pub decide_ms: u16,
    /// Between beacons, ms; none but the step's own when it is `None`.
    pub beacon_ms: Option<u16>,
    /// Between two positions from the autopilot, ms.
    pub telemetry_ms: u16,
}

impl Default for Timing {
    fn default() -> Self {
        Self { encode_ms: 400, decide_ms: 800, beacon_ms: None, telemetry_ms: 200 }
    }
}

/// A measured state in the swarm's terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Common clock: Unix time, ms.
    pub common_ms: i64,
    /// Vehicle's clock, ms.
    pub boot_ms: u32,
    /// Position and velocity, ticks and ticks/step.
    pub state: State,
    /// Velocity east and north, m/s.
    pub velocity_mps: [f64; 2],
}

/// What a sample led to.
#[derive(Clone, Debug, Default)]
pub struct Thought {
    /// A step began with it.
    pub begun: Option<StepBegun>,
    /// To be told to the others, in this order.
    pub messages: Vec<Message>,
    /// It decided.
    pub decision: Option<Decision>,
}

/// Messages are counted by their kind.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Beacon,
    Feature,
}

/// A step under way.
#[derive(Clone, Debug)]
struct Step {
    moment: Moment,
    begun_ms: i64,
    state: State,
    beacons: u32,
    /// Whether the UAV was in the air when it began, at or after the epoch: else it is not
    /// one to decide in.
    counts: bool,
    encoded: Option<Encoded>,
    decided: bool,
}

#[derive(Clone, Debug)]
struct Encoded {
    feature: Feature,
    degree: u8,
    decision: Decision,
}

/// What decides for one UAV.
#[derive(Clone, Debug)]
pub struct Brain<'a> {
    id: u16,
    actor: Actor<'a>,
    mission: Arc<Mission>,
    pois: Arc<PoiMap>,
    timing: Timing,
    epoch_ms: Option<i64>,
    table: NeighbourTable,
    view: Neighbours,
    step: Option<Step>,
    /// Messages of steps that have not begun here yet.
    early: Vec<Message>,
    /// Next sequence numbers of beacons and of features, once one was sent.
    sequences: [Option<u16>; 2],
    plan: Option<Plan>,
    /// Counts.
    pub counters: Counters,
}

impl<'a> Brain<'a> {
    /// The brain of UAV `id`; steps are counted from the mission's epoch. The actor must have
    /// passed its self-test.
    #[must_use]
    pub fn new(id: u16, actor: Actor<'a>, mission: Arc<Mission>, pois: Arc<PoiMap>, timing: Timing) -> Self {
        let table = NeighbourTable::new(id, actor.policy_id(), mission.scale.step_ms);
        let epoch_ms = Some(mission.epoch_unix_ms);
        Self {
            id,
            actor,
            mission,
            pois,
            timing,
            epoch_ms,
            table,
            view: Neighbours::new(),
            step: None,
            early: Vec::new(),
            sequences: [None; 2],
            plan: None,
            counters: Counters::default(),
        }
    }

    /// Steps are counted from this Unix time, ms; with `None` there are none.
    pub fn set_epoch(&mut self, epoch_ms: Option<i64>) {
        if self.epoch_ms != epoch_ms {
            self.epoch_ms = epoch_ms;
            self.forget();
        }
    }

    /// Sequence numbers go on from here. Otherwise they begin with the common clock, in tenths
    /// of a second, so that a node that starts again is newer than it was.
    pub const fn set_sequence(&mut self, next: u16) {
        self.sequences = [Some(next); 2];
    }

    /// Forgets the step, the plan and the neighbours: the clock is another one.
    pub fn forget(&mut self) {
        (self.step, self.plan) = (None, None);
        self.early.clear();
        self.table.reset(self.id, self.actor.policy_id(), self.mission.scale.step_ms);
    }

    /// The flight last decided on.
    #[must_use]
    pub const fn plan(&self) -> Option<&Plan> {
        self.plan.as_ref()
    }

    /// The step under way.
    #[must_use]
    pub fn step(&self) -> Option<u32> {
        Some(self.step.as_ref()?.moment.step)
    }

    /// UAVs in the neighbour table, in range or not, and those in view when last looked.
    #[must_use]
    pub fn neighbours(&self) -> (usize, usize) {
        (self.table.len(), self.view.as_slice().len())
    }

    /// Takes in a message; returns whether it was taken. What a neighbour whose clock is a
    /// little ahead says about the next step waits for that step to begin here: who is near
    /// and stays in a full table is judged by where this UAV is then.
    pub fn hear(&mut self, message: Message) -> bool {
        let Some(step) = &self.step else { return false };
        if message.header().step == step.moment.step.wrapping_add(1) && self.early.len() < MAX_EARLY {
            self.early.push(message);
            return true;
        }
        self.tabulate(&message)
    }

    fn tabulate(&mut self, message: &Message) -> bool {
        let Some(step) = &self.step else { return false };
        let answer = self.table.hear(message, step.state.position, step.moment);
        self.counters.answer(answer);
        answer.is_taken()
    }

    /// Takes in a measured state. `flies` says whether the UAV is in the air: on the ground it
    /// tells nobody where it is and decides nothing.
    pub fn think(&mut self, sample: &Sample, flies: bool) -> Thought {
        let mut thought = Thought::default();
        let Some(epoch_ms) = self.epoch_ms else { return thought };
        let since_ms = sample.common_ms - epoch_ms;
        let step_ms = i64::from(self.mission.scale.step_ms);
        // Before step 0 steps have numbers too, so that who begins first is heard.
        let (number, phase_ms) = (since_ms.div_euclid(step_ms) as u32, since_ms.rem_euclid(step_ms));
        if self.step() != Some(number) {
            let begun = self.begin(number, sample, flies && since_ms >= 0);
            thought.begun = (since_ms >= 0).then_some(begun);
        }
        if flies {
            self.act(phase_ms, sample, &mut thought);
        }
        thought
    }

    /// `counts` says whether it is one to decide in.
    fn begin(&mut self, number: u32, sample: &Sample, counts: bool) -> StepBegun {
        if let Some(last) = self.step.take().filter(|last| last.counts && counts) {
            let passed = number.wrapping_sub(last.moment.step);
            // More than this is another clock, not a pause.
            let skipped = if passed <= 1000 { u64::from(passed.saturating_sub(1)) } else { 0 };
            self.counters.missed_decisions += skipped + u64::from(!last.decided);
        }
        let moment = Moment { step: number, time_ms: sample.common_ms as u32 };
        self.step = Some(Step {
            moment,
            begun_ms: sample.common_ms,
            state: sample.state,
            beacons: 0,
            counts,
            encoded: None,
            decided: false,
        });
        for message in std::mem::take(&mut self.early) {
            self.tabulate(&message);
        }
        StepBegun { step: number, state: sample.state, common_ms: sample.common_ms }
    }

    fn act(&mut self, phase_ms: i64, sample: &Sample, thought: &mut Thought) {
        let Some(mut step) = self.step.take_if(|step| step.counts) else { return };
        let due = self.timing.beacon_ms.map_or(0, |every| (sample.common_ms - step.begun_ms) / i64::from(every.max(1)));
        if i64::from(step.beacons) <= due {
            step.beacons = due as u32 + 1;
            let tie = self.actor.tie_breaker(self.mission.policy_seed, self.id, step.moment.step);
            let header = self.header(Kind::Beacon, step.moment.step, sample.common_ms);
            thought.messages.push(Message::Beacon(Beacon::new(header, sample.common_ms as u32, sample.state, tie)));
        }
        if step.encoded.is_none() && phase_ms >= i64::from(self.timing.encode_ms) {
            let encoded = self.encode(&step);
            let header = self.header(Kind::Feature, step.moment.step, sample.common_ms);
            let feature = message::FeatureMessage::from_actor(header, encoded.degree, &self.actor, &encoded.feature);
            thought.messages.extend(feature.map(Message::Feature));
            step.encoded = Some(encoded);
        }
        if !step.decided
            && phase_ms >= i64::from(self.timing.decide_ms)
            && let Some(encoded) = &step.encoded
        {
            let mut decision = self.decide(step.moment.step, encoded);
            decision.boot_ms = sample.boot_ms;
            decision.phase_ms = phase_ms as u32;
            decision.late = phase_ms > i64::from(self.timing.decide_ms) + i64::from(self.timing.telemetry_ms);
            self.counters.decisions += 1;
            self.counters.late_decisions += u64::from(decision.late);
            let action = Action::new(decision.action).unwrap_or(Action::COAST);
            let scale = self.mission.scale;
            self.plan = Some(Plan::new(action, sample.boot_ms, step.state.velocity, sample.velocity_mps, scale));
            thought.decision = Some(decision);
            step.decided = true;
        }
        self.counters.sent += thought.messages.len() as u64;
        self.step = Some(step);
    }

    fn encode(&mut self, step: &Step) -> Encoded {
        let position = step.state.position;
        self.table.view(position, step.moment, &mut self.view);
        let tie = self.actor.tie_breaker(self.mission.policy_seed, self.id, step.moment.step);
        let half_side = self.mission.half_side();
        let scene = Scene { id: self.id, own: step.state, tie, half_side, neighbours: &self.view };
        let observation = observe(&scene, self.pois.seen_from(position));
        let mut decision = Decision::new(step.moment.step, step.state, observation_hash(&observation));
        let seen = self.view.as_slice();
        decision.set_neighbours(seen.iter().map(|n| n.id));
        // At most 16 neighbours are seen.
        Encoded { feature: self.actor.encode(&observation), degree: seen.len() as u8 + 1, decision }
    }

    fn decide(&self, step: u32, encoded: &Encoded) -> Decision {
        let heard = self.table.features(&self.view, step).map(|(_, feature)| feature);
        let features = heard.clone().count() as u8;
        let logits = self.actor.logits(&encoded.feature, encoded.degree, heard);
        let action = self.actor.choose(&logits, self.mission.mode, self.mission.policy_seed, self.id, step);
        let mut decision = encoded.decision;
        (decision.features, decision.action) = (features, action.index());
        decision
    }

    fn header(&mut self, kind: Kind, step: u32, common_ms: i64) -> Header {
        let next = &mut self.sequences[kind as usize];
        let sequence = next.unwrap_or((common_ms / 100) as u16);
        *next = Some(sequence.wrapping_add(1));
        Header { id: self.id, sequence, step }
    }
}
