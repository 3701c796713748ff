//! A node: it flies one UAV.
//!
//! [`Node`] owns all state and neither sockets nor clocks nor threads. It is handed what
//! arrived, with the time, and says what to send; so every flight can be played in a test.
//! [`run`] puts sockets around it.

mod brain;
mod interface;
mod logbook;
mod plan;
mod record;
pub mod run;
mod settings;
mod timebase;

pub use brain::{Brain, Sample, Thought, Timing};
pub use interface::{Now, Order, Outbox, Status};
pub use plan::{FeedForward, Plan};
pub use record::{Counters, Decision, StepBegun, observation_hash};
pub use settings::{Settings, SettingsError, gate_limits};
pub use timebase::Timebase;

use crate::autopilot::{Autopilot, Dialect, Fix, Heard, Leave, Mode, Notice, Outgoing, Stage, Telemetry, Vehicle};
use crate::frame::{Counts, Encoder, Frame, Reader};
use crate::signing::{LinkSigning, Session};
use crate::swarm_link::{COMPONENT, SwarmLink};
use firmware_core::gate::{self, Gate, Inputs, Measured, Phase, Proposal, Reason, Request, Vector, Verdict};
use firmware_core::geometry::State;
use interface::in_words;
use plan::thousandths;

/// Between two heartbeats of the node, ms.
const HEARTBEAT_MS: i64 = 1000;
/// Without positions the gate is asked this often, ms: by the vehicle's clock, and in real time by
/// the host's.
const GATE_MS: u32 = 200;
/// The first time it is asked later: a position of the same tick may be on its way behind another
/// message that moved the clock.
const GATE_FIRST_MS: u32 = 300;
/// By the host's clock where the vehicle's may run at any speed, or wait for others, ms.
const GATE_SIMULATION_MS: u64 = 2000;
/// … and a setpoint is sent on its own no sooner than this after the last, ms of the host's clock.
const SETPOINT_MS: u64 = 200;
/// What an estimator or a GPS said counts for this long, ms of the vehicle's clock.
const HEALTH_MS: u32 = 3000;
/// Without SYSTEM_TIME the host's clock is taken after this, ms of the node's clock.
const HOST_CLOCK_MS: i64 = 10_000;
/// Silence of the autopilot is told after this, ms of the host's clock.
const SILENCE_MS: u64 = 5000;

/// Which setpoints go out when the gate was asked.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Send {
    /// Any.
    Any,
    /// All but the actor's: those follow the positions.
    Brakes,
    /// The first of another verdict.
    News,
}

/// Flies one UAV.
#[derive(Debug)]
pub struct Node<'a> {
    settings: Settings<'a>,
    autopilot: Autopilot,
    gate: Gate,
    brain: Brain<'a>,
    reader: Reader,
    encoder: Encoder,
    swarm: SwarmLink,
    session: Session,
    refused: Counts,
    timebase: Timebase,
    verdict: Verdict,
    /// What the operator asks for, until the gate has heard it.
    operator: Option<Request>,
    /// Whether it was started.
    started: bool,
    beat_ms: i64,
    /// When the gate was last asked, by the vehicle's and by the host's clock.
    gate_ms: u32,
    gate_wall_ms: u64,
    /// It was asked without a new position.
    overdue: bool,
    setpoint_wall_ms: u64,
    streaming: bool,
    /// Host's clock at the first turn and when the autopilot was last heard.
    born_wall_ms: Option<u64>,
    heard_wall_ms: Option<u64>,
    silence_told: bool,
    /// Vehicle's and host's clock when the swarm was last heard.
    swarm_heard: Option<(u32, u64)>,
    /// Node's clock when the first position came.
    first_fix_ms: Option<i64>,
}

