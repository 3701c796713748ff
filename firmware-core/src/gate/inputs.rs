//! What goes into the gate at a tick, and what comes out.

use super::reason::Reason;
use super::vector::Vector;

/// Everything the gate looks at. One value a tick; the gate keeps what it must remember.
///
/// Times ending in `_ms` are moments of the vehicle's clock (ms since its boot, as MAVLink's `time_boot_ms`)
/// unless their description says otherwise; they wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// The vehicle's clock: the newest time heard from it in any message; nothing before the first.
    pub now_ms: Option<u32>,
    /// The own computer's clock, monotonic, wrapping. Only differences count.
    pub wall_ms: u32,
    /// Newest measured state; nothing before the first.
    pub state: Option<Measured>,
    /// Since the last tick a number arrived that is not finite or out of range (see [`super::telemetry`]).
    pub refused: bool,
    /// Two sources of the own position disagree now.
    pub sources_disagree: bool,
    /// The estimator's flags were heard lately and are all as they should be.
    pub ekf_ok: bool,
    /// Newest GPS fix type as in MAVLink's `GPS_FIX_TYPE` (3 is a 3D fix); nothing when not heard lately.
    pub gps_fix: Option<u8>,
    /// When the autopilot's last heartbeat came.
    pub heartbeat_ms: Option<u32>,
    /// Flight mode in the last heartbeat.
    pub mode: Mode,
    /// Armed, as in the last heartbeat.
    pub armed: bool,
    /// In the air, takeoff over.
    pub airborne: bool,
    /// Battery left, in thousandths; nothing when the autopilot does not know.
    pub battery_permille: Option<u16>,
    /// When the last valid message of any other UAV came; nothing when none ever did.
    pub swarm_ms: Option<u32>,
    /// The actor's self-test passed.
    pub self_test: bool,
    /// What the operator asked for since the last tick. Each request is given once.
    pub operator: Option<Request>,
    /// What the actor wants; nothing while it has not decided.
    pub proposal: Option<Proposal>,
}

/// A measured state in the swarm's common frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured {
    /// When it was measured, on the vehicle's clock.
    pub time_ms: u32,
    /// Position, mm.
    pub position: Vector,
    /// Altitude above the mission's origin, mm.
    pub altitude_mm: i32,
    /// Velocity, mm/s.
    pub velocity: Vector,
    /// Vertical speed, mm/s, up.
    pub climb_mm_s: i32,
}

/// What the actor wants now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Proposal {
    /// When the decision behind it was made, on the vehicle's clock.
    pub decided_ms: u32,
    /// Velocity, mm/s.
    pub velocity: Vector,
    /// Acceleration, mm/s².
    pub acceleration: Vector,
    /// Altitude to hold, mm above the mission's origin (see [`super::layer_mm`]).
    pub altitude_mm: i32,
}

/// Flight modes, as far as the gate tells them apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Mode {
    /// No heartbeat has told yet.
    #[default]
    Unknown,
    /// The mode that takes setpoints: ArduPilot's GUIDED, PX4's OFFBOARD.
    Guided,
    /// Any other: the pilot or a failsafe flies.
    Other,
}

/// What the operator can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Request {
    /// Take the vehicle: GUIDED, arm and take off as far as that is still to be done, then fly.
    Start,
    /// Let the vehicle go: no more setpoints.
    Release,
    /// Let it return home.
    Return,
}

/// What may be sent at this tick. Nothing else may.
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// No setpoint and no command.
    Silent(Reason),
    /// No flight yet: mode, arming and takeoff commands may be sent. With a setpoint (it asks for standing still)
    /// that is to be streamed, as PX4 wants before it takes OFFBOARD.
    BringUp(Option<Setpoint>),
    /// Send the actor's setpoint, as limited.
    Stream(Setpoint),
    /// Send this setpoint instead of the actor's: it brakes, or leads back inside the fence.
    Hold(Reason, Setpoint),
    /// Send one command to return home (RTL), and no setpoint.
    Return(Reason),
}

impl Verdict {
    /// The setpoint to be sent, if any.
    #[must_use]
    pub const fn setpoint(&self) -> Option<Setpoint> {
        match *self {
            Self::BringUp(setpoint) => setpoint,
            Self::Stream(setpoint) | Self::Hold(_, setpoint) => Some(setpoint),
            Self::Silent(_) | Self::Return(_) => None,
        }
    }

    /// Why the actor does not fly now; nothing while it does or is being brought up.
    #[must_use]
    pub const fn reason(&self) -> Option<Reason> {
        match *self {
            Self::Silent(reason) | Self::Hold(reason, _) | Self::Return(reason) => Some(reason),
            Self::BringUp(_) | Self::Stream(_) => None,
        }
    }

    /// One word: `silent`, `bring_up`, `stream`, `hold` or `return`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Silent(_) => "silent",
            Self::BringUp(_) => "bring_up",
            Self::Stream(_) => "stream",
            Self::Hold(..) => "hold",
            Self::Return(_) => "return",
        }
    }
}

/// A setpoint within all limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Setpoint {
    /// Velocity, mm/s.
    pub velocity: Vector,
    /// Vertical speed, mm/s, up.
    pub climb_mm_s: i32,
    /// Acceleration to feed forward, mm/s².
    pub acceleration: Vector,
    /// The altitude that the vertical speed leads to, mm above the mission's origin.
    pub altitude_mm: i32,
    /// What the gate changed.
    pub limited: Limited,
}

/// Which limits changed what was proposed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limited {
    /// It was too fast.
    pub speed: bool,
    /// Its acceleration was too great, or its velocity too far from the last one.
    pub acceleration: bool,
    /// It would have left the fence.
    pub fence: bool,
    /// Its altitude was outside the band.
    pub altitude: bool,
}

impl Limited {
    /// Whether anything was changed.
    #[must_use]
    pub const fn any(self) -> bool {
        self.speed || self.acceleration || self.fence || self.altitude
    }
}
