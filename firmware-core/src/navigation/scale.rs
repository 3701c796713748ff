//! How large the map is in flight.

use super::frame::LocalPosition;
use crate::geometry::{TICKS_PER_U, Vec2};

/// Lengths and times of the map: how many metres a map unit and how many seconds a step has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapScale {
    /// Metres in a map unit.
    pub unit_m: f64,
    /// Milliseconds in a step.
    pub step_ms: u16,
}

impl MapScale {
    /// Seconds in a step.
    #[must_use]
    pub fn step_s(&self) -> f64 {
        f64::from(self.step_ms) / 1000.0
    }

    /// Metres to ticks, to the nearest, halves away from zero. Not-a-number becomes 0: callers
    /// refuse it first.
    #[must_use]
    pub fn ticks(&self, metres: f64) -> i32 {
        libm::round(metres / self.unit_m * f64::from(TICKS_PER_U)) as i32
    }

    /// A local position to map ticks.
    #[must_use]
    pub fn position(&self, place: LocalPosition) -> Vec2 {
        Vec2::from_ticks(self.ticks(place.east_mm / 1000.0), self.ticks(place.north_mm / 1000.0))
    }

    /// Map ticks to a local position.
    #[must_use]
    pub fn place(&self, position: Vec2) -> LocalPosition {
        let mm = |ticks: i32| f64::from(ticks) / f64::from(TICKS_PER_U) * self.unit_m * 1000.0;
        LocalPosition { east_mm: mm(position.x), north_mm: mm(position.y) }
    }

    /// A velocity east and north, m/s, to ticks a step.
    #[must_use]
    pub fn velocity(&self, east_mps: f64, north_mps: f64) -> Vec2 {
        let step_s = self.step_s();
        Vec2::from_ticks(self.ticks(east_mps * step_s), self.ticks(north_mps * step_s))
    }

    /// Metres a second in u a step.
    #[must_use]
    pub fn mps(&self, u_per_step: f32) -> f64 {
        f64::from(u_per_step) * self.unit_m / self.step_s()
    }

    /// Metres a second squared in u a step squared.
    #[must_use]
    pub fn mps2(&self, u_per_step2: f32) -> f64 {
        f64::from(u_per_step2) * self.unit_m / (self.step_s() * self.step_s())
    }
}
