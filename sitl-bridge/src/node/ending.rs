//! The end of a flight: the vehicle is braked before it is let go.

use firmware_core::gate::{Inputs, Setpoint, Vector, Verdict};

/// Slower than this the vehicle is let go, mm/s.
const STANDING_MM_S: u32 = 300;
/// It is let go after this in any case, ms of the node's clock.
const LONGEST_MS: i64 = 3000;

/// The braking under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ending {
    since_ms: i64,
}

impl Ending {
    /// Braking that begins now, by the node's clock.
    pub const fn new(now_ms: i64) -> Self {
        Self { since_ms: now_ms }
    }

    /// Whether the vehicle may be let go after this verdict: it stands still by measurement and by the
    /// setpoint, the gate no longer lets setpoints through, or the time is over.
    pub fn is_over(&self, inputs: &Inputs, verdict: &Verdict, now_ms: i64) -> bool {
        let Some(setpoint) = verdict.setpoint() else { return true };
        let stands = inputs.state.is_some_and(|state| state.velocity.within(STANDING_MM_S));
        let asked = setpoint.velocity == Vector::ZERO && setpoint.acceleration == Vector::ZERO;
        (stands && asked) || now_ms - self.since_ms >= LONGEST_MS
    }
}

/// The last setpoint, where the gate lets one through: it asks for standing still.
pub(super) fn last_setpoint(verdict: &Verdict) -> Option<Setpoint> {
    let setpoint = verdict.setpoint()?;
    Some(Setpoint { altitude_mm: setpoint.altitude_mm, ..Setpoint::default() })
}
