//! A uniform grid of points for range queries whose cost does not grow with the map.

use std::ops::Range;

/// Range queries reach this much farther than asked, u, so that rounding (of `f32`, and of positions to ticks) leaves
/// no point out.
const MARGIN_U: f32 = 0.01;

/// Points sorted by square cells. A point's *slot* is its place in that order: the cells of a row lie side by side, so
/// a square of cells is one run of slots for each of its rows.
#[derive(Clone, Debug)]
pub(crate) struct CellGrid {
    /// Cells along a side.
    cells: usize,
    /// Cells per unit of length.
    per_u: f32,
    /// First slot of each cell, and one past the last.
    starts: Vec<u32>,
    /// Index of the point in each slot.
    points: Vec<u32>,
    /// Cell of each point; kept between calls to save its allocation.
    cell_of: Vec<u32>,
}

impl CellGrid {
    /// A grid for up to `capacity` points on a map of `side_u`, with cells about as
    /// wide as the range looked up (wider on a map much larger than its points need).
    pub(crate) fn new(side_u: f32, range_u: f32, capacity: usize) -> Self {
        let wanted = (side_u / (range_u + MARGIN_U)).floor();
        let most = (4.0 * capacity as f32).sqrt().ceil();
        let cells = wanted.min(most).max(1.0);
        let count = (cells * cells) as usize;
        Self {
            cells: cells as usize,
            per_u: cells / side_u,
            starts: vec![0; count + 1],
            points: Vec::with_capacity(capacity),
            cell_of: Vec::with_capacity(capacity),
        }
    }

    /// Sorts the points anew; points of a cell keep their order.
    pub(crate) fn rebuild(&mut self, xs: &[f32], ys: &[f32]) {
        self.starts.fill(0);
        self.cell_of.clear();
        for (&x, &y) in xs.iter().zip(ys) {
            let cell = self.axis(y) * self.cells + self.axis(x);
            self.cell_of.push(cell as u32);
            self.starts[cell] += 1;
        }
        // Counts become ends; filling from the last point turns them into starts.
        let mut end = 0;
        for s in &mut self.starts {
            end += *s;
            *s = end;
        }
        self.points.clear();
        self.points.resize(xs.len(), 0);
        for (point, &cell) in self.cell_of.iter().enumerate().rev() {
            let slot = &mut self.starts[cell as usize];
            *slot -= 1;
            self.points[*slot as usize] = point as u32;
        }
    }

    /// Index of the point in each slot.
    pub(crate) fn points(&self) -> &[u32] {
        &self.points
    }

    /// Runs of slots that hold every point within `range_u` of (x, y), and possibly others.
    pub(crate) fn around(&self, x: f32, y: f32, range_u: f32) -> impl Iterator<Item = Range<usize>> + use<'_> {
        let reach = range_u + MARGIN_U;
        let (west, east) = (self.axis(x - reach), self.axis(x + reach));
        (self.axis(y - reach)..=self.axis(y + reach)).map(move |row| {
            let row = row * self.cells;
            self.starts[row + west] as usize..self.starts[row + east + 1] as usize
        })
    }

    /// Cell along an axis; the edge cells reach to infinity.
    fn axis(&self, u: f32) -> usize {
        // The cast saturates at 0.
        ((u * self.per_u) as u32 as usize).min(self.cells - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_point_in_range_is_found_once(
            points in prop::collection::vec((0.0f32..=200.0, 0.0f32..=200.0), 1..80),
            range in 1.0f32..40.0,
            cell in 1.0f32..60.0,
            (x, y) in (-5.0f32..205.0, -5.0f32..205.0),
        ) {
            let (xs, ys): (Vec<_>, Vec<_>) = points.into_iter().unzip();
            let mut grid = CellGrid::new(200.0, cell, xs.len());
            grid.rebuild(&xs, &ys);
            let mut found: Vec<_> = grid.around(x, y, range).flatten().map(|s| grid.points()[s]).collect();
            found.sort_unstable();
            let before = found.len();
            found.dedup();
            prop_assert_eq!(before, found.len());
            for (i, (px, py)) in xs.iter().zip(&ys).enumerate() {
                let near = (px - x).powi(2) + (py - y).powi(2) <= range * range;
                prop_assert!(!near || found.binary_search(&(i as u32)).is_ok());
            }
        }
    }

    #[test]
    fn a_large_map_with_few_points_has_few_cells() {
        let grid = CellGrid::new(16_384.0, 13.0, 20);
        assert!(grid.starts.len() <= 101, "{}", grid.starts.len());
    }
}
