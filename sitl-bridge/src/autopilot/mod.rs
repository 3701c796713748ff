//! The autopilot's side of a node: who is there, which messages it shall send, and the way
//! from the ground into flight.
//!
//! Nothing here owns a socket or a clock. [`Autopilot::hear`] takes in messages,
//! [`Autopilot::poll`] says what to send. Each time it looks at where the vehicle is and asks
//! for the next thing that is missing, so a lost message or a reboot only costs time:
//!
//! | ArduPilot | PX4 |
//! |---|---|
//! | message rates, one after another | the same |
//! | position, time, estimator healthy | the same |
//! | GUIDED | armed |
//! | armed | takeoff, until near the layer's altitude |
//! | takeoff, until near the layer's altitude | setpoints for a second, then OFFBOARD |

mod clock;
mod dialect;
mod outgoing;
mod request;
mod stage;
mod telemetry;
mod vehicle;

pub use clock::{Tick, VehicleClock};
pub use dialect::{Dialect, Mode, Unfit};
pub use outgoing::{Outgoing, Payload, VELOCITY_AND_ACCELERATION, command};
pub use stage::{Leave, Notice, Stage};
pub use telemetry::{GlobalPosition, Heartbeat, LocalPosition, Telemetry};
pub use vehicle::{Fix, Heard, Vehicle};

use request::{Failure, Request};

/// MAV_AUTOPILOT_INVALID: who sends it is no autopilot.
const NO_AUTOPILOT: u8 = 8;
/// What keeps the vehicle from starting is told this often, ms.
const REMIND_MS: i64 = 10_000;
/// Words of the autopilot explain a refusal for this long, ms.
const TEXT_MS: i64 = 10_000;
/// Severity up to which they do (4 is a warning).
const TEXT_SEVERITY: u8 = 4;
/// The layer is reached within this, mm.
const REACHED_MM: i32 = 1000;
/// A vehicle this high above home flies, mm.
const FLYING_MM: i32 = 1500;
/// Shortest takeoff, mm.
const LEAST_TAKEOFF_MM: i32 = 2000;
/// PX4 wants setpoints for a second before OFFBOARD; a little more is sure.
const PRESTREAM_MS: i64 = 1200;
/// Slowest climb that is waited for, mm/s, and the time that it may begin late, ms.
const SLOWEST_CLIMB_MMPS: i64 = 300;
const CLIMB_START_MS: i64 = 20_000;

/// One autopilot.
#[derive(Clone, Debug)]
pub struct Autopilot {
    /// What is known of the vehicle.
    pub vehicle: Vehicle,
    /// System and component that are listened to.
    target: Option<(u8, u8)>,
    dialect: Option<Dialect>,
    /// Another autopilot on the same link was told of.
    stranger_told: bool,
    rate_hz: f64,
    /// Altitude to fly at, mm above mean sea level.
    layer_mm: i32,
    request: Option<Request>,
    /// Next of the messages to ask for.
    subscribed: usize,
    stage: Stage,
    airborne: bool,
    /// Since when setpoints have been streamed.
    streaming_since: Option<i64>,
    /// Since when it climbs.
    climbing_since: Option<i64>,
    /// PX4: its own takeoff mode was seen.
    took_off: bool,
    reminded_ms: i64,
    /// The autopilot's last words of weight, and when it said them.
    last_text: Option<(String, i64)>,
}

impl Autopilot {
    /// `layer_mm` is the altitude to fly at, mm above mean sea level; positions are asked for
    /// at `rate_hz`.
    #[must_use]
    pub fn new(vehicle: Vehicle, layer_mm: i32, rate_hz: f64) -> Self {
        Self {
            vehicle,
            target: None,
            dialect: None,
            stranger_told: false,
            rate_hz,
            layer_mm,
            request: None,
            subscribed: 0,
            stage: Stage::Silent,
            airborne: false,
            streaming_since: None,
            climbing_since: None,
            took_off: false,
            reminded_ms: i64::MIN / 2,
            last_text: None,
        }
    }

