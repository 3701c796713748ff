//! The map as the planners see it: cells, and where PoIs are to be expected.

use super::poi;
use crate::scenario::PoiDistribution;
use crate::world::World;

/// Side of a cell, u. Its centre is also a place to fly to.
pub(super) const CELL_U: f64 = 5.0;
/// Spread of the guess that PoIs lie near PoIs, u.
const NEAR_U: f64 = 22.0;

/// What stays the same during an episode.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    side_u: f64,
    cells: usize,
    distribution: PoiDistribution,
    pois: f64,
    /// Chance density of a PoI along one axis, by cell, 1/u.
    along: Vec<f64>,
    /// For each PoI, how near each column, then each row, of cells is: the product is the
    /// nearness of a cell.
    near: Vec<f64>,
}

impl Ground {
    pub(super) fn new(world: &World) -> Self {
        let s = world.scenario();
        let side_u = f64::from(s.side_u);
        let cells = (side_u / CELL_U).ceil() as usize;
        let centre = |c: usize| CELL_U * (c as f64 + 0.5);
        // A cloud's centre is uniform between 0.15 and 0.85 of the side, its deviation 0.1.
        let below = |x: f64| 0.5 * (1.0 + libm::erf(x / (0.1 * side_u * std::f64::consts::SQRT_2)));
        let density = |x: f64| (below(x - 0.15 * side_u) - below(x - 0.85 * side_u)) / (0.7 * side_u);
        let along = (0..cells).map(|c| density(centre(c))).collect();
        let mut near = Vec::with_capacity(s.pois * cells * 2);
        for p in 0..s.pois {
            let (x, y) = poi(world, p);
            for axis in [x, y] {
                near.extend((0..cells).map(|c| libm::exp(-(centre(c) - axis).powi(2) / (2.0 * NEAR_U * NEAR_U))));
            }
        }
        Self { side_u, cells, distribution: s.distribution, pois: s.pois as f64, along, near }
    }

    /// Side of the map, u.
    pub(super) fn side_u(&self) -> f64 {
        self.side_u
    }

    /// Cells along one side.
    pub(super) fn cells(&self) -> usize {
        self.cells
    }

    /// Centre of the cell of this column and row, u.
    pub(super) fn centre(&self, (a, b): (usize, usize)) -> (f64, f64) {
        (CELL_U * (a as f64 + 0.5), CELL_U * (b as f64 + 0.5))
    }

    /// Cells whose centre may be within `range` of an axis value: first and one past last.
    pub(super) fn span(&self, axis: f64, range: f64) -> std::ops::Range<usize> {
        // Casts saturate at 0.
        let from = ((axis - range) / CELL_U) as usize;
        let to = ((axis + range) / CELL_U) as usize + 1;
        from.min(self.cells)..to.min(self.cells)
    }

    /// PoIs to be expected in a cell before any is seen.
    pub(super) fn expected(&self, (a, b): (usize, usize)) -> f64 {
        match self.distribution {
            PoiDistribution::Clustered => self.along[a] * self.along[b] * self.pois * CELL_U * CELL_U,
            PoiDistribution::Uniform => self.pois / (self.cells * self.cells) as f64,
        }
    }

    /// How near a PoI is to a cell: 1 at its centre, falling as a normal curve.
    pub(super) fn nearness(&self, poi: usize, (a, b): (usize, usize)) -> f64 {
        let first = 2 * poi * self.cells;
        self.near[first + a] * self.near[first + self.cells + b]
    }

    /// Adds a PoI's nearness to the cells of a column.
    pub(super) fn add_nearness(&self, poi: usize, a: usize, rows: std::ops::Range<usize>, sum: &mut [f64]) {
        let first = 2 * poi * self.cells;
        let along = self.near[first + a];
        let line = &self.near[first + self.cells..][rows];
        sum.iter_mut().zip(line).for_each(|(sum, near)| *sum += along * near);
    }
}
