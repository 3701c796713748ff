//! From an autopilot's floats to the gate's integers. What is no number, or none that a UAV can have, is
//! refused here and reported to the gate ([`super::Inputs::refused`]); it never becomes a position.

use super::vector::{POSITION_LIMIT_MM, RATE_LIMIT};

/// A number of the telemetry that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TelemetryError {
    /// Not a number, or infinite.
    #[error("not a finite number")]
    NotFinite,
    /// Finite, but beyond what the gate computes with.
    #[error("beyond ±100 km or ±100 m/s")]
    OutOfRange,
}

/// Metres as mm, rounded to the nearest.
///
/// # Errors
/// Not finite, or beyond ±100 km.
pub fn millimetres(metres: f32) -> Result<i32, TelemetryError> {
    thousandths(metres, POSITION_LIMIT_MM)
}

/// m/s as mm/s (or m/s² as mm/s²), rounded to the nearest.
///
/// # Errors
/// Not finite, or beyond ±100 m/s.
pub fn millimetres_per_second(metres_per_second: f32) -> Result<i32, TelemetryError> {
    thousandths(metres_per_second, RATE_LIMIT)
}

fn thousandths(value: f32, limit: i32) -> Result<i32, TelemetryError> {
    if !value.is_finite() {
        return Err(TelemetryError::NotFinite);
    }
    // Beyond the range of an i32 this is infinite or large: the cast saturates, and the limit refuses it.
    let scaled = value * 1000.0;
    let rounded = (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32;
    if (-limit..=limit).contains(&rounded) { Ok(rounded) } else { Err(TelemetryError::OutOfRange) }
}
