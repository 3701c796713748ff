//! Weights, and sums of their gradients.

use crate::kernel::{Aligned, PANEL, padded};

/// A matrix in panels of 64 columns (the last one narrower), each panel row by row: what
/// the kernel needs of it at a time lies together. The last panel is padded with zeros.
#[derive(Clone, Debug)]
pub struct Panels {
    rows: usize,
    columns: usize,
    values: Aligned,
}

impl Panels {
    /// A matrix of zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, values: Aligned::zeros(rows * padded(columns)) }
    }

    /// First column, place and padded width of each panel.
    pub(crate) fn panels(&self) -> impl Iterator<Item = (usize, usize, usize)> + use<> {
        let (rows, columns) = (self.rows, padded(self.columns));
        (0..columns).step_by(PANEL).map(move |c| (c, c * rows, PANEL.min(columns - c)))
    }

    /// Rows and columns.
    pub(crate) const fn shape(&self) -> (usize, usize) {
        (self.rows, self.columns)
    }

    /// All numbers, panel by panel.
    pub(crate) fn values(&self) -> &[f32] {
        &self.values
    }

    /// All numbers, panel by panel, to write.
    pub(crate) fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Takes the numbers of a row-major matrix.
    pub fn load(&mut self, flat: &[f32]) {
        for (first, at, width) in self.panels() {
            let used = width.min(self.columns - first);
            for (row, from) in self.values[at..].chunks_exact_mut(width).zip(flat.chunks_exact(self.columns)) {
                row[..used].copy_from_slice(&from[first..first + used]);
            }
        }
    }

    /// Takes the transpose of a row-major matrix of `columns` rows.
    pub fn load_transposed(&mut self, flat: &[f32]) {
        for (first, at, width) in self.panels() {
            let used = width.min(self.columns - first);
            for (r, row) in self.values[at..].chunks_exact_mut(width).take(self.rows).enumerate() {
                for (c, v) in row[..used].iter_mut().enumerate() {
                    *v = flat[(first + c) * self.rows + r];
                }
            }
        }
    }

    /// Writes the numbers as a row-major matrix.
    pub fn store(&self, flat: &mut [f32]) {
        for (first, at, width) in self.panels() {
            let used = width.min(self.columns - first);
            for (row, to) in self.values[at..].chunks_exact(width).zip(flat.chunks_exact_mut(self.columns)) {
                to[first..first + used].copy_from_slice(&row[..used]);
            }
        }
    }

    /// Writes the transpose, of `columns` rows, as a row-major matrix.
    pub fn store_transposed(&self, flat: &mut [f32]) {
        for (first, at, width) in self.panels() {
            let used = width.min(self.columns - first);
            for (r, row) in self.values[at..].chunks_exact(width).take(self.rows).enumerate() {
                for (c, v) in row[..used].iter().enumerate() {
                    flat[(first + c) * self.rows + r] = *v;
                }
            }
        }
    }
}
