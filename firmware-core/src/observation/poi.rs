//! The PoIs in view: which neighbours cover them, and which are nearest.

use super::layout::DESCRIBED_POIS;
use super::nearest::insert_sorted;
use super::scene::Scene;
use crate::geometry::{COVERAGE_RANGE_U, OBSERVATION_RANGE_U, TICKS_PER_U, Vec2, div_round};
use heapless::Vec;

/// [`OBSERVATION_RANGE_U`] in ticks.
pub(super) const OBSERVATION_RANGE: i32 = OBSERVATION_RANGE_U * TICKS_PER_U;
/// [`COVERAGE_RANGE_U`] in ticks.
pub(super) const COVERAGE_RANGE: i32 = COVERAGE_RANGE_U * TICKS_PER_U;

/// Which neighbours cover a PoI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CoveredBy {
    /// None.
    Nobody = 0,
    /// Only neighbours that yield to this UAV.
    Yielding = 1,
    /// One that has priority over this UAV.
    Priority = 2,
}

impl CoveredBy {
    /// The number in the observation.
    pub(super) const fn code(self) -> i8 {
        match self {
            Self::Nobody => 0,
            Self::Yielding => 64,
            Self::Priority => 127,
        }
    }

    /// Which neighbours of the scene cover the PoI at this offset, which lies within the view.
    fn of(poi: Vec2, scene: &Scene<'_>) -> Self {
        let mut covered = Self::Nobody;
        for n in scene.neighbours.as_slice() {
            // On each axis at most (13 + 18)·1,024 = 31,744 ticks, so the sum of squares stays below 2³¹.
            let (x, y) = (poi.x - n.offset.x, poi.y - n.offset.y);
            if x * x + y * y <= COVERAGE_RANGE * COVERAGE_RANGE {
                if !scene.has_priority_over(n) {
                    return Self::Priority;
                }
                covered = Self::Yielding;
            }
        }
        covered
    }
}

/// A PoI in view, packed so that one comparison orders by distance and then by offset:
/// d² (28 bits), Δx + 2¹⁴ and Δy + 2¹⁴ (15 bits each), [`CoveredBy`] (2 bits).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct VisiblePoi(u64);

impl VisiblePoi {
    const AXIS_BITS: u32 = 15;
    const BIAS: i32 = 1 << (Self::AXIS_BITS - 1);

    /// `offset` lies within the view and `d2` is its squared length.
    fn new(offset: Vec2, d2: u32, covered: CoveredBy) -> Self {
        // |Δ| ≤ 13·1,024 < 2¹⁴, so both fit their bits, and d² < 2²⁸.
        let axis = |t: i32| u64::from((t + Self::BIAS).unsigned_abs());
        let order = (u64::from(d2) << Self::AXIS_BITS) | axis(offset.x);
        Self((((order << Self::AXIS_BITS) | axis(offset.y)) << 2) | covered as u64)
    }

    pub(super) fn covered_by(self) -> CoveredBy {
        match self.0 & 3 {
            0 => CoveredBy::Nobody,
            1 => CoveredBy::Yielding,
            _ => CoveredBy::Priority,
        }
    }

    /// From the UAV, ticks.
    pub(super) fn offset(self) -> Vec2 {
        let axis = |shift: u32| ((self.0 >> shift) & ((1 << Self::AXIS_BITS) - 1)) as i32 - Self::BIAS;
        Vec2 { x: axis(2 + Self::AXIS_BITS), y: axis(2) }
    }
}

/// The PoIs in view that are available to this UAV: no neighbour with priority covers them.
#[derive(Default)]
pub(super) struct AvailablePois {
    /// How many.
    pub(super) count: i32,
    sum: (i32, i32),
}

impl AvailablePois {
    /// Adds one at an offset within the view.
    fn add(&mut self, offset: Vec2) {
        self.count += 1;
        // |Δ| < 2^14: sums of 2^16 PoIs fit.
        self.sum = (self.sum.0.wrapping_add(offset.x), self.sum.1.wrapping_add(offset.y));
    }

    /// Their mean offset, ticks; zero when there are none.
    pub(super) fn mean_offset(&self) -> Vec2 {
        let n = self.count.max(1);
        Vec2 { x: div_round(self.sum.0, n), y: div_round(self.sum.1, n) }
    }
}

/// The PoIs in view.
pub(super) struct VisiblePois {
    /// The nearest, nearest first (equal distances by offset).
    pub(super) nearest: Vec<VisiblePoi, DESCRIBED_POIS>,
    /// The available ones among them all.
    pub(super) available: AvailablePois,
}

impl VisiblePois {
    /// Those of the PoIs at `positions` (ticks) that are in view.
    pub(super) fn new(scene: &Scene<'_>, positions: impl IntoIterator<Item = Vec2>) -> Self {
        let mut visible = Self { nearest: Vec::new(), available: AvailablePois::default() };
        for p in positions {
            let offset = p - scene.own.position;
            let Some(d2) = offset.within(OBSERVATION_RANGE) else { continue };
            let covered = CoveredBy::of(offset, scene);
            if covered != CoveredBy::Priority {
                visible.available.add(offset);
            }
            insert_sorted(&mut visible.nearest, VisiblePoi::new(offset, d2, covered), VisiblePoi::lt);
        }
        visible
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn packing_a_poi_loses_nothing(
            (x, y) in (-OBSERVATION_RANGE..=OBSERVATION_RANGE, -OBSERVATION_RANGE..=OBSERVATION_RANGE),
            covered in prop::sample::select(&[CoveredBy::Nobody, CoveredBy::Yielding, CoveredBy::Priority]),
        ) {
            let offset = Vec2 { x, y };
            prop_assume!(offset.within(OBSERVATION_RANGE).is_some());
            let p = VisiblePoi::new(offset, offset.within(OBSERVATION_RANGE).unwrap_or(0), covered);
            prop_assert_eq!((p.offset(), p.covered_by()), (offset, covered));
        }
    }
}