    /// How far it is.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        self.stage
    }

    /// System and component of the autopilot, once heard.
    #[must_use]
    pub const fn target(&self) -> Option<(u8, u8)> {
        self.target
    }

    /// Its flight software, once heard.
    #[must_use]
    pub const fn dialect(&self) -> Option<Dialect> {
        self.dialect
    }

    /// In the air, takeoff over.
    #[must_use]
    pub const fn is_airborne(&self) -> bool {
        self.airborne
    }

    /// Mode in the last heartbeat.
    #[must_use]
    pub fn mode(&self) -> Option<Mode> {
        Some(self.dialect?.mode(self.vehicle.heartbeat?.0.custom_mode))
    }

    /// The mode in the users' words.
    #[must_use]
    pub fn mode_name(&self) -> String {
        match (self.dialect, self.vehicle.heartbeat) {
            (Some(dialect), Some((heartbeat, _))) => dialect.mode_name(heartbeat.custom_mode),
            _ => "unknown".into(),
        }
    }

    /// Armed in the last heartbeat.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.vehicle.heartbeat.is_some_and(|(heartbeat, _)| heartbeat.armed)
    }

    /// Takes in a message of system `from.0`, component `from.1`.
    pub fn hear(&mut self, from: (u8, u8), telemetry: &Telemetry, now_ms: i64, notices: &mut Vec<Notice>) -> Heard {
        match (self.target, telemetry) {
            (None, Telemetry::Heartbeat(heartbeat)) if heartbeat.autopilot != NO_AUTOPILOT => {
                self.identify(from, *heartbeat, notices);
            }
            (Some(target), _) if target == from => {}
            (Some(_), Telemetry::Heartbeat(heartbeat))
                if heartbeat.autopilot != NO_AUTOPILOT && !self.stranger_told =>
            {
                self.stranger_told = true;
                notices.push(Notice::warning(format!("system {} on the same link is not listened to", from.0)));
                return Heard::Noted;
            }
            // Before the first heartbeat, and of others on the same link.
            _ => return Heard::Noted,
        }
        match telemetry {
            Telemetry::Ack { command, result } => self.answered(*command, *result, now_ms, notices),
            Telemetry::Text { severity, text } => {
                if *severity <= TEXT_SEVERITY {
                    self.last_text = Some((text.clone(), now_ms));
                }
                notices.push(Notice { warning: *severity <= TEXT_SEVERITY, text: format!("autopilot: {text}") });
            }
            _ => {}
        }
        let before = self.mode_name();
        let heard = self.vehicle.hear(telemetry);
        match heard {
            Heard::Restarted => {
                notices.push(Notice::warning("the vehicle's clock started anew: it booted again, or it jumped"));
                (self.subscribed, self.request, self.airborne) = (0, None, false);
                if self.stage != Stage::Failed {
                    self.stage = Stage::Subscribing;
                }
            }
            Heard::ClockMoved(ms) => {
                notices.push(Notice::warning(format!("the autopilot corrected its clock by {ms} ms")));
            }
            Heard::Fix | Heard::Noted => {}
        }
        if let Telemetry::Heartbeat(_) = telemetry {
            let mode = self.mode_name();
            if before != mode && before != "unknown" {
                notices.push(Notice::info(format!("mode {before} -> {mode}")));
            }
        }
        self.watch_flight();
        heard
    }

    /// What to send now besides setpoints and heartbeats.
    pub fn poll(&mut self, now_ms: i64, leave: Leave, out: &mut Vec<Outgoing>, notices: &mut Vec<Notice>) {
        self.streaming_since = leave.streaming.then(|| self.streaming_since.unwrap_or(now_ms));
        match self.stage {
            Stage::Silent | Stage::Failed => return,
            Stage::Subscribing => self.subscribe(now_ms),
            Stage::Idle | Stage::BringUp | Stage::Flying => self.advance(now_ms, leave.may_start, notices),
        }
        let Some(request) = &mut self.request else { return };
        match request.poll(now_ms) {
            Ok(outgoing) => out.extend(outgoing),
            Err(failure) => self.failed(failure, now_ms, notices),
        }
    }

    /// The operator asks for a start, perhaps after a failure: nothing that went wrong before
    /// counts any more.
    pub fn start_anew(&mut self) {
        if self.stage == Stage::Failed && self.dialect.is_some() {
            self.stage = Stage::Subscribing;
            self.subscribed = 0;
        }
        (self.request, self.climbing_since, self.took_off) = (None, None, false);
    }

    /// Asks for the return home.
    pub fn return_home(&mut self, now_ms: i64) {
        self.end_flight(Dialect::return_home, now_ms);
    }

    /// Asks for a landing on the spot.
    pub fn land(&mut self, now_ms: i64) {
        self.end_flight(Dialect::land, now_ms);
    }

    fn end_flight(&mut self, mode: fn(Dialect) -> [f32; 2], now_ms: i64) {
        if let Some(dialect) = self.dialect {
            self.set_mode(mode(dialect), now_ms);
            if let Some(request) = &mut self.request {
                request.ends_flight = true;
            }
        }
    }

    /// Whether a command waits for its answer.
    #[must_use]
    pub fn is_asking(&self) -> bool {
        self.request.is_some_and(|request| !request.is_accepted())
    }

    fn identify(&mut self, from: (u8, u8), heartbeat: Heartbeat, notices: &mut Vec<Notice>) {
        self.target = Some(from);
        match Dialect::of(heartbeat.autopilot, heartbeat.kind) {
            Ok(dialect) => {
                self.dialect = Some(dialect);
                self.stage = Stage::Subscribing;
                notices.push(Notice::info(format!("{dialect}, system {}", from.0)));
            }
            Err(unfit) => {
                self.stage = Stage::Failed;
                notices.push(Notice::warning(format!("this vehicle cannot be flown: {unfit}")));
            }
        }
    }

    /// Messages to ask for and how often, Hz. SYSTEM_TIME comes as often as positions: by it
    /// their absence is noticed.
    fn subscriptions(&self) -> impl Iterator<Item = (u16, f64)> + use<> {
        let estimator = if self.dialect == Some(Dialect::Px4) { 230 } else { 193 };
        let rate = self.rate_hz;
        [(32, rate), (33, rate), (2, rate), (estimator, 2.0), (24, 1.0), (1, 1.0), (49, 0.5), (245, 1.0)].into_iter()
    }

    fn subscribe(&mut self, now_ms: i64) {
        if self.request.is_some_and(|request| request.is_accepted()) {
            self.subscribed += 1;
            self.request = None;
        }
        let Some((id, hz)) = self.subscriptions().nth(self.subscribed) else {
            self.stage = Stage::Idle;
            return;
        };
        let interval_us = (1e6 / hz).round() as f32;
        self.ask(command::MESSAGE_INTERVAL, [f32::from(id), interval_us, 0.0, 0.0, 0.0, 0.0, 0.0], now_ms);
    }

    /// Leads on towards flight, as far as is allowed.
    fn advance(&mut self, now_ms: i64, may_start: bool, notices: &mut Vec<Notice>) {
        let Some(dialect) = self.dialect else { return };
        let guided = self.mode() == Some(Mode::Guided);
        if self.airborne && guided {
            if self.stage != Stage::Flying {
                self.stage = Stage::Flying;
                self.request = None;
                notices.push(Notice::info(format!("airborne, {}", dialect.guided_name())));
            }
            return;
        }
        if !may_start {
            self.stage = Stage::Idle;
            // Nothing that leads to flight is repeated once the gate has closed. A return or a landing is, until
            // the autopilot has left the mode that takes setpoints.
            self.request = self.request.filter(|request| request.ends_flight && guided);
            return;
        }
        if let Some(missing) = self.missing() {
            self.remind(now_ms, notices, || format!("waiting for {missing}"));
            return;
        }
        self.stage = Stage::BringUp;
        match dialect {
            Dialect::ArduPilot if !guided => self.set_mode(dialect.guided(), now_ms),
            _ if !self.is_armed() && !self.airborne => {
                self.climbing_since = None;
                self.ask(command::ARM, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], now_ms);
            }
            _ if !self.airborne => self.take_off(dialect, now_ms, notices),
            // In the air; PX4 takes OFFBOARD only from a stream.
            _ => {
                if self.streaming_since.is_some_and(|since| now_ms - since >= PRESTREAM_MS) {
                    self.set_mode(dialect.guided(), now_ms);
                }
            }
        }
    }

    fn take_off(&mut self, dialect: Dialect, now_ms: i64, notices: &mut Vec<Notice>) {
        let Some(fix) = self.vehicle.fix else { return };
        let home_mm = fix.alt_mm - fix.relative_mm;
        let height_mm = self.layer_mm - home_mm;
        if height_mm < LEAST_TAKEOFF_MM {
            let (layer, home) = (f64::from(self.layer_mm) / 1e3, f64::from(home_mm) / 1e3);
            let text = format!(
                "its layer, {layer:.1} m above sea level, is less than 2 m above home ({home:.1} m): raise altitude.base_m"
            );
            return self.give_up(&text, notices);
        }
        if dialect == Dialect::Px4 && self.request.is_some_and(|r| r.command() == command::TAKEOFF && r.is_accepted()) {
            let ours = matches!(self.mode(), Some(Mode::TakeoffOrHold | Mode::Guided));
            if self.took_off && !ours {
                let text = format!("the mode became {} during takeoff: the pilot has it", self.mode_name());
                return self.give_up(&text, notices);
            }
            self.took_off |= ours;
        }
        let since = *self.climbing_since.get_or_insert(now_ms);
        let allowed_ms = CLIMB_START_MS + i64::from(height_mm) * 1000 / SLOWEST_CLIMB_MMPS;
        if now_ms - since > allowed_ms {
            let text = format!("it did not reach {:.1} m in {} s", f64::from(height_mm) / 1e3, allowed_ms / 1000);
            return self.give_up(&text, notices);
        }
        let altitude_m = match dialect {
            Dialect::ArduPilot => height_mm as f32 / 1e3,
            Dialect::Px4 => self.layer_mm as f32 / 1e3,
        };
        // Position and heading as they are: zero for ArduPilot, not-a-number for PX4.
        let here = if dialect == Dialect::Px4 { f32::NAN } else { 0.0 };
        let asked = self.request.is_some_and(|r| r.command() == command::TAKEOFF);
        if !asked {
            self.request = Some(Request::new(command::TAKEOFF, [0.0, 0.0, 0.0, here, here, here, altitude_m], now_ms));
            notices.push(Notice::info(format!("taking off to {:.1} m", f64::from(height_mm) / 1e3)));
        }
    }

    /// What is missing for a start.
    fn missing(&self) -> Option<&'static str> {
        let v = &self.vehicle;
        if v.fix.is_none() {
            Some("a position near the mission's origin")
        } else if v.estimator.is_none_or(|(healthy, _)| !healthy) {
            Some("the estimator to trust its position")
        } else if v.gps_fix.is_some_and(|(kind, _)| kind < 3) {
            Some("a 3D GPS fix")
        } else if !v.clock.is_set() {
            Some("the time (SYSTEM_TIME)")
        } else {
            None
        }
    }

    fn ask(&mut self, command: u16, params: [f32; 7], now_ms: i64) {
        if !self.request.is_some_and(|request| request.asks(command, &params)) {
            self.request = Some(Request::new(command, params, now_ms));
        }
    }

    fn set_mode(&mut self, [main, sub]: [f32; 2], now_ms: i64) {
        self.ask(command::SET_MODE, [1.0, main, sub, 0.0, 0.0, 0.0, 0.0], now_ms);
    }

    fn answered(&mut self, command: u16, result: u8, now_ms: i64, notices: &mut Vec<Notice>) {
        let Some(request) = self.request.as_mut().filter(|r| r.command() == command && !r.is_accepted()) else {
            return;
        };
        let answer = request.answer(result, now_ms);
        if let Err(failure) = answer {
            self.failed(failure, now_ms, notices);
        } else if !matches!(result, 0 | 5) {
            let why = self.words(now_ms);
            self.remind(now_ms, notices, || format!("{} refused by the autopilot{why}; trying again", what(command)));
        }
    }

    fn failed(&mut self, failure: Failure, now_ms: i64, notices: &mut Vec<Notice>) {
        let Some(request) = self.request.take() else { return };
        let what = what(request.command());
        if request.command() == command::MESSAGE_INTERVAL {
            // Some autopilots send what is needed unasked.
            let id = self.subscriptions().nth(self.subscribed).map_or(0, |(id, _)| id);
            notices.push(Notice::warning(format!(
                "the autopilot does not take a rate for message {id}; going on without"
            )));
            self.subscribed += 1;
            return;
        }
        let text = match failure {
            Failure::Unanswered => format!("{what}: no answer from the autopilot"),
            Failure::Refused => format!("{what} refused by the autopilot{}", self.words(now_ms)),
            Failure::Unsupported => format!("{what}: the autopilot does not know this command"),
        };
        self.give_up(&text, notices);
    }

    fn give_up(&mut self, text: &str, notices: &mut Vec<Notice>) {
        notices.push(Notice::warning(format!("not flying: {text}")));
        (self.request, self.stage) = (None, Stage::Failed);
    }

    /// The autopilot's own words, if it said any lately.
    fn words(&self, now_ms: i64) -> String {
        match &self.last_text {
            Some((text, at)) if now_ms - at <= TEXT_MS => format!(": {text}"),
            _ => String::new(),
        }
    }

    fn remind(&mut self, now_ms: i64, notices: &mut Vec<Notice>, text: impl FnOnce() -> String) {
        if now_ms - self.reminded_ms >= REMIND_MS {
            self.reminded_ms = now_ms;
            notices.push(Notice::info(text()));
        }
    }

    /// Notes takeoff and landing.
    fn watch_flight(&mut self) {
        let Some(fix) = self.vehicle.fix else { return };
        if !self.is_armed() || self.vehicle.on_ground == Some(true) {
            self.airborne = false;
        } else if !self.airborne {
            let reached = (fix.alt_mm - self.layer_mm).abs() <= REACHED_MM;
            // A vehicle that somebody else brought up is in the air wherever it is.
            let elsewhere = self.climbing_since.is_none() && fix.relative_mm >= FLYING_MM;
            self.airborne = reached && fix.relative_mm >= FLYING_MM || elsewhere;
        }
    }
}

/// A command in words.
const fn what(command: u16) -> &'static str {
    match command {
        command::ARM => "arming",
        command::TAKEOFF => "takeoff",
        command::SET_MODE => "the change of mode",
        command::MESSAGE_INTERVAL => "a message rate",
        _ => "a command",
    }
}
