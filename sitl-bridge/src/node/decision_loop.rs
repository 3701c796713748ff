//! The decision loop: steps, beacons, observation, features, actions.
//!
//! Within a step: at its start the state is measured and broadcast as a beacon. Once the beacons of all
//! who are expected were heard, the UAV observes, encodes and broadcasts its feature; once the features of
//! those observed were heard, it decides. What is still missing [`StepTiming::encode_ms`] and
//! [`StepTiming::decide_ms`] after the start, by the vehicle's clock, is not waited for. The decision
//! rests on the state at the step's start, as in training; neighbours are taken to be where their beacons
//! put them at that time. The sequence itself is [`firmware_core::agent::Agent`]'s, who is awaited
//! [`RollCall`]'s.

use super::counters::Counters;
use super::decision::{Decision, StepStart, observation_hash};
use super::decision_step::{Measurement, Sequence, Step, StepOutput};
use super::roll_call::RollCall;
use super::step_timing::{Pace, StepTiming};
use super::velocity_profile::VelocityProfile;
use crate::mission::{Mission, PoiMap};
use firmware_core::actor::Actor;
use firmware_core::agent::{Agent, AgentError, AgentSettings};
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::Message;
use firmware_core::neighbour_table::Moment;
use firmware_core::observation::Observation;
use std::sync::Arc;

