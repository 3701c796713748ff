//! The part of the map within a UAV's reach, as cells with the value of exploring them.

use core::ops::Range;

/// Number of cells beyond a target's own cell that can count for it: those whose centre is within 11 u.
pub(super) const MARGIN: usize = 2;

/// One column of cells, to be filled in from what the UAV knows.
pub(super) struct CellColumn<'c> {
    /// Its number.
    pub a: usize,
    /// Its rows.
    pub rows: Range<usize>,
    /// Output: density of known PoIs (their summed kernels) at each cell.
    pub density: &'c mut [f64],
    /// Output: which cells have been seen.
    pub explored: &'c mut [bool],
}

/// The value of the unseen cells around a UAV, column by column, with a margin of cells without value.
#[derive(Clone, Debug, Default)]
pub(super) struct LocalMap {
    /// Columns without the margin.
    pub columns: Range<usize>,
    /// Rows without the margin.
    pub rows: Range<usize>,
    /// Entries from one column to the next.
    stride: usize,
    /// Value of a step near each cell; 0 for cells that have been seen.
    pub weight: Vec<f64>,
    /// Steps that other UAVs' claims on each cell secure.
    pub claimed: Vec<f64>,
}

impl LocalMap {
    /// Becomes a map of these cells, without value and claims.
    pub(super) fn reset(&mut self, columns: Range<usize>, rows: Range<usize>) {
        self.stride = rows.len() + 2 * MARGIN;
        let cells = (columns.len() + 2 * MARGIN) * self.stride;
        for values in [&mut self.weight, &mut self.claimed] {
            values.clear();
            values.resize(cells, 0.0);
        }
        (self.columns, self.rows) = (columns, rows);
    }

    /// Index of the cell that is `da − MARGIN` columns and `db − MARGIN` rows from the cell (`a`, `b`).
    pub(super) fn index_from(&self, (a, b): (usize, usize), (da, db): (usize, usize)) -> usize {
        (a - self.columns.start + da) * self.stride + b - self.rows.start + db
    }

    /// Index of a cell.
    pub(super) fn index(&self, cell: (usize, usize)) -> usize {
        self.index_from(cell, (MARGIN, MARGIN))
    }
}
