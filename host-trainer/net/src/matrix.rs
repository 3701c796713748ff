//! Matrices as the kernel takes them, and the products of a layer.

use crate::kernel::{Aligned, Finish, LANES, PANEL, Product, Start, Vectorised, padded, vectorised};

/// Most numbers in a row: four words of marks.
const WIDEST: usize = 256;

/// Activations or gradients: a row a sample, with a mark for every number that may differ
/// from zero. Rows begin at whole vectors; the padding is zeros.
#[derive(Clone, Debug)]
pub struct Rows {
    rows: usize,
    width: usize,
    step: usize,
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
        // A step of 512 bytes would put all numbers of a column into a few sets of the cache.
        let step = if width > 64 && padded(width).is_multiple_of(64) { padded(width) + 16 } else { padded(width) };
        Self { rows: 0, width, step, words: width.div_ceil(64), values: Aligned::default(), masks: Vec::new() }
    }

    /// Sets the number of rows; what is in them is not defined.
    pub fn resize(&mut self, rows: usize) {
        self.rows = rows;
        self.values.grow(rows * self.step);
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
    pub const fn step(&self) -> usize {
        self.step
    }

    /// The numbers of a row.
    #[must_use]
    pub fn row(&self, r: usize) -> &[f32] {
        &self.values[r * self.step..][..self.width]
    }

    /// All rows with their padding, [`Self::step`] numbers each.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values[..self.rows * self.step]
    }

    /// As [`Self::values`]. Marks are not kept up: see [`Self::mark`] and [`Self::mark_all`].
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values[..self.rows * self.step]
    }

    /// The words of marks, `⌈width/64⌉` a row, with the values they belong to.
    pub(crate) fn parts_mut(&mut self) -> (&mut [f32], &mut [u64]) {
        (&mut self.values[..self.rows * self.step], &mut self.masks[..self.rows * self.words])
    }

    /// Marks what is not zero.
    pub fn mark(&mut self) {
        for r in 0..self.rows {
            for (word, part) in
                self.masks[r * self.words..].iter_mut().zip(self.values[r * self.step..][..self.width].chunks(64))
            {
                *word = part.iter().enumerate().fold(0, |m, (c, v)| m | u64::from(*v != 0.0) << c);
            }
        }
    }

    /// Marks everything.
    pub fn mark_all(&mut self) {
        self.masks[..self.rows * self.words].fill(u64::MAX);
    }

    /// How many numbers are marked.
    #[must_use]
    pub fn marked(&self) -> u64 {
        let (last, words) = (self.width - 64 * (self.words - 1), self.words);
        let beyond = u64::MAX.checked_shr(64 - last as u32).unwrap_or(0);
        let row = |row: &[u64]| -> u64 {
            let whole: u32 = row[..words - 1].iter().map(|w| w.count_ones()).sum();
            u64::from(whole + (row[words - 1] & beyond).count_ones())
        };
        self.masks[..self.rows * words].chunks_exact(words).map(row).sum()
    }

    /// Takes over the marks of rows of the same shape.
    fn mark_as(&mut self, other: &Self) {
        self.masks[..self.rows * self.words].copy_from_slice(&other.masks[..self.rows * self.words]);
    }
}

/// A matrix in panels of 64 columns (the last one narrower), each panel row by row: what
/// the kernel needs of it at a time lies together. The last panel is padded with zeros.
#[derive(Clone, Debug)]
pub struct Panels {
    rows: usize,
    columns: usize,
    values: Aligned,
}