impl<'a> Node<'a> {
    /// A node that has heard nothing yet. With [`Settings::take_off`] it brings its vehicle
    /// into flight as soon as it can; without, it flies once somebody else has.
    ///
    /// # Errors
    /// See [`SettingsError`].
    pub fn new(settings: Settings<'a>, session: Session) -> Result<Self, SettingsError> {
        let mission = &settings.mission;
        let gate = Gate::new(settings.limits, mission.gate_fence()?)?;
        let swarm = SwarmLink::new(settings.id, settings.swarm_signing.clone())?;
        let layer_mm = mission.plane.alt_mm.saturating_add(settings.layer_mm());
        let autopilot = Autopilot::new(Vehicle::new(mission.plane), layer_mm, settings.rate_hz);
        let brain =
            Brain::new(settings.id, settings.actor, settings.mission.clone(), settings.pois.clone(), settings.timing);
        let mut node = Self {
            autopilot,
            gate,
            brain,
            reader: Reader::new(settings.source),
            encoder: Encoder::new(settings.system, COMPONENT),
            swarm,
            session,
            refused: Counts::new(),
            timebase: Timebase::default(),
            verdict: Verdict::Silent(Reason::NotStarted),
            operator: None,
            started: false,
            beat_ms: i64::MIN / 2,
            gate_ms: 0,
            gate_wall_ms: 0,
            overdue: false,
            setpoint_wall_ms: 0,
            streaming: false,
            born_wall_ms: None,
            heard_wall_ms: None,
            silence_told: false,
            swarm_heard: None,
            first_fix_ms: None,
            settings,
        };
        if node.settings.take_off {
            node.start();
        }
        Ok(node)
    }

    /// The operator asks for a flight: takeoff if need be, then the mission.
    pub fn start(&mut self) {
        self.started = true;
        self.operator = Some(Request::Start);
        self.autopilot.start_anew();
    }

    /// The operator lets the vehicle go; with `land` it is asked to land first.
    pub fn release(&mut self, land: bool) {
        self.operator = Some(Request::Release);
        if land {
            self.autopilot.land(self.timebase.now_ms());
        }
    }

    /// Carries out what the operator asks for.
    pub fn obey(&mut self, order: Order) {
        match order {
            Order::Start => self.start(),
            Order::Release => self.release(false),
            Order::Return => self.operator = Some(Request::Return),
            Order::Land => self.release(true),
        }
    }

    /// Whether the autopilot still has to answer a command.
    #[must_use]
    pub fn is_asking(&self) -> bool {
        self.autopilot.is_asking()
    }

    /// Steps are counted from this Unix time, ms, instead of the mission's; with `None` there
    /// are none.
    pub fn set_epoch(&mut self, epoch_ms: Option<i64>) {
        self.brain.set_epoch(epoch_ms);
    }

    /// Neighbour messages are numbered on from here.
    pub const fn set_sequence(&mut self, next: u16) {
        self.brain.set_sequence(next);
    }

    /// Its id.
    #[must_use]
    pub const fn id(&self) -> u16 {
        self.settings.id
    }

