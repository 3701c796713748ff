//! Sets as rows of a bit matrix, for fast subset tests.

/// One set over `0..columns` for each row.
#[derive(Clone, Debug, Default)]
pub(crate) struct BitMatrix {
    words: usize,
    bits: Vec<u64>,
}

impl BitMatrix {
    /// A matrix of empty sets.
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        let words = columns.div_ceil(64);
        Self { words, bits: vec![0; rows * words] }
    }

    /// Puts `column` into set `row`.
    pub(crate) fn set(&mut self, row: usize, column: usize) {
        self.bits[row * self.words + column / 64] |= 1 << (column % 64);
    }

    /// Empties set `row`.
    pub(crate) fn clear(&mut self, row: usize) {
        self.bits[row * self.words..(row + 1) * self.words].fill(0);
    }

    /// Whether set `a` lies in set `b`.
    pub(crate) fn is_subset(&self, a: usize, b: usize) -> bool {
        self.row(a).iter().zip(self.row(b)).all(|(a, b)| a & !b == 0)
    }

    fn row(&self, row: usize) -> &[u64] {
        &self.bits[row * self.words..(row + 1) * self.words]
    }
}