/// Most messages that wait for a step to start: two of each of a large swarm's UAVs.
const MAX_EARLY: usize = 128;
/// A setpoint counts as the last for so long, ms of the vehicle's clock.
const COMMANDED_MS: i32 = 1000;
/// A step number ahead of the last by more than this comes from another clock.
const MAX_SKIPPED: u32 = 1000;

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
    /// The newest measurement, in the air.
    newest: Option<Measurement>,
    roll_call: RollCall,
    /// Messages of the next step, which has not started here yet.
    early: Vec<Message>,
    beacon_sequence: Sequence,
    feature_sequence: Sequence,
    profile: Option<VelocityProfile>,
    /// `time_boot_ms` and velocity east and north (m/s) of the setpoint that was sent last.
    commanded: Option<(u32, [f64; 2])>,
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
            newest: None,
            roll_call: RollCall::default(),
            early: Vec::new(),
            beacon_sequence: Sequence::default(),
            feature_sequence: Sequence::default(),
            profile: None,
            commanded: None,
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
        (self.step, self.newest, self.profile, self.commanded) = (None, None, None, None);
        self.early.clear();
        self.roll_call.clear();
        let settings = *self.agent.settings();
        self.agent.reset(settings);
    }

    /// The flight last decided on.
    pub const fn velocity_profile(&self) -> Option<&VelocityProfile> {
        self.profile.as_ref()
    }

    /// Notes a setpoint that was sent at `boot_ms` with this velocity east and north, m/s.
    pub const fn commanded(&mut self, boot_ms: u32, velocity_mps: [f64; 2]) {
        self.commanded = Some((boot_ms, velocity_mps));
    }

    /// Where the flight of a decision begins: with the last setpoint, so that there is no step between
    /// setpoints though the vehicle is behind; with what was measured when there was none lately.
    fn flight_start(&self, measured: &Measurement) -> (u32, [f64; 2]) {
        let lately = |at: u32| measured.boot_ms.wrapping_sub(at).cast_signed() <= COMMANDED_MS;
        let commanded = self.commanded.filter(|&(at, _)| lately(at) && self.timing.pace != Pace::Deadlines);
        commanded.unwrap_or((measured.boot_ms, measured.velocity_mps))
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
        self.roll_call.hear(message, outcome);
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
        self.newest = airborne.then_some(*measured);
        self.run_phases(phase_ms, measured, &mut output)?;
        Ok(output)
    }

    /// Runs the phases for which the neighbours' messages since the last measurement were the last awaited.
    ///
    /// # Errors
    /// The agent was called out of order, which would be a fault in this module.
    pub fn proceed(&mut self) -> Result<StepOutput, AgentError> {
        let mut output = StepOutput::default();
        if let (Some(epoch_ms), Some(measured), false) =
            (self.epoch_ms, self.newest, self.timing.pace == Pace::Deadlines)
        {
            let phase_ms = (measured.common_ms - epoch_ms).rem_euclid(i64::from(self.mission.scale.step_ms));
            self.run_phases(phase_ms, &measured, &mut output)?;
        }
        Ok(output)
    }

    /// Whether nothing but messages of neighbours, which have to be under way, keeps the UAV from deciding.
    pub fn awaits_messages(&self) -> bool {
        let step = self.step.as_ref().filter(|step| step.is_active && !step.decided && self.newest.is_some());
        step.is_some_and(|step| step.encoded.is_some() || step.knows_others)
    }

    fn start_step(&mut self, number: u32, measured: &Measurement, is_active: bool) -> StepStart {
        let mut knows_others = false;
        if let Some(last) = self.step.take().filter(|last| last.is_active && is_active) {
            let passed = number.wrapping_sub(last.start.step);
            let skipped = if passed <= MAX_SKIPPED { u64::from(passed.saturating_sub(1)) } else { 0 };
            self.counters.missed_decisions += skipped + u64::from(!last.decided);
            knows_others = passed == 1;
        }
        self.roll_call.begin_step(number);
        self.step = Some(Step {
            start: Moment { step: number, time_ms: measured.common_ms as u32 },
            start_ms: measured.common_ms,
            state: self.led(measured.state),
            beacons: 0,
            is_active,
            knows_others,
            encoded: None,
            uses_features: false,
            decided: false,
        });
        for message in std::mem::take(&mut self.early) {
            self.hear(&message);
        }
        StepStart { step: number, state: measured.state, common_ms: measured.common_ms }
    }

    /// The state that is observed and broadcast: see [`StepTiming::lead_ms`]. On the map it stays there.
    fn led(&self, measured: State) -> State {
        let side = 2 * self.agent.settings().half_side;
        let share = f64::from(self.timing.lead_ms) / f64::from(self.mission.scale.step_ms);
        let ahead = |position: i32, velocity: i32| {
            let led = position.saturating_add((f64::from(velocity) * share).round() as i32);
            if (0..=side).contains(&position) { led.clamp(0, side) } else { led }
        };
        let State { position, velocity } = measured;
        State { position: Vec2 { x: ahead(position.x, velocity.x), y: ahead(position.y, velocity.y) }, velocity }
    }

    /// Broadcasts, encodes and decides what is due `phase_ms` after the step's start.
    fn run_phases(&mut self, phase_ms: i64, measured: &Measurement, output: &mut StepOutput) -> Result<(), AgentError> {
        let Some(mut step) = self.step.take_if(|step| step.is_active) else { return Ok(()) };
        if self.newest.is_none() {
            self.step = Some(step);
            return Ok(());
        }
        self.broadcast(&mut step, measured, output);
        let mut run = Ok(());
        if step.encoded.is_none() && self.may_encode(&step, phase_ms) {
            run = self.encode(&mut step, measured, output);
        }
        if run.is_ok()
            && let Some(decision) = step.encoded.filter(|_| !step.decided && self.may_decide(&step, phase_ms))
        {
            run = self.decide(decision, phase_ms, measured, output);
            step.decided = run.is_ok();
        }
        self.counters.sent += output.messages.len() as u64;
        self.step = Some(step);
        run
    }

    fn may_encode(&self, step: &Step, phase_ms: i64) -> bool {
        let all_heard = || !self.roll_call.awaits_beacon(step.start.step, step.state.position);
        let early = self.timing.pace != Pace::Deadlines && step.knows_others;
        phase_ms >= i64::from(self.timing.encode_ms) || (early && all_heard())
    }

    fn may_decide(&self, step: &Step, phase_ms: i64) -> bool {
        let neighbours = self.agent.neighbours().as_slice().iter().map(|n| n.id);
        let all_heard = || !step.uses_features || !self.roll_call.awaits_feature(step.start.step, neighbours);
        phase_ms >= i64::from(self.timing.decide_ms) || (self.timing.pace != Pace::Deadlines && all_heard())
    }

    fn broadcast(&mut self, step: &mut Step, measured: &Measurement, output: &mut StepOutput) {
        let passed_ms = measured.common_ms - step.start_ms;
        let due = self.timing.beacon_ms.map_or(0, |every| passed_ms / i64::from(every.max(1)));
        if i64::from(step.beacons) <= due {
            step.beacons = due as u32 + 1;
            let now = Moment { step: step.start.step, time_ms: measured.common_ms as u32 };
            let sequence = self.beacon_sequence.next(measured.common_ms);
            output.messages.push(Message::Beacon(self.agent.beacon(now, sequence, self.led(measured.state))));
        }
    }

    fn encode(&mut self, step: &mut Step, measured: &Measurement, output: &mut StepOutput) -> Result<(), AgentError> {
        let pois = self.pois.seen_from(step.state.position);
        let observation: Observation = self.agent.observe(step.start, step.state, pois);
        let sequence = self.feature_sequence.next(measured.common_ms);
        let feature = self.agent.encode(&self.actor, &observation, sequence)?;
        step.uses_features = feature.is_some();
        output.messages.extend(feature.map(Message::Feature));
        let mut decision = Decision::new(step.start.step, step.state, observation_hash(&observation));
        decision.set_neighbours(self.agent.neighbours().as_slice().iter().map(|n| n.id));
        step.encoded = Some(decision);
        Ok(())
    }

    fn decide(
        &mut self,
        mut decision: Decision,
        phase_ms: i64,
        measured: &Measurement,
        output: &mut StepOutput,
    ) -> Result<(), AgentError> {
        let decided = self.agent.decide(&self.actor)?;
        (decision.features, decision.action) = (decided.features, decided.action.index());
        decision.boot_ms = measured.boot_ms;
        decision.phase_ms = phase_ms as u32;
        decision.late = phase_ms > i64::from(self.timing.decide_ms) + i64::from(self.timing.telemetry_ms);
        self.counters.decisions += 1;
        self.counters.decision_ms += u64::from(decision.phase_ms);
        self.counters.late_decisions += u64::from(decision.late);
        let (observed, scale) = (decision.state.velocity, self.mission.scale);
        let (from_ms, from_mps) = self.flight_start(measured);
        self.profile = Some(VelocityProfile::new(decided.action, from_ms, observed, from_mps, scale));
        output.decision = Some(decision);
        Ok(())
    }
}