impl Panels {
    /// Zeros.
    #[must_use]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, values: Aligned::zeros(rows * padded(columns)) }
    }

    /// First column, place and padded width of each panel.
    pub(crate) fn panels(&self) -> impl Iterator<Item = (usize, usize, usize)> + use<> {
        let (rows, columns) = (self.rows, padded(self.columns));
        (0..columns).step_by(PANEL).map(move |c| (c, c * rows, PANEL.min(columns - c)))
    }

    /// A row a line, and columns.
    pub(crate) const fn shape(&self) -> (usize, usize) {
        (self.rows, self.columns)
    }

    /// All numbers, panel by panel.
    pub(crate) fn values(&self) -> &[f32] {
        &self.values
    }

    /// As [`Self::values`].
    pub(crate) fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Takes a matrix, row by row.
    pub fn load(&mut self, flat: &[f32]) {
        for (first, at, width) in self.panels() {
            let used = width.min(self.columns - first);
            for (row, from) in self.values[at..].chunks_exact_mut(width).zip(flat.chunks_exact(self.columns)) {
                row[..used].copy_from_slice(&from[first..first + used]);
            }
        }
    }

    /// Takes the transpose of a matrix of `columns` rows, row by row.
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

    /// Writes the matrix, row by row.
    pub fn store(&self, flat: &mut [f32]) {
        for (first, at, width) in self.panels() {
            let used = width.min(self.columns - first);
            for (row, to) in self.values[at..].chunks_exact(width).zip(flat.chunks_exact_mut(self.columns)) {
                to[first..first + used].copy_from_slice(&row[..used]);
            }
        }
    }

    /// Writes the transpose, `columns` rows, row by row.
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

/// What the rows of [`multiply`] start from.
#[derive(Clone, Copy, Debug)]
pub enum From<'a> {
    /// Zeros.
    Zero,
    /// What stands in the output.
    Kept,
    /// A bias, padded to whole vectors.
    Bias(&'a [f32]),
}

/// What [`multiply`] does to the sums.
#[derive(Clone, Copy, Debug)]
pub enum To<'a> {
    /// Nothing; marks are not kept up.
    Plain,
    /// A ReLU; marks what it lets through.
    Relu,
    /// The gradient of the ReLU that had this output; marks as there.
    Gate(&'a Rows),
}

/// `out = to(from + x·w)`, a row for every row of `x`; only marked numbers of `x` count.
///
/// # Panics
/// When shapes do not fit.
pub fn multiply(x: &Rows, w: &Panels, from: From<'_>, to: To<'_>, out: &mut Rows) {
    assert!(x.width == w.rows && w.columns == out.width, "{}·{}x{}={}", x.width, w.rows, w.columns, out.width);
    if matches!(from, From::Kept) {
        assert_eq!(x.rows, out.rows, "rows to add to");
    } else {
        out.resize(x.rows);
    }
    if let To::Gate(active) = to {
        assert!(active.rows == out.rows && active.width == out.width, "a gate of the output's shape");
        out.mark_as(active);
    }
    if x.rows == 0 {
        return;
    }
    let (step, words) = (out.step, out.words);
    let (values, masks) = out.parts_mut();
    for (first, at, width) in w.panels() {
        let product = Product {
            rows: x.rows,
            terms: x.width,
            columns: width,
            values: &x.values,
            steps: [x.step, 1],
            masks: &x.masks,
            mask_step: x.words,
            weights: &w.values[at..],
            weight_step: width,
        };
        let start = match from {
            From::Zero => Start::Zero,
            From::Kept => Start::Kept,
            From::Bias(b) => Start::Bias(&b[first..]),
        };
        let finish = match to {
            To::Plain => Finish::Plain,
            To::Relu => Finish::Relu { masks: &mut masks[first / 64..], step: words },
            To::Gate(active) => Finish::Gate { active: &active.values[first..], step: active.step },
        };
        product.run(start, finish, &mut values[first..], step);
    }
}

/// Adds `xᵀ·g` to `sum`: the gradient of weights by their inputs and the gradient at
/// their outputs. Only marked numbers of `x` count.
///
/// # Panics
/// When shapes do not fit.
pub fn add_outer(x: &Rows, g: &Rows, sum: &mut Panels) {
    assert!(x.rows == g.rows && x.width == sum.rows && g.width == sum.columns, "shapes of a weight gradient");
    for (first, rows) in chunks(x.rows) {
        // Marks of up to 64 samples, a word an input.
        let mut columns = [[0; 64]; WIDEST / 64];
        vectorised(Columns {
            masks: &x.masks[first * x.words..(first + rows) * x.words],
            words: x.words,
            columns: &mut columns,
        });
        for (column, at, width) in sum.panels() {
            let product = Product {
                rows: x.width,
                terms: rows,
                columns: width,
                values: &x.values[first * x.step..],
                steps: [1, x.step],
                masks: columns.as_flattened(),
                mask_step: 1,
                weights: &g.values[first * g.step + column..],
                weight_step: g.step,
            };
            product.run(Start::Kept, Finish::Plain, &mut sum.values[at..], width);
        }
    }
}

