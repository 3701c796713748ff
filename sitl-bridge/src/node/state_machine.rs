//! The state machine of a node.

use super::autopilot_link::AutopilotLink;
use super::counters::Counters;
use super::decision_loop::DecisionLoop;
use super::decision_step::{Measurement, StepOutput};
use super::ending::{Ending, last_setpoint};
use super::gate_driver::{GateDriver, SetpointFilter};
use super::gate_inputs::{GateContext, gate_inputs};
use super::height_check::HeightCheck;
use super::host_clock::HostClockFallback;
use super::host_time::HostTime;
use super::link_monitor::LinkMonitor;
use super::muster::Muster;
use super::output::NodeOutput;
use super::refusals::{Link, Refusals};
use super::settings::{Settings, SettingsError};
use super::status::Status;
use super::step_timing::Pace;
use super::timebase::Timebase;
use super::velocity_profile::VelocityProfile;
use crate::autopilot::{Autopilot, Notice, Odometry, Stage, TelemetryUpdate, VehicleState};
use crate::frame::Frame;
use crate::messages::{Payload, SetPositionTargetLocalNed, Telemetry, heartbeat};
use crate::signing::Session;
use crate::swarm_link::{COMPONENT, SwarmLink};
use firmware_core::agent::AgentError;
use firmware_core::gate::{Gate, Phase, Verdict};
use firmware_core::geometry::State;

/// Between two HEARTBEATs of the node, ms.
const HEARTBEAT_MS: i64 = 1000;

/// Flies one UAV.
#[derive(Debug)]
pub struct Node<'a> {
    pub(super) settings: Settings<'a>,
    pub(super) autopilot: Autopilot,
    autopilot_link: AutopilotLink,
    pub(super) swarm_link: SwarmLink,
    session: Session,
    decisions: DecisionLoop<'a>,
    pub(super) gate: GateDriver,
    pub(super) height_check: HeightCheck,
    pub(super) muster: Muster,
    /// Heights and other UAVs are looked at before a start, and the height after the climb.
    pub(super) start_checks: bool,
    links: LinkMonitor,
    refusals: [Refusals; 2],
    pub(super) timebase: Timebase,
    host_clock: HostClockFallback,
    /// Whether the operator, or the pilot's takeoff, has started the mission.
    pub(super) started: bool,
    /// That the vehicle stands at another place than the mission's was told.
    pub(super) place_told: bool,
    /// The vehicle is being braked, to be let go.
    pub(super) ending: Option<Ending>,
    /// Notices of what the operator asked for, until the next turn.
    pub(super) answers: Vec<Notice>,
    /// When the last HEARTBEAT was sent, ms of the node's clock.
    heartbeat_ms: i64,
}

impl<'a> Node<'a> {
    /// A node that has received nothing yet. With [`Settings::take_off`] it brings its vehicle into
    /// flight as soon as it can; otherwise it flies the mission once the pilot has taken off and
    /// changed to the mode that follows setpoints.
    ///
    /// # Errors
    /// See [`SettingsError`].
    pub fn new(settings: Settings<'a>, session: Session) -> Result<Self, SettingsError> {
        let mission = &settings.mission;
        let gate = Gate::new(settings.limits, mission.gate_fence()?)?;
        let swarm_link = SwarmLink::new(settings.id, settings.swarm_signing.clone())?;
        let layer_mm = mission.plane.alt_mm.saturating_add(mission.layers.altitude_mm(settings.id));
        let autopilot = Autopilot::new(
            VehicleState::new(mission.plane),
            layer_mm,
            settings.rate_hz,
            settings.vehicle_system,
            (settings.system, COMPONENT),
            settings.reliance(),
        );
        let decisions = DecisionLoop::new(
            settings.id,
            settings.actor,
            settings.mission.clone(),
            settings.pois.clone(),
            settings.timing,
        );
        let mut node = Self {
            autopilot,
            autopilot_link: AutopilotLink::new(settings.system, settings.source, settings.autopilot_signing.clone()),
            swarm_link,
            session,
            decisions,
            gate: GateDriver::new(gate),
            height_check: HeightCheck::new(settings.mission.heights.check_m),
            muster: Muster::new(&settings),
            start_checks: true,
            links: LinkMonitor::default(),
            refusals: [Link::Autopilot, Link::Swarm].map(Refusals::new),
            timebase: Timebase::default(),
            host_clock: HostClockFallback::default(),
            started: false,
            place_told: false,
            ending: None,
            answers: Vec::new(),
            heartbeat_ms: i64::MIN / 2,
            settings,
        };
        if node.settings.take_off {
            node.begin(false);
        }
        Ok(node)
    }

