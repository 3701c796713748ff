//! The autopilot as a node's client talks to it: identification, message intervals, commands.

use super::bring_up::{BringUp, BringUpStep, Situation};
use super::command::PendingCommand;
use super::control::Control;
use super::firmware::{Firmware, Mode};
use super::identity::Identity;
use super::notice::Notice;
use super::order::WaitingOrder;
use super::parameter_watch::{ParameterWatch, Reliance};
use super::shared_id::Senders;
use super::stage::Stage;

use super::vehicle_state::{TelemetryUpdate, VehicleState};
use crate::messages::{CommandLong, Heartbeat, Telemetry, mav_cmd};

/// MAV_SEVERITY up to which it does: warnings and worse.
const TEXT_SEVERITY: u8 = 4;

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
    pub(super) waiting_order: Option<WaitingOrder>,
    pub(super) control: Control,
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
    pub(super) watch: ParameterWatch,
}

impl Autopilot {
    /// An autopilot that was not heard yet. `layer_mm` is the altitude to take off to, mm above mean
    /// sea level; positions are requested at `rate_hz`. It is the autopilot of system `vehicle`; the node
    /// sends as system `own.0`, component `own.1`.
    #[must_use]
    pub const fn new(
        state: VehicleState,
        layer_mm: i32,
        rate_hz: f64,
        vehicle: u8,
        own: (u8, u8),
        reliance: Reliance,
    ) -> Self {
        Self {
            state,
            target: None,
            firmware: None,
            identity: Identity::new(vehicle, own),
            rate_hz,
            bring_up: BringUp::new(layer_mm),
            command: None,
            order: None,
            waiting_order: None,
            control: Control::new(),
            next_rate: 0,
            stage: Stage::Silent,
            reminded_ms: i64::MIN / 2,
            last_text: None,
            positions_ms: 0,
            asked_again: 0,
            corrections: (0, 0),
            corrections_told_ms: i64::MIN / 2,
            doubt_reported: false,
            watch: ParameterWatch::new(reliance),
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
            Telemetry::Parameter(value) => self.take_parameter(value),
            _ => {}
        }
        let before = self.mode_name();
        let update = self.state.update(telemetry);
        match update {
            TelemetryUpdate::Rebooted => {
                notices.push(Notice::warning("the vehicle's clock started anew: it booted again, or it jumped"));
                // An order goes on: perhaps it was the clock alone.
                (self.next_rate, self.command) = (0, None);
                self.bring_up.reboot();
                self.watch.restart();
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
            self.note_mode(now_ms);
            self.check_order(now_ms, notices);
            self.report_parameters(notices);
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
        (self.command, self.order, self.waiting_order) = (None, None, None);
        self.control.restart();
        self.watch.restart();
        self.bring_up.restart();
    }

    /// Whether a bring-up is under way, which a start need not begin anew.
    pub fn goes_on(&mut self, may_take: bool) -> bool {
        let goes_on = self.stage == Stage::BringUp && self.order.is_none() && self.waiting_order.is_none();
        if goes_on && may_take {
            self.bring_up.set_may_take(true);
        }
        goes_on
    }

    /// What the operator should look at while the vehicle is not heard, if that is known.
    #[must_use]
    pub fn advice(&self) -> Option<String> {
        self.identity.advice().filter(|_| self.target.is_none())
    }

    /// Whether a command waits for its COMMAND_ACK.
    #[must_use]
    pub fn awaits_ack(&self) -> bool {
        self.waiting_order.is_some()
            || [self.command, self.order].iter().flatten().any(|command| !command.is_accepted())
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
            if self.stage != Stage::Flying && self.may_fly(now_ms, notices) {
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
        if let Some(reason) = self.taken_over() {
            self.control.lose();
            self.give_up(&reason, notices);
            return;
        }
        if !self.may_fly(now_ms, notices) {
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
                self.control.climb();
                notices.push(Notice::info(format!("taking off to {:.1} m", f64::from(height_mm) / 1e3)));
            }
            BringUpStep::TakeOff { .. } => {}
            BringUpStep::GiveUp(reason) => self.give_up(&reason, notices),
        }
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
