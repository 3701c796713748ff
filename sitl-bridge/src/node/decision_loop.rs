//! The decision loop: steps, beacons, observation, features, actions.
//!
//! Within a step, by the vehicle's clock: at its start the state is measured and broadcast as a
//! beacon; after [`StepTiming::encode_ms`] the UAV observes, encodes and broadcasts its feature;
//! after [`StepTiming::decide_ms`] it decides. The decision rests on the state at the step's start,
//! as in training; neighbours are taken to be where their beacons put them at that time. The
//! sequence itself is [`firmware_core::agent::Agent`]'s.

use super::counters::Counters;
use super::decision::{Decision, StepStart, observation_hash};
use super::step_timing::StepTiming;
use super::velocity_profile::VelocityProfile;
use crate::mission::{Mission, PoiMap};
use firmware_core::actor::Actor;
use firmware_core::agent::{Agent, AgentError, AgentSettings};
use firmware_core::geometry::State;
use firmware_core::message::Message;
use firmware_core::neighbour_table::Moment;
use firmware_core::observation::Observation;
use std::sync::Arc;

/// Most messages that wait for a step to start: two of each of a large swarm's UAVs.
const MAX_EARLY: usize = 128;
/// A step number ahead of the last by more than this comes from another clock.
const MAX_SKIPPED: u32 = 1000;

/// A measured state on the map, with its time on both clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measurement {
    /// The common clock: Unix time, ms.
    pub common_ms: i64,
    /// `time_boot_ms`.
    pub boot_ms: u32,
    /// Position and velocity, ticks and ticks/step.
    pub state: State,
    /// Velocity east and north, m/s.
    pub velocity_mps: [f64; 2],
}

/// What a measurement led to.
#[derive(Clone, Debug, Default)]
pub(super) struct StepOutput {
    /// The step that started with it.
    pub started: Option<StepStart>,
    /// Messages to broadcast, in this order.
    pub messages: Vec<Message>,
    /// The decision that was due.
    pub decision: Option<Decision>,
}

/// A step under way.
#[derive(Clone, Debug)]
struct Step {
    /// Its number, and the common clock when it started.
    start: Moment,
    start_ms: i64,
    state: State,
    beacons: u32,
    /// Whether it is to be decided: the UAV was in the air when it started, at or after the epoch.
    is_active: bool,
    /// The decision as far as it is known after encoding.
    encoded: Option<Decision>,
    decided: bool,
}

/// Sequence numbers of one kind of message: the next, once one was sent.
#[derive(Clone, Copy, Debug, Default)]
struct Sequence(Option<u16>);

impl Sequence {
    /// The next number. The first follows from the common clock, in tenths of a second, so that a node
    /// that is restarted continues after the numbers that it used before.
    fn next(&mut self, common_ms: i64) -> u16 {
        let sequence = self.0.unwrap_or((common_ms / 100) as u16);
        self.0 = Some(sequence.wrapping_add(1));
        sequence
    }
}

/// Makes the decisions of one UAV.
#[derive(Clone, Debug)]
pub(super) struct DecisionLoop<'a> {
    agent: Agent,
    actor: Actor<'a>,
    mission: Arc<Mission>,
    pois: Arc<PoiMap>,
    timing: StepTiming,
    epoch_ms: Option<i64>,
    step: Option<Step>,
    /// Messages of the next step, which has not started here yet.
    early: Vec<Message>,
    beacon_sequence: Sequence,
    feature_sequence: Sequence,
    profile: Option<VelocityProfile>,
    counters: Counters,
}

impl<'a> DecisionLoop<'a> {
    /// The decision loop of UAV `id`; steps are counted from the mission's epoch. The actor must have
    /// passed its self-test.
    pub fn new(id: u16, actor: Actor<'a>, mission: Arc<Mission>, pois: Arc<PoiMap>, timing: StepTiming) -> Self {
        let settings = AgentSettings {
            mode: mission.mode,
            step_ms: mission.scale.step_ms,
            half_side: mission.half_side(),
            ..AgentSettings::new(&actor, id, mission.policy_seed)
        };
        let epoch_ms = Some(mission.epoch_unix_ms);
        Self {
            agent: Agent::new(settings),
            actor,
            mission,
            pois,
            timing,
            epoch_ms,
            step: None,
            early: Vec::new(),
            beacon_sequence: Sequence::default(),
            feature_sequence: Sequence::default(),
            profile: None,
            counters: Counters::default(),
        }
    }

    /// Steps are counted from this Unix time, ms; with `None` there are no steps.
    pub fn set_epoch(&mut self, epoch_ms: Option<i64>) {
        if self.epoch_ms != epoch_ms {
            self.epoch_ms = epoch_ms;
            self.reset();
        }
    }

    /// The next sequence number of beacons and of features.
    pub const fn set_sequence(&mut self, next: u16) {
        (self.beacon_sequence, self.feature_sequence) = (Sequence(Some(next)), Sequence(Some(next)));
    }

    /// Forgets the step, the decision and the neighbours, when the clock is another one.
    pub fn reset(&mut self) {
        (self.step, self.profile) = (None, None);
        self.early.clear();
        let settings = *self.agent.settings();
        self.agent.reset(settings);
    }

    /// The flight last decided on.
    pub const fn velocity_profile(&self) -> Option<&VelocityProfile> {
        self.profile.as_ref()
    }

