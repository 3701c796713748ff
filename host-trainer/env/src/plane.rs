//! Distances in the plane, from multiplications, sums and square roots alone: every target computes them to the same
//! bit (`hypot` and `powi` promise no such thing).

use std::ops::{Add, Mul, Sub};

/// A coordinate: `f32` as worlds hold them, `f64` in planners and oracles.
pub(crate) trait Coordinate: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The square root, rounded correctly.
    fn root(self) -> Self;
}

impl Coordinate for f32 {
    fn root(self) -> Self {
        self.sqrt()
    }
}

impl Coordinate for f64 {
    fn root(self) -> Self {
        self.sqrt()
    }
}

/// Squared distance of two points.
#[inline]
pub(crate) fn squared_distance<C: Coordinate>(a: (C, C), b: (C, C)) -> C {
    let (dx, dy) = (a.0 - b.0, a.1 - b.1);
    dx * dx + dy * dy
}

/// Distance of two points.
#[inline]
pub(crate) fn distance<C: Coordinate>(a: (C, C), b: (C, C)) -> C {
    squared_distance(a, b).root()
}

/// A point of a world in double precision, which is exact.
#[inline]
pub(crate) fn widened(p: (f32, f32)) -> (f64, f64) {
    (f64::from(p.0), f64::from(p.1))
}
