//! How far a vehicle flies on whose node has died: the last setpoint is left standing.

/// An autopilot goes on with the last setpoint, acceleration and all, for this long: ArduPilot's default
/// GUID_TIMEOUT, s.
pub(crate) const STANDING_S: f64 = 3.0;
/// By then it may be so many times as fast as the greatest speed of the scenario.
pub(crate) const STANDING_SPEED: f64 = 1.24;
/// The autopilot's own braking after its timeout, m/s².
const BRAKING_MPS2: f64 = 2.5;
/// Velocities that are tried.
const TRIED: u32 = 50;

/// Greatest horizontal speed and acceleration of the scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speeds {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
}

/// A bound for the distance, m: a point mass follows the most that is fed forward for `timeout_s`, then brakes.
/// A vehicle that lags behind what it is asked flies some metres more; see `docs/safety.md`.
#[must_use]
pub fn left_standing_m(timeout_s: f64, speeds: Speeds) -> f64 {
    let from = |share: u32| {
        let speed = speeds.speed_mps * f64::from(share) / f64::from(TRIED);
        let standing = (STANDING_SPEED * speeds.speed_mps - speed) / STANDING_S;
        let acceleration = standing.min(speeds.acceleration_mps2);
        let end = speed + acceleration * timeout_s;
        (speed + end) / 2.0 * timeout_s + end * end / (2.0 * BRAKING_MPS2)
    };
    (0..=TRIED).map(from).fold(0.0, f64::max)
}
