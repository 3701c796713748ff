//! What goes into the gate at a tick.

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
    pub mode: FlightMode,
    /// Armed, as in the last heartbeat.
    pub armed: bool,
    /// In the air, takeoff over.
    pub airborne: bool,
    /// Battery left, in thousandths; nothing when the autopilot does not know.
    pub battery_permille: Option<u16>,
    /// When the last valid message of any other UAV came; nothing when none ever did.
    pub swarm_ms: Option<u32>,
    /// The measured height is in doubt, by other sources of it.
    pub height_doubted: bool,
    /// UAVs that start together with this one are not in the air yet.
    pub swarm_incomplete: bool,
    /// The actor's self-test passed.
    pub self_test: bool,
    /// What the operator asked for since the last tick. Each request is given once.
    pub operator: Option<Request>,
    /// The setpoint that the actor proposes; nothing while it has not decided.
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

/// The setpoint that the actor proposes now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Proposal {
    /// When the decision behind it was made, on the vehicle's clock.
    pub decided_ms: u32,
    /// Velocity, mm/s.
    pub velocity: Vector,
    /// Acceleration, mm/s².
    pub acceleration: Vector,
    /// Altitude to hold, mm above the mission's origin (see [`super::altitude_layer_mm`]).
    pub altitude_mm: i32,
}

/// Flight modes, as far as the gate tells them apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FlightMode {
    /// No heartbeat has said yet.
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
