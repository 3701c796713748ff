//! Targets 1 u apart around a point.

use super::inputs::PlannerInputs;
use super::prior_map::PriorMap;
use super::valuation::{ValueSource, positive, remaining_steps};

/// Targets along a side of the grid.
pub(super) const FINE: usize = 7;
/// Numbers in a line of it: one more, so that a line is whole vector registers.
pub(super) const LINE: usize = 8;

/// A square grid of targets.
pub(super) struct FineGrid {
    /// East coordinates, u.
    pub x: [f64; FINE],
    /// North coordinates, u.
    pub y: [f64; LINE],
    /// Steps of the horizon that remain at each target after the flight there.
    remaining: [[f64; LINE]; FINE],
}

impl FineGrid {
    /// The grid around `middle`, u.
    pub(super) fn new(inputs: &PlannerInputs<'_>, map: &PriorMap, middle: (f64, f64)) -> Self {
        // Targets closer to the edge cover less of the map.
        let inside = |v: f64| v.clamp(2.0, map.side_u() - 2.0);
        let offset = |k: usize| k as f64 - (FINE / 2) as f64;
        let x = std::array::from_fn(|i| inside(middle.0 + offset(i)));
        let y = std::array::from_fn(|j| inside(middle.1 + offset(j)));
        let remaining = x.map(|x| y.map(|y| remaining_steps(inputs, (x, y))));
        Self { x, y, remaining }
    }

    /// Adds the value of `source` to every target; `share` is the part of it that counts at a squared distance.
    #[inline]
    pub(super) fn add(&self, source: &ValueSource, value: &mut [[f64; LINE]; FINE], share: impl Fn(f64) -> f64) {
        let &ValueSource { at, weight, claimed } = source;
        let dy2 = self.y.map(|y| (y - at.1) * (y - at.1));
        for ((x, remaining), value) in self.x.iter().zip(&self.remaining).zip(value) {
            let dx2 = (x - at.0) * (x - at.0);
            for ((dy2, remaining), value) in dy2.iter().zip(remaining).zip(value) {
                *value += weight * positive(remaining - claimed) * share(dx2 + dy2);
            }
        }
    }
}