    /// Counts steps from this Unix time, ms, instead of the mission's epoch; with `None` there are no
    /// steps.
    pub fn set_epoch(&mut self, epoch_ms: Option<i64>) {
        self.decisions.set_epoch(epoch_ms);
    }

    /// The next sequence number of neighbour messages.
    pub const fn set_sequence(&mut self, next: u16) {
        self.decisions.set_sequence(next);
    }

    /// The UAV's id.
    #[must_use]
    pub const fn id(&self) -> u16 {
        self.settings.id
    }

    /// How far the work with the autopilot has come.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        self.autopilot.stage()
    }

    /// Whether the vehicle is in the air.
    #[must_use]
    pub const fn is_airborne(&self) -> bool {
        self.autopilot.is_airborne()
    }

    /// The safety gate's last verdict.
    pub const fn verdict(&self) -> Verdict {
        self.gate.verdict()
    }

    /// The safety gate's phase.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.gate.phase()
    }

    /// The flight last decided on.
    #[must_use]
    pub const fn velocity_profile(&self) -> Option<&VelocityProfile> {
        self.decisions.velocity_profile()
    }

    /// The common clock at the newest telemetry: Unix time, ms.
    #[must_use]
    pub fn common_ms(&self) -> Option<i64> {
        let clock = &self.autopilot.state.clock;
        clock.common_ms(clock.newest()?)
    }

    /// Counts so far, with those of the links.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let mut counters = self.decisions.counters().clone();
        counters.add(self.gate.counters());
        let mut rejected = self.swarm_link.counts();
        rejected += &self.autopilot_link.rejected();
        for (reason, count) in rejected.iter() {
            *counters.rejected.entry(reason.name()).or_default() += count;
        }
        counters
    }

    /// A status for people.
    #[must_use]
    pub fn status(&self, now: HostTime) -> Status {
        let vehicle = &self.autopilot.state;
        let origin_mm = self.settings.mission.plane.alt_mm;
        Status {
            id: self.settings.id,
            stage: self.autopilot.stage(),
            mode: self.autopilot.mode_name(),
            gate: self.gate.verdict().name(),
            reason: self.gate.verdict().reason(),
            state: vehicle.odometry.map(|odometry| self.map_state(&odometry)),
            altitude_m: vehicle.odometry.map(|odometry| f64::from(odometry.alt_mm - origin_mm) / 1000.0),
            step: self.decisions.step(),
            link_ms: self.links.autopilot_age_ms(now),
            swarm_ms: self.links.swarm_age_ms(now),
            neighbours: self.decisions.neighbours(),
            battery: vehicle.battery_percent(),
        }
    }

    /// Drops a frame whose end was lost, when the autopilot's stream was cut off and is connected again.
    pub fn reconnected(&mut self) {
        self.autopilot_link.reset();
    }

    /// Takes in bytes from the autopilot's link. Returns whether an authentic frame of the autopilot
    /// was among them, so that their sender is the one to send to.
    pub fn receive_autopilot(&mut self, bytes: &[u8], now: HostTime, out: &mut NodeOutput) -> bool {
        let mut is_autopilot = false;
        self.autopilot_link.push(bytes);
        while let Some(frame) = self.autopilot_link.next_frame(&mut self.session, now) {
            if self.settings.record {
                out.received.push(frame);
            }
            if let Some(telemetry) = Telemetry::read(frame.message_id(), frame.payload()) {
                self.handle_telemetry(&frame, &telemetry, now, out);
            }
            is_autopilot |= self.autopilot.target() == Some((frame.system(), frame.component()));
        }
        is_autopilot
    }

    /// Takes in a datagram from the swarm's link.
    pub fn receive_swarm(&mut self, datagram: &[u8], now: HostTime, out: &mut NodeOutput) {
        self.swarm_link.push(datagram);
        while let Some(neighbour) = self.swarm_link.next_message(&mut self.session, now.timestamp()) {
            if self.settings.record {
                out.received.push(neighbour.frame);
            }
            let id = neighbour.message.header().id;
            let warning = self.muster.hear(id, self.timebase.now_ms());
            out.notices.extend(warning);
            if self.decisions.receive(neighbour.message) {
                self.links.swarm_heard(self.autopilot.state.now_ms(), now);
            }
            let step = self.decisions.proceed();
            let decided = self.take_step(step, now, out);
            if self.gate.owes_answer() {
                self.answer_unless_held(now, out);
            } else if decided {
                self.ask_gate(now, SetpointFilter::Any, out);
            }
        }
    }

    /// Runs the node's timers. To be called after each turn of receiving, and at least every 50 ms.
    pub fn tick(&mut self, now: HostTime, out: &mut NodeOutput) {
        self.advance_clock(now);
        out.notices.append(&mut self.answers);
        let advice = self.autopilot.advice();
        let advice = advice.as_deref().unwrap_or(&self.settings.advice);
        out.notices.extend(self.links.check_silence(now, advice));
        self.report_refusals(now, out);
        // When positions cease the gate is asked all the same.
        if let Some(filter) = self.gate.overdue(self.autopilot.state.now_ms(), now) {
            self.ask_gate(now, filter, out);
        }
        if self.gate.owes_answer_since(now) {
            self.answer(now, out);
        }
        self.send_heartbeat(now, out);
        self.poll_autopilot(now, out);
    }

    /// Tells of frames that signing refused.
    fn report_refusals(&mut self, now: HostTime, out: &mut NodeOutput) {
        let [autopilot, swarm] = &mut self.refusals;
        autopilot.update(&self.autopilot_link.rejected(), now, &mut out.notices);
        swarm.update(&self.swarm_link.counts(), now, &mut out.notices);
        out.notices.extend(self.autopilot_link.keyless_notice());
        if self.session.takes_far_future() {
            out.notices.push(Notice::warning(
                "signatures come with times more than a day ahead of this computer's clock, and are not followed: \
                 set its clock, or the sender's",
            ));
        }
    }

    fn advance_clock(&mut self, now: HostTime) {
        self.links.start(now);
        let clock = &self.autopilot.state.clock;
        let vehicle_ms = clock.newest().and_then(|newest| clock.extend(newest));
        self.timebase.advance(vehicle_ms, now.wall_ms);
    }

    fn handle_telemetry(&mut self, frame: &Frame, telemetry: &Telemetry, now: HostTime, out: &mut NodeOutput) {
        let from = (frame.system(), frame.component());
        let control = |autopilot: &Autopilot| (autopilot.mode(), autopilot.is_armed());
        let before = control(&self.autopilot);
        let update = self.autopilot.handle(from, telemetry, self.timebase.now_ms(), &mut out.notices);
        if self.autopilot.target() == Some(from) {
            out.notices.extend(self.links.autopilot_heard(now));
        }
        self.advance_clock(now);
        match update {
            // The gate has to know that the pilot took over before anything more is commanded.
            TelemetryUpdate::Other if control(&self.autopilot) != before => {
                self.ask_gate(now, SetpointFilter::NewVerdict, out);
            }
            TelemetryUpdate::Other | TelemetryUpdate::ClockCorrected(_) | TelemetryUpdate::ClockRate(_) => {}
            TelemetryUpdate::Rebooted => self.decisions.reset(),
            TelemetryUpdate::Odometry => self.handle_odometry(now, out),
        }
    }

    /// The height by the GPS against that by the estimator, once the vehicle is up.
    fn check_height(&mut self, out: &mut NodeOutput) {
        if !self.start_checks {
            return;
        }
        let airborne = self.autopilot.is_airborne();
        out.notices.extend(self.height_check.update(&self.autopilot.state, airborne));
    }

    /// New odometry: runs the decision loop and answers with a setpoint.
    fn handle_odometry(&mut self, now: HostTime, out: &mut NodeOutput) {
        let Some(odometry) = self.autopilot.state.odometry else { return };
        let clock = &mut self.autopilot.state.clock;
        out.notices.extend(self.host_clock.update(clock, self.timebase.now_ms(), now.unix_us));
        if let Some(common_ms) = self.autopilot.state.clock.common_ms(odometry.boot_ms) {
            self.run_decision_loop(common_ms, &odometry, now, out);
        }
        if !self.started && !self.settings.take_off && self.autopilot.stage() == Stage::Flying {
            out.notices.push(Notice::info("the vehicle was brought up by its operator: flying the mission"));
            self.start();
        }
        self.gate.position_arrived(now);
        self.check_height(out);
        self.answer_unless_held(now, out);
    }

    /// Answers the newest position with a setpoint. In lock-step the answer waits for a decision that other
    /// UAVs' messages are about to bring.
    fn answer_unless_held(&mut self, now: HostTime, out: &mut NodeOutput) {
        let in_lock_step = self.settings.timing.pace == Pace::LockStep && self.gate.is_flying();
        if !(in_lock_step && self.decisions.awaits_messages()) {
            self.answer(now, out);
        }
    }

    fn answer(&mut self, now: HostTime, out: &mut NodeOutput) {
        self.ask_gate(now, SetpointFilter::Any, out);
        self.gate.position_answered();
    }

    fn run_decision_loop(&mut self, common_ms: i64, odometry: &Odometry, now: HostTime, out: &mut NodeOutput) {
        let [east, north, _] = odometry.velocity_mps;
        let state = self.map_state(odometry);
        let measured = Measurement { common_ms, boot_ms: odometry.boot_ms, state, velocity_mps: [east, north] };
        let step = self.decisions.update(&measured, self.autopilot.is_airborne());
        self.take_step(step, now, out);
    }

    /// Hands out what the decision loop did; returns whether it decided.
    fn take_step(&mut self, step: Result<StepOutput, AgentError>, now: HostTime, out: &mut NodeOutput) -> bool {
        let step = match step {
            Ok(step) => step,
            Err(error) => {
                out.notices.push(Notice::warning(error.to_string()));
                return false;
            }
        };
        out.steps.extend(step.started);
        out.decisions.extend(step.decision);
        for message in &step.messages {
            match self.swarm_link.wrap(message, &mut self.session, now.timestamp()) {
                Ok(frame) => out.to_swarm.push(frame),
                Err(error) => out.notices.push(Notice::warning(error.to_string())),
            }
        }
        step.decision.is_some()
    }

    /// Asks the safety gate, and sends the setpoint that it lets through.
    fn ask_gate(&mut self, now: HostTime, filter: SetpointFilter, out: &mut NodeOutput) {
        let context = GateContext {
            mission: &self.settings.mission,
            id: self.settings.id,
            feed_forward: self.settings.feed_forward,
            // Without a decision the gate brakes.
            profile: self.decisions.velocity_profile().filter(|_| self.ending.is_none()),
            swarm_ms: self.links.swarm_boot_ms(),
            request: self.gate.take_request(),
            height_doubted: self.height_check.is_doubted(),
            swarm_incomplete: self.muster.is_incomplete(self.timebase.now_ms(), self.autopilot.is_airborne()),
        };
        let flew = self.gate.phase() == Phase::Flight;
        let inputs = gate_inputs(&mut self.autopilot, &context, now);
        let mut output = self.gate.tick(&inputs, now, filter, self.autopilot.takes_early_setpoints());
        let mut closes = false;
        if !flew && let Some(refusal) = self.refusal() {
            self.autopilot.give_up(&refusal, &mut out.notices);
            (output.notice, output.setpoint) = (None, None);
            closes = true;
            self.end(false);
        }
        if let Some(ending) = self.ending {
            // That the gate holds is no news: the operator was told of the braking.
            output.notice = output.notice.filter(|_| !matches!(self.gate.verdict(), Verdict::Hold(..)));
            if ending.is_over(&inputs, &self.gate.verdict(), self.timebase.now_ms()) {
                output.setpoint = last_setpoint(&self.gate.verdict());
                closes = true;
                self.end(false);
            }
        }
        out.notices.extend(output.notice);
        // An order of the operator is under way already, and may be a landing.
        let return_home = output.return_home || (self.gate.gives_up_bring_up() && self.autopilot.climbs());
        if return_home && !self.autopilot.has_order() {
            self.autopilot.return_home(self.timebase.now_ms());
        }
        if let Some(setpoint) = &output.setpoint {
            let boot_ms = inputs.now_ms.unwrap_or(0);
            let si = |thousandths: i32| f64::from(thousandths) / 1000.0;
            self.decisions.commanded(boot_ms, [si(setpoint.velocity.east), si(setpoint.velocity.north)]);
            let message = SetPositionTargetLocalNed::new(boot_ms, setpoint);
            self.send(&message.payload(self.target()), now, out);
            self.autopilot.note_setpoint();
        }
        if closes {
            // The gate closes behind the last setpoint.
            self.ask_gate(now, SetpointFilter::NewVerdict, out);
        }
    }

    fn send_heartbeat(&mut self, now: HostTime, out: &mut NodeOutput) {
        let now_ms = self.timebase.now_ms();
        if now_ms - self.heartbeat_ms >= HEARTBEAT_MS {
            self.heartbeat_ms = now_ms;
            self.send(&heartbeat(), now, out);
        }
    }

    /// Sends the command that the autopilot's bring-up or the end of the flight calls for.
    fn poll_autopilot(&mut self, now: HostTime, out: &mut NodeOutput) {
        self.tell_what_is_missing(out);
        let clearance = self.gate.clearance();
        let command = self.autopilot.poll(self.timebase.now_ms(), clearance, &mut out.notices);
        if let Some(command) = command {
            self.send(&command.payload(self.target()), now, out);
        }
        if let Some(request) = self.autopilot.poll_parameters(self.timebase.now_ms()) {
            self.send(&request.payload(self.target()), now, out);
        }
        if self.autopilot.stage() == Stage::Failed && self.gate.phase() == Phase::BringUp {
            self.end(false);
        }
    }

    /// System and component that messages are addressed to: all before the autopilot was heard.
    fn target(&self) -> (u8, u8) {
        self.autopilot.target().unwrap_or((0, 0))
    }

    fn send(&mut self, payload: &Payload, now: HostTime, out: &mut NodeOutput) {
        match self.autopilot_link.encode(payload, &mut self.session, now) {
            Ok(frame) => out.to_autopilot.push(frame),
            Err(text) => out.notices.push(Notice::warning(text)),
        }
    }

    /// Position and velocity on the map, ticks and ticks/step.
    fn map_state(&self, odometry: &Odometry) -> State {
        let scale = self.settings.mission.scale;
        let [east, north, _] = odometry.velocity_mps;
        State { position: scale.position(odometry.place), velocity: scale.velocity(east, north) }
    }
}