/// Adds the sum of the rows of `g` to `sum`, which has one row: the gradient of a bias.
///
/// # Panics
/// When shapes do not fit.
pub fn add_rows(g: &Rows, sum: &mut Panels) {
    assert!(sum.rows == 1 && g.width == sum.columns, "shapes of a bias gradient");
    for (first, rows) in chunks(g.rows) {
        for (column, at, width) in sum.panels() {
            let product = Product {
                rows: 1,
                terms: rows,
                columns: width,
                values: &[1.0],
                steps: [0, 0],
                masks: &[u64::MAX],
                mask_step: 0,
                weights: &g.values[first * g.step + column..],
                weight_step: g.step,
            };
            product.run(Start::Kept, Finish::Plain, &mut sum.values[at..], width);
        }
    }
}

/// First row and number of rows of the parts of at most 64 rows, as even as can be.
fn chunks(rows: usize) -> impl Iterator<Item = (usize, usize)> {
    let count = rows.div_ceil(64);
    (0..count).map(move |k| (k * rows / count, (k + 1) * rows / count - k * rows / count))
}

/// Marks by column from marks by row.
struct Columns<'a> {
    masks: &'a [u64],
    words: usize,
    columns: &'a mut [[u64; 64]],
}

impl Vectorised for Columns<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (w, columns) in self.columns.iter_mut().enumerate().take(self.words) {
            columns.iter_mut().zip(self.masks.iter().skip(w).step_by(self.words)).for_each(|(c, m)| *c = *m);
            transpose(columns);
        }
    }
}

/// Transposes 64 × 64 bits (Warren, Hacker's Delight, 7–3).
#[inline(always)]
fn transpose(words: &mut [u64; 64]) {
    swap_halves::<32>(words, 0x0000_0000_ffff_ffff);
    swap_halves::<16>(words, 0x0000_ffff_0000_ffff);
    swap_halves::<8>(words, 0x00ff_00ff_00ff_00ff);
    swap_halves::<4>(words, 0x0f0f_0f0f_0f0f_0f0f);
    swap_halves::<2>(words, 0x3333_3333_3333_3333);
    swap_halves::<1>(words, 0x5555_5555_5555_5555);
}

/// Exchanges the upper halves of the first `N` words with the lower halves of the next `N`,
/// in every `2N` bits of every `2N` words.
#[inline(always)]
fn swap_halves<const N: usize>(words: &mut [u64; 64], mask: u64) {
    for block in words.chunks_exact_mut(2 * N) {
        let (first, second) = block.split_at_mut(N);
        for (a, b) in first.iter_mut().zip(second) {
            let swap = ((*a >> N) ^ *b) & mask;
            *a ^= swap << N;
            *b ^= swap;
        }
    }
}

const _: () = assert!(PANEL == 64 && PANEL.is_multiple_of(LANES), "a panel is a word of marks wide");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_change_places() {
        let mut words = std::array::from_fn(|k| (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let before: [u64; 64] = words;
        transpose(&mut words);
        for (r, row) in before.iter().enumerate() {
            for (c, column) in words.iter().enumerate() {
                assert_eq!(row >> c & 1, column >> r & 1, "{r} {c}");
            }
        }
    }

    #[test]
    fn parts_are_even() {
        assert_eq!(chunks(130).collect::<Vec<_>>(), [(0, 43), (43, 43), (86, 44)]);
        assert_eq!(chunks(64).collect::<Vec<_>>(), [(0, 64)]);
        assert_eq!(chunks(0).count(), 0);
    }
}
