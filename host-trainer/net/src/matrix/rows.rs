//! Activations and gradients of many samples.

use crate::kernel::{Aligned, padded};

/// Most numbers in a row: four words of a mask.
pub(super) const WIDEST: usize = 256;

/// Activations or gradients, a row a sample, with a bit mask of the numbers that may differ from
/// zero: products skip the others. Rows begin at whole vectors; the padding is zeros.
#[derive(Clone, Debug)]
pub struct Rows {
    rows: usize,
    width: usize,
    stride: usize,
    /// Words of a row's mask.
    words: usize,
    values: Aligned,
    masks: Vec<u64>,
}

impl Rows {
    /// Rows of this width, none yet.
    ///
    /// # Panics
    /// When the width is not 1 to 256.
    #[must_use]
    pub fn new(width: usize) -> Self {
        assert!((1..=WIDEST).contains(&width), "a width of 1 to {WIDEST}, not {width}");
        // A stride of 512 bytes would put all numbers of a column into a few sets of the cache.
        let stride = if width > 64 && padded(width).is_multiple_of(64) { padded(width) + 16 } else { padded(width) };
        Self { rows: 0, width, stride, words: width.div_ceil(64), values: Aligned::default(), masks: Vec::new() }
    }

    /// Sets the number of rows; what is in them is not defined.
    pub fn resize(&mut self, rows: usize) {
        self.rows = rows;
        self.values.grow(rows * self.stride);
        if self.masks.len() < rows * self.words {
            self.masks.resize(rows * self.words, 0);
        }
    }

    /// How many rows.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Numbers in a row.
    #[must_use]
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Numbers from row to row.
    #[must_use]
    pub const fn stride(&self) -> usize {
        self.stride
    }

    /// The numbers of a row.
    #[must_use]
    pub fn row(&self, r: usize) -> &[f32] {
        &self.values[r * self.stride..][..self.width]
    }

    /// All rows with their padding, [`Self::stride`] numbers each.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values[..self.rows * self.stride]
    }

    /// All rows with their padding, to write. The masks are not kept up to date: see
    /// `fill_masks`.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values[..self.rows * self.stride]
    }

    /// The values and the words of their masks, `⌈width/64⌉` a row.
    pub(crate) fn values_and_masks_mut(&mut self) -> (&mut [f32], &mut [u64]) {
        (&mut self.values[..self.rows * self.stride], &mut self.masks[..self.rows * self.words])
    }

    /// Sets the masks to what is not zero.
    #[cfg(test)]
    pub(crate) fn update_masks(&mut self) {
        for r in 0..self.rows {
            for (word, part) in
                self.masks[r * self.words..].iter_mut().zip(self.values[r * self.stride..][..self.width].chunks(64))
            {
                *word = part.iter().enumerate().fold(0, |m, (c, v)| m | u64::from(*v != 0.0) << c);
            }
        }
    }

    /// A ReLU; the masks name what it lets through.
    pub(crate) fn rectify(&mut self) {
        let (width, stride, words) = (self.width, self.stride, self.words);
        let (values, masks) = self.values_and_masks_mut();
        for (row, masks) in values.chunks_exact_mut(stride).zip(masks.chunks_exact_mut(words)) {
            for (word, part) in masks.iter_mut().zip(row[..width].chunks_mut(64)) {
                *word = 0;
                for (c, v) in part.iter_mut().enumerate() {
                    *word |= u64::from(*v > 0.0) << c;
                    *v = v.max(0.0);
                }
            }
        }
    }

    /// Sets the masks to everything.
    pub(crate) fn fill_masks(&mut self) {
        self.masks[..self.rows * self.words].fill(u64::MAX);
    }

    /// How many numbers the masks name.
    pub(crate) fn nonzeros(&self) -> u64 {
        let (last, words) = (self.width - 64 * (self.words - 1), self.words);
        let beyond = u64::MAX.checked_shr(64 - last as u32).unwrap_or(0);
        let row = |row: &[u64]| -> u64 {
            let whole: u32 = row[..words - 1].iter().map(|w| w.count_ones()).sum();
            u64::from(whole + (row[words - 1] & beyond).count_ones())
        };
        self.masks[..self.rows * words].chunks_exact(words).map(row).sum()
    }

    /// The words of all masks, [`Self::words`] a row.
    pub(super) fn masks(&self) -> &[u64] {
        &self.masks[..self.rows * self.words]
    }

    /// Words of a row's mask.
    pub(crate) const fn words(&self) -> usize {
        self.words
    }

    /// Takes over the masks of rows of the same shape.
    pub(super) fn copy_masks(&mut self, other: &Self) {
        self.masks[..self.rows * self.words].copy_from_slice(&other.masks[..self.rows * self.words]);
    }
}
