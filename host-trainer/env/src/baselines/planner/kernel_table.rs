//! Kernels of PoIs that are known by their place alone.

use super::prior_map::{PriorMap, axis_kernel};
use core::ops::Range;

/// Places along an axis for which the kernel is at hand, 1/u.
const PER_U: f64 = 4.0;

/// The kernel's factors of all columns (or rows) for PoIs at every quarter of a unit.
#[derive(Clone, Debug)]
pub(super) struct KernelTable {
    cells: usize,
    /// For each place those of all cells.
    factors: Vec<f64>,
}

impl KernelTable {
    pub(super) fn new(map: &PriorMap) -> Self {
        let cells = map.cells();
        let places = ((map.side_u() * PER_U) as usize).max(1);
        let of_place = |k: usize| (0..cells).map(move |c| axis_kernel(c, (k as f64 + 0.5) / PER_U));
        Self { cells, factors: (0..places).flat_map(of_place).collect() }
    }

    /// Adds the kernel of a PoI at `at` (u) to the cells `rows` of column `a`.
    pub(super) fn add(&self, at: (f64, f64), a: usize, rows: Range<usize>, sum: &mut [f64]) {
        let of_column = self.of(at.0)[a];
        let of_rows = &self.of(at.1)[rows];
        sum.iter_mut().zip(of_rows).for_each(|(sum, of_row)| *sum += of_column * of_row);
    }

    /// The factors for a coordinate, u; those of the edge beyond it.
    fn of(&self, axis: f64) -> &[f64] {
        let last = self.factors.len() - self.cells;
        let first = ((axis * PER_U) as usize * self.cells).min(last);
        &self.factors[first..first + self.cells]
    }
}
