//! Units and plane geometry.
//!
//! The map is measured in *map units* (u), time in *steps*. Positions are held
//! in [`TICKS_PER_U`]-ths of a unit and velocities in the same ticks per step, as
//! `i32`: exact on every target. `x` points east, `y` north.

use core::ops::{Add, Sub};

/// Fixed-point ticks in one map unit.
pub const TICKS_PER_U: i32 = 1024;

/// Side of the training map, u.
pub const MAP_SIDE_U: f32 = 200.0;
/// A PoI within this distance of a UAV is covered, u (the limit is inside).
pub const COVERAGE_RANGE_U: i32 = 10;
/// A PoI within this distance of a UAV is in its view, u (the limit is inside).
pub const OBSERVATION_RANGE_U: i32 = 13;
/// UAVs within this distance of each other are neighbours, u (the limit is inside).
pub const COMMUNICATION_RANGE_U: i32 = 18;
/// Greatest speed, u/step.
pub const SPEED_CAP_U: i32 = 4;

/// Coordinates beyond this magnitude (ticks) are clamped when they come from
/// floats or messages, so that differences never overflow: ±2¹⁸ u.
pub const COORDINATE_LIMIT: i32 = 1 << 28;

/// A position (ticks), an offset (ticks) or a velocity (ticks per step).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Vec2 {
    /// East.
    pub x: i32,
    /// North.
    pub y: i32,
}

impl Vec2 {
    /// From ticks; clamped to ±[`COORDINATE_LIMIT`].
    #[must_use]
    pub const fn from_ticks(x: i32, y: i32) -> Self {
        Self { x: clamp_tick(x), y: clamp_tick(y) }
    }

    /// From map units (or u/step), rounded to the nearest tick, halves away from
    /// zero; clamped to ±[`COORDINATE_LIMIT`]. Not-a-number becomes 0: callers that
    /// can meet one must refuse it first.
    #[must_use]
    pub fn from_u(x: f32, y: f32) -> Self {
        Self { x: tick_from_u(x), y: tick_from_u(y) }
    }

    /// Into map units.
    #[must_use]
    pub fn to_u(self) -> (f32, f32) {
        // Powers of two: exact while |tick| < 2^24.
        (self.x as f32 / TICKS_PER_U as f32, self.y as f32 / TICKS_PER_U as f32)
    }

    /// Squared length in ticks² when the vector is no longer than `range` ticks
    /// (the limit is inside), else `None`. `range` is at most 32,767 ticks (31 u).
    #[must_use]
    pub fn within(self, range: i32) -> Option<u32> {
        debug_assert!((0..=32_767).contains(&range));
        let range = range.unsigned_abs();
        let (x, y) = (self.x.unsigned_abs(), self.y.unsigned_abs());
        if x > range || y > range {
            return None;
        }
        // x, y <= 32,767: the sum of squares stays below 2^31.
        let d2 = x * x + y * y;
        (d2 <= range * range).then_some(d2)
    }
}

impl Add for Vec2 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::from_ticks(self.x.saturating_add(o.x), self.y.saturating_add(o.y))
    }
}

impl Sub for Vec2 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        // Both within ±2^28, so the difference fits; it is clamped no further.
        Self { x: self.x.saturating_sub(o.x), y: self.y.saturating_sub(o.y) }
    }
}

const fn clamp_tick(t: i32) -> i32 {
    if t > COORDINATE_LIMIT {
        COORDINATE_LIMIT
    } else if t < -COORDINATE_LIMIT {
        -COORDINATE_LIMIT
    } else {
        t
    }
}

fn tick_from_u(v: f32) -> i32 {
    let t = v * TICKS_PER_U as f32;
    // Float-to-int casts saturate and send NaN to 0, on every target alike.
    clamp_tick((if t < 0.0 { t - 0.5 } else { t + 0.5 }) as i32)
}

/// Measured state of one UAV.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// Position, ticks.
    pub position: Vec2,
    /// Velocity, ticks per step.
    pub velocity: Vec2,
}

/// `round(a / b)`, halves away from zero. `b` must be positive.
#[inline]
pub(crate) const fn div_round(a: i32, b: i32) -> i32 {
    if a < 0 { (a - b / 2) / b } else { (a + b / 2) / b }
}