    /// Counts of decisions and messages.
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Number of the step under way.
    pub fn step(&self) -> Option<u32> {
        Some(self.step.as_ref()?.start.step)
    }

    /// Number of neighbours in the table, and of those in range when last observed.
    pub fn neighbours(&self) -> (usize, usize) {
        (self.agent.known(), self.agent.neighbours().as_slice().len())
    }

    /// Takes in a neighbour's message; returns whether it was accepted. A message about the next step,
    /// from a neighbour whose clock is a little ahead, waits for that step to start here: who is near
    /// and stays in a full table depends on where this UAV is then.
    pub fn receive(&mut self, message: Message) -> bool {
        let Some(step) = &self.step else { return false };
        if message.header().step == step.start.step.wrapping_add(1) && self.early.len() < MAX_EARLY {
            self.early.push(message);
            return true;
        }
        self.hear(&message)
    }

    fn hear(&mut self, message: &Message) -> bool {
        let Some(step) = &self.step else { return false };
        let outcome = self.agent.hear(message, step.state.position, step.start);
        self.counters.count_message(outcome);
        outcome.is_taken()
    }

    /// Takes in a measurement. On the ground (not `airborne`) the UAV broadcasts and decides nothing.
    ///
    /// # Errors
    /// The agent was called out of order, which would be a fault in this module.
    pub fn update(&mut self, measured: &Measurement, airborne: bool) -> Result<StepOutput, AgentError> {
        let mut output = StepOutput::default();
        let Some(epoch_ms) = self.epoch_ms else { return Ok(output) };
        let since_ms = measured.common_ms - epoch_ms;
        let step_ms = i64::from(self.mission.scale.step_ms);
        // Steps have numbers before step 0 too, so that neighbours who start earlier are heard.
        let (number, phase_ms) = (since_ms.div_euclid(step_ms) as u32, since_ms.rem_euclid(step_ms));
        if self.step() != Some(number) {
            let started = self.start_step(number, measured, airborne && since_ms >= 0);
            output.started = (since_ms >= 0).then_some(started);
        }
        if airborne && let Some(mut step) = self.step.take_if(|step| step.is_active) {
            let run = self.run_phases(&mut step, phase_ms, measured, &mut output);
            self.counters.sent += output.messages.len() as u64;
            self.step = Some(step);
            run?;
        }
        Ok(output)
    }

    fn start_step(&mut self, number: u32, measured: &Measurement, is_active: bool) -> StepStart {
        if let Some(last) = self.step.take().filter(|last| last.is_active && is_active) {
            let passed = number.wrapping_sub(last.start.step);
            let skipped = if passed <= MAX_SKIPPED { u64::from(passed.saturating_sub(1)) } else { 0 };
            self.counters.missed_decisions += skipped + u64::from(!last.decided);
        }
        self.step = Some(Step {
            start: Moment { step: number, time_ms: measured.common_ms as u32 },
            start_ms: measured.common_ms,
            state: measured.state,
            beacons: 0,
            is_active,
            encoded: None,
            decided: false,
        });
        for message in std::mem::take(&mut self.early) {
            self.hear(&message);
        }
        StepStart { step: number, state: measured.state, common_ms: measured.common_ms }
    }

    /// Broadcasts, encodes and decides what is due `phase_ms` after the step's start.
    fn run_phases(
        &mut self,
        step: &mut Step,
        phase_ms: i64,
        measured: &Measurement,
        output: &mut StepOutput,
    ) -> Result<(), AgentError> {
        let passed_ms = measured.common_ms - step.start_ms;
        let due = self.timing.beacon_ms.map_or(0, |every| passed_ms / i64::from(every.max(1)));
        if i64::from(step.beacons) <= due {
            step.beacons = due as u32 + 1;
            let now = Moment { step: step.start.step, time_ms: measured.common_ms as u32 };
            let sequence = self.beacon_sequence.next(measured.common_ms);
            output.messages.push(Message::Beacon(self.agent.beacon(now, sequence, measured.state)));
        }
        if step.encoded.is_none() && phase_ms >= i64::from(self.timing.encode_ms) {
            let pois = self.pois.seen_from(step.state.position);
            let observation: Observation = self.agent.observe(step.start, step.state, pois);
            let sequence = self.feature_sequence.next(measured.common_ms);
            let feature = self.agent.encode(&self.actor, &observation, sequence)?;
            output.messages.extend(feature.map(Message::Feature));
            let mut decision = Decision::new(step.start.step, step.state, observation_hash(&observation));
            decision.set_neighbours(self.agent.neighbours().as_slice().iter().map(|n| n.id));
            step.encoded = Some(decision);
        }
        if !step.decided
            && phase_ms >= i64::from(self.timing.decide_ms)
            && let Some(mut decision) = step.encoded
        {
            let decided = self.agent.decide(&self.actor)?;
            (decision.features, decision.action) = (decided.features, decided.action.index());
            decision.boot_ms = measured.boot_ms;
            decision.phase_ms = phase_ms as u32;
            decision.late = phase_ms > i64::from(self.timing.decide_ms) + i64::from(self.timing.telemetry_ms);
            self.counters.decisions += 1;
            self.counters.late_decisions += u64::from(decision.late);
            let (observed, scale) = (step.state.velocity, self.mission.scale);
            self.profile =
                Some(VelocityProfile::new(decided.action, measured.boot_ms, observed, measured.velocity_mps, scale));
            output.decision = Some(decision);
            step.decided = true;
        }
        Ok(())
    }
}
