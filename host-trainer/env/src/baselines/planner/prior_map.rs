//! The map in cells, with the prior: where PoIs are to be expected before any is seen.

use super::known::poi_position;
use crate::scenario::PoiDistribution;
use crate::world::World;

/// Side of a cell, u. Its centre is also a candidate target.
pub(super) const CELL_U: f64 = 5.0;
/// Standard deviation of the Gaussian kernel by which known PoIs make further ones likely, u.
const KERNEL_U: f64 = 22.0;

/// A grid of cells over the map and the expected PoIs of each; the same during a whole episode.
#[derive(Clone, Debug)]
pub(super) struct PriorMap {
    side_u: f64,
    cells: usize,
    distribution: PoiDistribution,
    pois: f64,
    /// Marginal probability density of a PoI along one axis, by cell, 1/u.
    marginal: Vec<f64>,
    /// For each PoI the kernel's factor of each column, then of each row: their product is the kernel at a cell.
    kernel: Vec<f64>,
}

impl PriorMap {
    pub(super) fn new(world: &World) -> Self {
        let s = world.scenario();
        let side_u = f64::from(s.side_u);
        let cells = (side_u / CELL_U).ceil() as usize;
        // A cluster's centre is uniform between 0.15 and 0.85 of the side, its standard deviation 0.1 of the side.
        let cumulative = |x: f64| 0.5 * (1.0 + libm::erf(x / (0.1 * side_u * std::f64::consts::SQRT_2)));
        let density = |x: f64| (cumulative(x - 0.15 * side_u) - cumulative(x - 0.85 * side_u)) / (0.7 * side_u);
        let marginal = (0..cells).map(|c| density(axis_centre(c))).collect();
        let mut kernel = Vec::with_capacity(s.pois * cells * 2);
        for p in 0..s.pois {
            let (x, y) = poi_position(world, p);
            for axis in [x, y] {
                kernel.extend((0..cells).map(|c| axis_kernel(c, axis)));
            }
        }
        Self { side_u, cells, distribution: s.distribution, pois: s.pois as f64, marginal, kernel }
    }

    /// Side of the map, u.
    pub(super) fn side_u(&self) -> f64 {
        self.side_u
    }

    /// Cells along one side.
    pub(super) fn cells(&self) -> usize {
        self.cells
    }

    /// Centre of the cell in column `a` and row `b`, u.
    pub(super) fn centre(&self, (a, b): (usize, usize)) -> (f64, f64) {
        (CELL_U * (a as f64 + 0.5), CELL_U * (b as f64 + 0.5))
    }

    /// Columns (or rows) whose centre may be within `range` of a coordinate, u.
    pub(super) fn span(&self, axis: f64, range: f64) -> std::ops::Range<usize> {
        // Casts saturate at 0.
        let from = ((axis - range) / CELL_U) as usize;
        let to = ((axis + range) / CELL_U) as usize + 1;
        from.min(self.cells)..to.min(self.cells)
    }

    /// Expected number of PoIs in a cell before any is seen.
    pub(super) fn expected_pois(&self, (a, b): (usize, usize)) -> f64 {
        match self.distribution {
            PoiDistribution::Clustered => self.marginal[a] * self.marginal[b] * self.pois * CELL_U * CELL_U,
            PoiDistribution::Uniform => self.pois / (self.cells * self.cells) as f64,
        }
    }

    /// The Gaussian kernel of a PoI at a cell's centre: 1 at the PoI.
    pub(super) fn kernel(&self, poi: usize, (a, b): (usize, usize)) -> f64 {
        let first = 2 * poi * self.cells;
        self.kernel[first + a] * self.kernel[first + self.cells + b]
    }

    /// Adds a PoI's kernel to the cells `rows` of column `a`.
    pub(super) fn add_kernel(&self, poi: usize, a: usize, rows: std::ops::Range<usize>, sum: &mut [f64]) {
        let first = 2 * poi * self.cells;
        let of_column = self.kernel[first + a];
        let of_rows = &self.kernel[first + self.cells..][rows];
        sum.iter_mut().zip(of_rows).for_each(|(sum, of_row)| *sum += of_column * of_row);
    }
}

/// The middle of a column (or row), u.
fn axis_centre(c: usize) -> f64 {
    CELL_U * (c as f64 + 0.5)
}

/// The kernel's factor of a column (or row) for a PoI at this coordinate, u.
pub(super) fn axis_kernel(c: usize, axis: f64) -> f64 {
    libm::exp(-(axis_centre(c) - axis).powi(2) / (2.0 * KERNEL_U * KERNEL_U))
}
