//! The autopilot as a node's client talks to it: identification, message intervals, commands.

use super::bring_up::{BringUp, BringUpStep, Situation};
use super::command::{CommandFailure, PendingCommand, command_name};
use super::firmware::{Firmware, Mode};
use super::identity::Identity;
use super::message_rates::message_rates;
use super::notice::Notice;
use super::shared_id::Senders;
use super::stage::Stage;
use super::vehicle_state::{TelemetryUpdate, VehicleState};
use crate::messages::{CommandLong, Heartbeat, Telemetry, mav_cmd};

/// What a start waits for is repeated to the operator this often, ms.
const REMIND_MS: i64 = 10_000;
/// A STATUSTEXT explains a refusal for this long, ms.
const TEXT_MS: i64 = 10_000;
/// MAV_SEVERITY up to which it does: warnings and worse.
const TEXT_SEVERITY: u8 = 4;

/// A change of mode that was accepted has this long to show in a heartbeat, ms: longer, and somebody
/// changed it back.
const EFFECT_MS: i64 = 2500;

/// Parameters of MAV_CMD_DO_SET_MODE; the first is MAV_MODE_FLAG_CUSTOM_MODE_ENABLED.
pub(super) const fn set_mode_params([main, sub]: [f32; 2]) -> [f32; 7] {
    [1.0, main, sub, 0.0, 0.0, 0.0, 0.0]
}

/// What the safety gate lets the autopilot's client do at a poll.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clearance {
    /// Mode change, arming and takeoff may be commanded.
    pub bring_up: bool,
    /// Setpoints are being streamed, as PX4 requires before OFFBOARD.
    pub streaming: bool,
}

/// One autopilot.
#[derive(Clone, Debug)]
pub struct Autopilot {
    /// The state of the vehicle by its telemetry.
    pub state: VehicleState,
    /// System and component of the autopilot, once identified.
    pub(super) target: Option<(u8, u8)>,
    pub(super) firmware: Option<Firmware>,
    pub(super) identity: Identity,
    pub(super) rate_hz: f64,
    pub(super) bring_up: BringUp,
    pub(super) command: Option<PendingCommand>,
    /// A return or a landing, until the autopilot has left the mode that follows setpoints. It comes before
    /// everything else.
    pub(super) order: Option<PendingCommand>,
    /// Index of the next message interval to request.
    pub(super) next_rate: usize,
    pub(super) stage: Stage,
    pub(super) reminded_ms: i64,
    /// The autopilot's last STATUSTEXT of weight, and when it arrived, ms.
    pub(super) last_text: Option<(String, i64)>,
    /// When the rates were last requested or a position last came, ms, and how often they were requested
    /// since.
    pub(super) positions_ms: i64,
    pub(super) asked_again: u32,
    /// Corrections of the clock that were not told yet: how many, and their sum, ms; when the last were.
    pub(super) corrections: (u32, i64),
    pub(super) corrections_told_ms: i64,
    /// The operator was told that perhaps two vehicles send with this system id.
    pub(super) doubt_reported: bool,
}

impl Autopilot {
    /// An autopilot that was not heard yet. `layer_mm` is the altitude to take off to, mm above mean
    /// sea level; positions are requested at `rate_hz`. It is the autopilot of system `vehicle`; the node
    /// sends as system `own.0`, component `own.1`.
    #[must_use]
    pub const fn new(state: VehicleState, layer_mm: i32, rate_hz: f64, vehicle: u8, own: (u8, u8)) -> Self {
        Self {
            state,
            target: None,
            firmware: None,
            identity: Identity::new(vehicle, own),
            rate_hz,
            bring_up: BringUp::new(layer_mm),
            command: None,
            order: None,
            next_rate: 0,
            stage: Stage::Silent,
            reminded_ms: i64::MIN / 2,
            last_text: None,
            positions_ms: 0,
            asked_again: 0,
            corrections: (0, 0),
            corrections_told_ms: i64::MIN / 2,
            doubt_reported: false,
        }
    }