    /// How far it is.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        self.autopilot.stage()
    }

    /// Whether the vehicle is in the air.
    #[must_use]
    pub const fn is_airborne(&self) -> bool {
        self.autopilot.is_airborne()
    }

    /// The gate's last verdict.
    pub const fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// Where the gate stands.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.gate.phase()
    }

    /// The flight last decided on.
    #[must_use]
    pub const fn plan(&self) -> Option<&Plan> {
        self.brain.plan()
    }

    /// Common clock at the newest telemetry, Unix time in ms.
    #[must_use]
    pub fn common_ms(&self) -> Option<i64> {
        let clock = &self.autopilot.vehicle.clock;
        clock.common_ms(clock.newest()?)
    }

    /// Counts so far, those of the links among them.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let mut counters = self.brain.counters.clone();
        let mut links = self.swarm.counts();
        links += self.reader.counts();
        links += &self.refused;
        for (reason, count) in links.iter().filter(|&(_, count)| count > 0) {
            *counters.rejected.entry(reason.name()).or_default() += count;
        }
        counters
    }

    /// Forgets half a frame, when a stream was cut off and is back.
    pub fn reconnected(&mut self) {
        self.reader.reset();
    }

    /// Takes in what came from the autopilot's link. Says whether the autopilot sent it: whose
    /// bytes are answered.
    pub fn hear_autopilot(&mut self, bytes: &[u8], now: Now, out: &mut Outbox) -> bool {
        let mut is_ours = false;
        self.reader.push(bytes);
        while let Some(frame) = self.reader.next_frame() {
            if let Err(reason) = self.session.check(&self.settings.autopilot_signing, &frame, now.timestamp()) {
                self.refused.count(reason);
                continue;
            }
            if self.settings.record {
                out.heard.push(frame);
            }
            if let Some(telemetry) = Telemetry::read(frame.message_id(), frame.payload()) {
                self.take(&frame, &telemetry, now, out);
            }
            is_ours |= self.autopilot.target() == Some((frame.system(), frame.component()));
        }
        is_ours
    }

    /// Takes in a datagram of the swarm.
    pub fn hear_swarm(&mut self, datagram: &[u8], now: Now, out: &mut Outbox) {
        self.swarm.push(datagram);
        while let Some(neighbour) = self.swarm.next_message(&mut self.session, now.timestamp()) {
            if self.settings.record {
                out.heard.push(neighbour.frame);
            }
            if self.brain.hear(neighbour.message) {
                self.swarm_heard = Some((self.autopilot.vehicle.now_ms(), now.wall_ms));
            }
        }
    }

    /// To be called after each turn of receiving, and at least every 50 ms.
    pub fn tick(&mut self, now: Now, out: &mut Outbox) {
        self.pass_time(now);
        self.tell_silence(now, out);
        self.ask_overdue(now, out);
        self.lead(out, now);
    }

    /// For people.
    #[must_use]
    pub fn status(&self, now: Now) -> Status {
        let vehicle = &self.autopilot.vehicle;
        let age = |then: Option<u64>| then.map(|then| now.wall_ms.saturating_sub(then));
        Status {
            id: self.settings.id,
            stage: self.autopilot.stage(),
            mode: self.autopilot.mode_name(),
            gate: self.verdict.name(),
            reason: self.verdict.reason(),
            state: vehicle.fix.map(|fix| self.state(&fix)),
            altitude_m: vehicle.fix.map(|fix| f64::from(fix.alt_mm - self.settings.mission.plane.alt_mm) / 1000.0),
            step: self.brain.step(),
            link_ms: age(self.heard_wall_ms),
            swarm_ms: age(self.swarm_heard.map(|(_, wall_ms)| wall_ms)),
            neighbours: self.brain.neighbours(),
            battery: vehicle.battery,
        }
    }

    /// When positions cease the gate is asked all the same.
    fn ask_overdue(&mut self, now: Now, out: &mut Outbox) {
        let patience_ms = if self.overdue { GATE_MS } else { GATE_FIRST_MS };
        let patience_wall_ms = if self.gate.limits().real_time { u64::from(patience_ms) } else { GATE_SIMULATION_MS };
        let clock_ms = self.autopilot.vehicle.now_ms().wrapping_sub(self.gate_ms);
        let wall_ms = now.wall_ms.saturating_sub(self.gate_wall_ms);
        if clock_ms >= patience_ms || wall_ms >= patience_wall_ms {
            let since_ms = now.wall_ms.saturating_sub(self.setpoint_wall_ms);
            let send = if since_ms >= SETPOINT_MS { Send::Brakes } else { Send::News };
            self.ask_gate(now, send, out);
            self.overdue = true;
        }
    }

    fn pass_time(&mut self, now: Now) -> i64 {
        self.born_wall_ms.get_or_insert(now.wall_ms);
        let clock = &self.autopilot.vehicle.clock;
        let vehicle_ms = clock.newest().and_then(|newest| clock.extend(newest));
        self.timebase.advance(vehicle_ms, now.wall_ms)
    }

    fn take(&mut self, frame: &Frame, telemetry: &Telemetry, now: Now, out: &mut Outbox) {
        let from = (frame.system(), frame.component());
        let ours = |autopilot: &Autopilot| (autopilot.mode(), autopilot.is_armed());
        let before = ours(&self.autopilot);
        let heard = self.autopilot.hear(from, telemetry, self.timebase.now_ms(), &mut out.notices);
        if self.autopilot.target() == Some(from) {
            if self.silence_told {
                out.notices.push(Notice::info("the autopilot is heard again"));
            }
            (self.heard_wall_ms, self.silence_told) = (Some(now.wall_ms), false);
        }
        self.pass_time(now);
        match heard {
            // Who took the vehicle is heard by the gate before anything more is asked of it.
            Heard::Noted if ours(&self.autopilot) != before => self.ask_gate(now, Send::News, out),
            Heard::Noted | Heard::ClockMoved(_) => {}
            Heard::Restarted => self.brain.forget(),
            Heard::Fix => self.measured(now, out),
        }
    }

    /// A new state was measured: thinks, and answers with a setpoint.
    fn measured(&mut self, now: Now, out: &mut Outbox) {
        let Some(fix) = self.autopilot.vehicle.fix else { return };
        self.take_host_clock(now, out);
        if let Some(common_ms) = self.autopilot.vehicle.clock.common_ms(fix.boot_ms) {
            let [east, north, _] = fix.velocity_mps;
            let state = self.state(&fix);
            let sample = Sample { common_ms, boot_ms: fix.boot_ms, state, velocity_mps: [east, north] };
            let thought = self.brain.think(&sample, self.autopilot.is_airborne());
            out.begun.extend(thought.begun);
            out.decisions.extend(thought.decision);
            for message in &thought.messages {
                match self.swarm.wrap(message, &mut self.session, now.timestamp()) {
                    Ok(frame) => out.to_swarm.push(frame),
                    Err(error) => out.notices.push(Notice::warning(error.to_string())),
                }
            }
        }
        if !self.started && !self.settings.take_off && self.autopilot.stage() == Stage::Flying {
            out.notices.push(Notice::info("the vehicle was brought up by its operator: flying the mission"));
            self.start();
        }
        self.ask_gate(now, Send::Any, out);
        self.overdue = false;
    }

    /// Asks the gate, and sends what it lets through.
    fn ask_gate(&mut self, now: Now, send: Send, out: &mut Outbox) {
        let inputs = self.inputs(now);
        let before = self.verdict;
        self.verdict = self.gate.tick(&inputs);
        (self.gate_ms, self.gate_wall_ms) = (inputs.now_ms.unwrap_or(0), now.wall_ms);
        let is_news = before.name() != self.verdict.name() || before.reason() != self.verdict.reason();
        if is_news {
            out.notices.push(in_words(before, self.verdict));
        }
        if let Verdict::Return(_) = self.verdict {
            self.autopilot.return_home(self.timebase.now_ms());
        }
        // Before its mode only PX4 wants setpoints.
        let early = matches!(self.verdict, Verdict::BringUp(_)) && self.autopilot.dialect() != Some(Dialect::Px4);
        let setpoint = self.verdict.setpoint().filter(|_| !early);
        self.streaming = setpoint.is_some();
        let wanted = match send {
            Send::Any => true,
            Send::Brakes => is_news || !matches!(self.verdict, Verdict::Stream(_)),
            Send::News => is_news,
        };
        if let (Some(setpoint), true) = (setpoint, wanted) {
            self.setpoint_wall_ms = now.wall_ms;
            self.brain.counters.setpoint(setpoint.limited);
            self.send(&Outgoing::Setpoint { boot_ms: inputs.now_ms.unwrap_or(0), setpoint }, now, out);
        }
    }

    /// Heartbeats, and commands that lead on.
    fn lead(&mut self, out: &mut Outbox, now: Now) {
        let now_ms = self.timebase.now_ms();
        if now_ms - self.beat_ms >= HEARTBEAT_MS {
            self.beat_ms = now_ms;
            self.send(&Outgoing::Heartbeat, now, out);
        }
        let leave = Leave { may_start: matches!(self.verdict, Verdict::BringUp(_)), streaming: self.streaming };
        let mut commands = Vec::new();
        self.autopilot.poll(now_ms, leave, &mut commands, &mut out.notices);
        for command in &commands {
            self.send(command, now, out);
        }
    }

    fn send(&mut self, outgoing: &Outgoing, now: Now, out: &mut Outbox) {
        // To all before anybody was heard.
        let payload = outgoing.payload(self.autopilot.target().unwrap_or((0, 0)));
        let frame = self.encoder.encode_payload(payload.id, payload.bytes()).map_err(|e| e.to_string());
        let signing: &LinkSigning = &self.settings.autopilot_signing;
        let sealed = frame.and_then(|f| self.session.seal(signing, f, now.timestamp()).map_err(|e| e.to_string()));
        match sealed {
            Ok(frame) => out.to_autopilot.push(frame),
            Err(text) => out.notices.push(Notice::warning(text)),
        }
    }

    fn inputs(&mut self, now: Now) -> Inputs {
        let plane = self.settings.mission.plane;
        let vehicle = &mut self.autopilot.vehicle;
        let now_ms = vehicle.now_ms();
        let fresh = |then: u32| now_ms.wrapping_sub(then) <= HEALTH_MS;
        let refused = vehicle.take_refused();
        let state = vehicle.fix.map(|fix| Measured {
            time_ms: fix.boot_ms,
            position: Vector::new(fix.place.east_mm.round() as i32, fix.place.north_mm.round() as i32),
            altitude_mm: fix.alt_mm.saturating_sub(plane.alt_mm),
            velocity: Vector::new(thousandths(fix.velocity_mps[0]), thousandths(fix.velocity_mps[1])),
            climb_mm_s: thousandths(fix.velocity_mps[2]),
        });
        let proposal = self.brain.plan().map(|plan| {
            let (velocity, acceleration) = plan.at(now_ms, self.settings.feed_forward);
            Proposal { decided_ms: plan.decided_ms, velocity, acceleration, altitude_mm: self.settings.layer_mm() }
        });
        Inputs {
            now_ms: vehicle.clock.newest(),
            wall_ms: now.wall_ms as u32,
            state,
            refused,
            sources_disagree: vehicle.sources_disagree,
            ekf_ok: vehicle.estimator.is_some_and(|(healthy, then)| healthy && fresh(then)),
            gps_fix: vehicle.gps_fix.filter(|&(_, then)| fresh(then)).map(|(kind, _)| kind),
            heartbeat_ms: vehicle.heartbeat.map(|(_, then)| then),
            battery_permille: vehicle.battery.map(|percent| u16::from(percent) * 10),
            mode: match self.autopilot.mode() {
                None => gate::Mode::Unknown,
                Some(Mode::Guided) => gate::Mode::Guided,
                Some(Mode::TakeoffOrHold | Mode::Other(_)) => gate::Mode::Other,
            },
            armed: self.autopilot.is_armed(),
            airborne: self.autopilot.is_airborne(),
            swarm_ms: self.swarm_heard.map(|(vehicle_ms, _)| vehicle_ms),
            // No node is made without it.
            self_test: true,
            operator: self.operator.take(),
            proposal,
        }
    }

    fn state(&self, fix: &Fix) -> State {
        let scale = self.settings.mission.scale;
        let [east, north, _] = fix.velocity_mps;
        State { position: scale.position(fix.place), velocity: scale.velocity(east, north) }
    }

    /// For want of SYSTEM_TIME the host's clock is the common one.
    fn take_host_clock(&mut self, now: Now, out: &mut Outbox) {
        let now_ms = self.timebase.now_ms();
        let first = *self.first_fix_ms.get_or_insert(now_ms);
        let clock = &mut self.autopilot.vehicle.clock;
        if !clock.is_set() && now_ms - first >= HOST_CLOCK_MS {
            clock.set_host(i64::try_from(now.unix_us / 1000).unwrap_or(0));
            out.notices.push(Notice::warning("no SYSTEM_TIME from the autopilot: taking this computer's clock"));
        }
    }

    fn tell_silence(&mut self, now: Now, out: &mut Outbox) {
        let since = self.heard_wall_ms.or(self.born_wall_ms).unwrap_or(now.wall_ms);
        if !self.silence_told && now.wall_ms.saturating_sub(since) >= SILENCE_MS {
            self.silence_told = true;
            out.notices.push(Notice::warning(format!("nothing heard for 5 s; {}", self.settings.advice)));
        }
    }
}
