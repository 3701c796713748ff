//! Vectors in the plane, as integers, with lengths that are exact or too short, never too long.

use core::num::NonZeroU64;
use core::ops::{Add, Sub};

/// Greatest magnitude of a coordinate, mm: 100 km. Bounds every product in the gate.
pub const POSITION_LIMIT_MM: i32 = 100_000_000;
/// Greatest magnitude of a velocity or acceleration component, mm/s or mm/s².
pub const RATE_LIMIT: i32 = 100_000;

/// One unit of a [`Unit`]'s components.
const ONE: i64 = 1 << 15;

/// A position or an offset (mm), a velocity (mm/s) or an acceleration (mm/s²) in the horizontal plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Vector {
    /// East.
    pub east: i32,
    /// North.
    pub north: i32,
}

impl Vector {
    /// Nowhere, or still.
    pub const ZERO: Self = Self { east: 0, north: 0 };

    /// From its components.
    #[must_use]
    pub const fn new(east: i32, north: i32) -> Self {
        Self { east, north }
    }

    /// Squared length.
    #[must_use]
    pub const fn length_squared(self) -> u64 {
        let (e, n) = (self.east.unsigned_abs() as u64, self.north.unsigned_abs() as u64);
        // Each square is at most 2^62: the sum fits.
        e * e + n * n
    }

    /// Length, rounded down.
    #[must_use]
    pub const fn length(self) -> u32 {
        // The root of at most 2^63 is below 2^32.
        self.length_squared().isqrt() as u32
    }

    /// Whether it is no longer than `limit`, exactly.
    #[must_use]
    pub const fn within(self, limit: u32) -> bool {
        let limit = limit as u64;
        self.length_squared() <= limit * limit
    }

    /// The same direction, and no longer than `limit`, exactly.
    #[must_use]
    pub fn shortened_to(self, limit: u32) -> Self {
        if self.within(limit) {
            return self;
        }
        // Rounded up, so that the components, rounded toward zero, are never too long.
        let length = self.length_squared().isqrt() + 1;
        self.scaled(limit, length)
    }

    /// `self · numerator / denominator`, each component rounded toward zero and kept in 32 bits.
    /// Nothing when the denominator is 0.
    #[must_use]
    pub fn scaled(self, numerator: u32, denominator: u64) -> Self {
        match NonZeroU64::new(denominator) {
            Some(d) => Self::new(scale(self.east, numerator, d), scale(self.north, numerator, d)),
            None => Self::ZERO,
        }
    }

    /// Components clamped to ±`limit`.
    #[must_use]
    pub const fn clamped(self, limit: i32) -> Self {
        Self::new(clamp(self.east, limit), clamp(self.north, limit))
    }
}

impl Add for Vector {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.east.saturating_add(o.east), self.north.saturating_add(o.north))
    }
}

impl Sub for Vector {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.east.saturating_sub(o.east), self.north.saturating_sub(o.north))
    }
}

/// A direction, in 32,768ths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unit {
    east: i64,
    north: i64,
}

impl Unit {
    /// The direction of an offset (components up to 2·[`POSITION_LIMIT_MM`]) and its length, mm; nothing of no
    /// offset.
    pub fn new(east: i64, north: i64) -> Option<(Self, i64)> {
        let squared = (east * east + north * north).unsigned_abs();
        // Short offsets get a finer length: below 1 km in 1024ths of a mm.
        let shift = if squared < 1 << 40 { 10 } else { 0 };
        let length = NonZeroU64::new((squared << (2 * shift)).isqrt())?;
        let part = |v: i64| {
            let q = (v.unsigned_abs() << (15 + shift)) / length;
            if v < 0 { -(q as i64) } else { q as i64 }
        };
        Some((Self { east: part(east), north: part(north) }, (length.get() >> shift) as i64))
    }

    /// Due east.
    pub const EAST: Self = Self { east: ONE, north: 0 };

    /// The opposite direction.
    pub const fn reversed(self) -> Self {
        Self { east: -self.east, north: -self.north }
    }

    /// How far `v` goes in this direction, rounded up.
    pub const fn along(self, v: Vector) -> i64 {
        // |component| <= 2^15 and |v| < 2^31: below 2^48.
        (self.east * v.east as i64 + self.north * v.north as i64 + ONE - 1) >> 15
    }

    /// Sine of half the angle that a line going on in the `next` direction leaves at its bend, in 32,768ths: 1
    /// when it goes straight on, 0 when it turns back.
    pub const fn half_angle_sine(self, next: Self) -> u32 {
        let cosine_of_turn = self.east * next.east + self.north * next.north;
        // sin²(θ/2) = (1 − cos θ)/2, and cos θ = −cos(turn).
        let squared = (ONE * ONE + cosine_of_turn) / 2;
        if squared > 0 { (squared as u64).isqrt() as u32 } else { 0 }
    }

    /// This direction with a length; the length within ±2³¹.
    pub const fn times(self, length: i64) -> Vector {
        Vector::new((self.east * length / ONE) as i32, (self.north * length / ONE) as i32)
    }
}

/// `a - b`, without saturation.
pub(super) fn difference(a: Vector, b: Vector) -> (i64, i64) {
    (i64::from(a.east) - i64::from(b.east), i64::from(a.north) - i64::from(b.north))
}

/// `v · numerator / denominator`, rounded toward zero, kept in 32 bits.
fn scale(v: i32, numerator: u32, denominator: NonZeroU64) -> i32 {
    let q = u64::from(v.unsigned_abs()) * u64::from(numerator) / denominator;
    let q = if q > i32::MAX as u64 { i32::MAX } else { q as i32 };
    if v < 0 { -q } else { q }
}

/// `v` kept within ±`limit`.
pub(super) const fn clamp(v: i32, limit: i32) -> i32 {
    if v > limit {
        limit
    } else if v < -limit {
        -limit
    } else {
        v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shortened_vector_is_never_too_long_and_keeps_its_direction() {
        for v in [(3000, 4000), (1768, 1768), (-7, 1), (i32::MIN, i32::MAX), (0, -100_000)] {
            let v = Vector::new(v.0, v.1);
            for limit in [0, 1, 5, 2500, 5000, 99_999] {
                let short = v.shortened_to(limit);
                assert!(short.within(limit), "{v:?} {limit}");
                assert!(v.within(limit) || short.length() + 3 >= limit, "{v:?} {limit} {short:?}");
            }
        }
        assert_eq!(Vector::new(3, 4).shortened_to(5), Vector::new(3, 4));
    }

    #[test]
    fn a_direction_has_unit_length_near_and_far() {
        for (e, n) in [(1, 0), (1, 1), (-3, 4), (999_999, 1), (100_000_000, -200_000_000)] {
            let (unit, length) = Unit::new(e, n).unwrap();
            assert_eq!(length, ((e * e + n * n) as u64).isqrt() as i64);
            let v = unit.times(10_000);
            assert!((9_995..=10_001).contains(&v.length()), "{e} {n} {v:?}");
            assert!((unit.along(v) - 10_000).abs() <= 6);
        }
        assert_eq!(Unit::new(0, 0), None);
    }
}