    /// How far the work with it has come.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        self.stage
    }

    /// System and component of the autopilot, once a HEARTBEAT identified it.
    #[must_use]
    pub const fn target(&self) -> Option<(u8, u8)> {
        self.target
    }

    /// Its firmware, once a HEARTBEAT identified it.
    #[must_use]
    pub const fn firmware(&self) -> Option<Firmware> {
        self.firmware
    }

    /// In the air, with the takeoff finished.
    #[must_use]
    pub const fn is_airborne(&self) -> bool {
        self.bring_up.is_airborne()
    }

    /// Whether it took off on a command of this start: it climbs, or has climbed.
    #[must_use]
    pub const fn is_taking_off(&self) -> bool {
        self.bring_up.is_taking_off()
    }

    /// The flight mode in the last HEARTBEAT.
    #[must_use]
    pub fn mode(&self) -> Option<Mode> {
        self.state.mode(self.firmware?)
    }

    /// The name of the mode, as users know it.
    #[must_use]
    pub fn mode_name(&self) -> String {
        self.firmware.map_or_else(|| "unknown".into(), |firmware| self.state.mode_name(firmware))
    }

    /// Whether it was armed in the last HEARTBEAT.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.state.is_armed()
    }

    /// Takes in a message of system `from.0`, component `from.1`, at `now_ms` of the node's clock.
    /// Messages of others on the same link are ignored.
    pub fn handle(
        &mut self,
        from: (u8, u8),
        telemetry: &Telemetry,
        now_ms: i64,
        notices: &mut Vec<Notice>,
    ) -> TelemetryUpdate {
        match (self.target, telemetry) {
            (Some(target), _) if target == from => {}
            (None, Telemetry::Heartbeat(heartbeat)) if self.identity.is_wanted(from, heartbeat) => {
                self.identify(from, *heartbeat, notices);
            }
            (_, Telemetry::Heartbeat(heartbeat)) => {
                notices.extend(self.identity.heard_other(from, heartbeat, self.target.is_some()));
                return TelemetryUpdate::Other;
            }
            // Messages before the first HEARTBEAT, and those of others on the same link.
            _ => return TelemetryUpdate::Other,
        }
        if self.state.senders() == Senders::Two {
            // Nothing of theirs is believed until the operator starts again: the gate stops.
            return TelemetryUpdate::Other;
        }
        match telemetry {
            Telemetry::Ack { command, result, to } if self.identity.is_for_us(*to) => {
                self.acknowledge(*command, *result, now_ms, notices);
            }
            Telemetry::Ack { to, .. } => notices.extend(self.identity.answered_other(*to)),
            Telemetry::Text { severity, text } => {
                if *severity <= TEXT_SEVERITY {
                    self.last_text = Some((text.clone(), now_ms));
                }
                notices.push(Notice { warning: *severity <= TEXT_SEVERITY, text: format!("autopilot: {text}") });
            }
            _ => {}
        }
        let before = self.mode_name();
        let update = self.state.update(telemetry);
        match update {
            TelemetryUpdate::Rebooted => {
                notices.push(Notice::warning("the vehicle's clock started anew: it booted again, or it jumped"));
                (self.next_rate, self.command, self.order) = (0, None, None);
                self.bring_up.reboot();
                if self.stage != Stage::Failed {
                    self.stage = Stage::Subscribing;
                }
            }
            TelemetryUpdate::ClockCorrected(ms) => {
                let (count, sum) = self.corrections;
                self.corrections = (count + 1, sum.saturating_add(ms));
            }
            TelemetryUpdate::ClockRate(permille) => notices.push(rate_notice(permille)),
            TelemetryUpdate::Odometry | TelemetryUpdate::Other => {}
        }
        self.report_corrections(now_ms, notices);
        self.check_senders(notices);
        if let Telemetry::Global(_) | Telemetry::Local(_) = telemetry {
            (self.positions_ms, self.asked_again) = (now_ms, 0);
        }
        if let Telemetry::Heartbeat(_) = telemetry {
            self.check_rates(now_ms, notices);
            let mode = self.mode_name();
            if before != mode && before != "unknown" {
                notices.push(Notice::info(format!("mode {before} -> {mode}")));
            }
            self.check_order();
        }
        self.bring_up.update(&self.state, self.state.is_armed());
        update
    }

    /// The command to send at `now_ms` of the node's clock, if one is due. Heartbeats and setpoints are
    /// sent by the node.
    pub fn poll(&mut self, now_ms: i64, clearance: Clearance, notices: &mut Vec<Notice>) -> Option<CommandLong> {
        self.bring_up.set_streaming(clearance.streaming, now_ms);
        if let Some(message) = self.poll_order(now_ms, notices) {
            return Some(message);
        }
        let may_start = clearance.bring_up && self.order.is_none();
        self.note_climb(now_ms);
        match self.stage {
            Stage::Silent => {
                notices.extend(self.identity.waiting());
                return None;
            }
            Stage::Failed => return None,
            Stage::Subscribing => self.subscribe(now_ms),
            Stage::Idle | Stage::BringUp | Stage::Flying => self.advance(now_ms, may_start, notices),
        }
        match self.command.as_mut()?.poll(now_ms) {
            Ok(message) => message,
            Err(failure) => {
                self.fail(failure, now_ms, notices);
                None
            }
        }
    }

    /// The operator requests a start, perhaps after a failure: the bring-up begins from scratch. Only with
    /// `may_take` is a vehicle taken that is armed and in another mode.
    pub fn restart(&mut self, may_take: bool) {
        self.bring_up.set_may_take(may_take);
        if self.stage == Stage::Failed && self.firmware.is_some() {
            self.stage = Stage::Subscribing;
            self.next_rate = 0;
        }
        if self.state.senders() == Senders::Two {
            self.state.forget_senders();
        }
        (self.command, self.order) = (None, None);
        self.bring_up.restart();
    }

    /// What the operator should look at while the vehicle is not heard, if that is known.
    #[must_use]
    pub fn advice(&self) -> Option<String> {
        self.identity.advice().filter(|_| self.target.is_none())
    }

    /// Whether a command waits for its COMMAND_ACK.
    #[must_use]
    pub fn awaits_ack(&self) -> bool {
        [self.command, self.order].iter().flatten().any(|command| !command.is_accepted())
    }

    fn identify(&mut self, from: (u8, u8), heartbeat: Heartbeat, notices: &mut Vec<Notice>) {
        self.target = Some(from);
        match Firmware::of(heartbeat.autopilot, heartbeat.kind) {
            Ok(firmware) => {
                self.firmware = Some(firmware);
                self.stage = Stage::Subscribing;
                notices.push(Notice::info(format!("{firmware}, system {}", from.0)));
            }
            Err(unsupported) => {
                self.stage = Stage::Failed;
                notices.push(Notice::warning(format!("this vehicle cannot be flown: {unsupported}")));
            }
        }
    }

    /// Goes on towards flight, as far as the gate allows.
    fn advance(&mut self, now_ms: i64, may_start: bool, notices: &mut Vec<Notice>) {
        let Some(firmware) = self.firmware else { return };
        let guided = self.mode() == Some(Mode::Guided);
        if self.is_airborne() && guided {
            if self.stage != Stage::Flying {
                self.stage = Stage::Flying;
                self.command = None;
                notices.push(Notice::info(format!("airborne, {}", firmware.guided_name())));
            }
            return;
        }
        if !may_start {
            self.stage = Stage::Idle;
            // No bring-up command is repeated once the gate has closed.
            self.command = None;
            return;
        }
        if let Some(missing) = self.state.missing() {
            self.remind(now_ms, notices, || format!("waiting for {missing}"));
            return;
        }
        if let Some(reason) = self.taken_over(now_ms) {
            self.give_up(&reason, notices);
            return;
        }
        self.stage = Stage::BringUp;
        let takeoff = self.command.filter(|c| c.command() == mav_cmd::NAV_TAKEOFF);
        let situation = Situation {
            firmware,
            mode: self.mode(),
            armed: self.is_armed(),
            takeoff_accepted: takeoff.is_some_and(|c| c.is_accepted()),
            state: &self.state,
        };
        match self.bring_up.next(&situation, now_ms) {
            BringUpStep::Wait => {}
            BringUpStep::SetGuided => self.set_mode(firmware.guided(), now_ms),
            BringUpStep::Arm => {
                self.request(mav_cmd::COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], now_ms);
            }
            BringUpStep::TakeOff { height_mm, params } if takeoff.is_none() => {
                self.command = Some(PendingCommand::new(mav_cmd::NAV_TAKEOFF, params, now_ms));
                notices.push(Notice::info(format!("taking off to {:.1} m", f64::from(height_mm) / 1e3)));
            }
            BringUpStep::TakeOff { .. } => {}
            BringUpStep::GiveUp(reason) => self.give_up(&reason, notices),
        }
    }

    /// Who has the vehicle instead of the node, in words: it is armed in another mode before an automatic
    /// start, or its mode was changed since the bring-up began.
    fn taken_over(&mut self, now_ms: i64) -> Option<String> {
        let heartbeat = self.state.heartbeat?.0;
        let firmware = self.firmware?;
        let mode = firmware.mode(heartbeat.custom_mode);
        let name = firmware.mode_name(heartbeat.custom_mode);
        if mode == Mode::Guided {
            return None;
        }
        if !self.bring_up.may_take() && !self.bring_up.has_begun() && heartbeat.armed {
            return Some(format!("it is armed and in {name}, so somebody flies it: type `start` to take it"));
        }
        // What the autopilot itself changes to on its takeoff.
        let ours = firmware == Firmware::Px4 && mode == Mode::TakeoffOrHold && self.bring_up.has_begun();
        let began_in = self.bring_up.begin(heartbeat.custom_mode);
        let accepted_ms = self.command.filter(|c| c.is(mav_cmd::DO_SET_MODE, &set_mode_params(firmware.guided())));
        let undone = accepted_ms.and_then(PendingCommand::accepted_ms).is_some_and(|at| now_ms - at >= EFFECT_MS);
        ((!ours && heartbeat.custom_mode != began_in) || undone)
            .then(|| format!("the mode is {name}: somebody else changed it; type `start` to take the vehicle"))
    }

    /// Makes this the command under way, unless it is already.
    pub(super) fn request(&mut self, command: u16, params: [f32; 7], now_ms: i64) {
        if !self.command.is_some_and(|pending| pending.is(command, &params)) {
            self.command = Some(PendingCommand::new(command, params, now_ms));
        }
    }

    fn set_mode(&mut self, mode: [f32; 2], now_ms: i64) {
        self.request(mav_cmd::DO_SET_MODE, set_mode_params(mode), now_ms);
    }

    fn acknowledge(&mut self, command: u16, result: u8, now_ms: i64, notices: &mut Vec<Notice>) {
        if let Some(order) = self.order.as_mut().filter(|c| c.command() == command && !c.is_accepted()) {
            if order.acknowledge(result, now_ms).is_err() || order.is_refused() {
                let why = format!("refused by the autopilot{}", self.explanation(now_ms));
                self.repeat_order(now_ms, &why, notices);
            }
            return;
        }
        let Some(pending) = self.command.as_mut().filter(|c| c.command() == command && !c.is_accepted()) else {
            return;
        };
        match pending.acknowledge(result, now_ms) {
            Ok(true) => {}
            Ok(false) => {
                let (what, why) = (command_name(command), self.explanation(now_ms));
                self.remind(now_ms, notices, || format!("{what} refused by the autopilot{why}; trying again"));
            }
            Err(failure) => self.fail(failure, now_ms, notices),
        }
    }

    fn fail(&mut self, failure: CommandFailure, now_ms: i64, notices: &mut Vec<Notice>) {
        let Some(pending) = self.command.take() else { return };
        let what = command_name(pending.command());
        if pending.command() == mav_cmd::SET_MESSAGE_INTERVAL {
            // Some autopilots send the message without a request.
            let id = message_rates(self.firmware, self.rate_hz).get(self.next_rate).map_or(0, |&(id, _)| id);
            notices.push(Notice::warning(format!(
                "the autopilot does not take a rate for message {id}; going on without"
            )));
            self.next_rate += 1;
            return;
        }
        let reason = match failure {
            CommandFailure::NoAck => format!("{what}: no answer from the autopilot"),
            CommandFailure::Refused => format!("{what} refused by the autopilot{}", self.explanation(now_ms)),
            CommandFailure::Unsupported => format!("{what}: the autopilot does not know this command"),
        };
        self.give_up(&reason, notices);
    }

    pub(crate) fn give_up(&mut self, reason: &str, notices: &mut Vec<Notice>) {
        notices.push(Notice::warning(format!("not flying: {reason}")));
        (self.command, self.stage) = (None, Stage::Failed);
    }

    /// The autopilot's last STATUSTEXT, if it is recent enough to explain a refusal.
    pub(super) fn explanation(&self, now_ms: i64) -> String {
        match &self.last_text {
            Some((text, at)) if now_ms - at <= TEXT_MS => format!(": {text}"),
            _ => String::new(),
        }
    }

    pub(crate) fn remind(&mut self, now_ms: i64, notices: &mut Vec<Notice>, text: impl FnOnce() -> String) {
        if now_ms - self.reminded_ms >= REMIND_MS {
            self.reminded_ms = now_ms;
            notices.push(Notice::info(text()));
        }
    }
}

/// The two clocks of a vehicle began to run apart, or run together again.
fn rate_notice(permille: i64) -> Notice {
    if (995..=1005).contains(&permille) {
        return Notice::info("the autopilot's Unix time runs as fast as its own clock again");
    }
    let times = permille as f64 / 1000.0;
    Notice::warning(format!(
        "the autopilot's Unix time (SYSTEM_TIME) runs {times:.2} times as fast as its own clock: is the simulation's \
         speed not 1? Steps would have another length; holding until both agree"
    ))
}
