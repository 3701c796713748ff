//! One dense layer, read in place from the actor file.

use crate::kernel::{self, Dense, Finish};

/// Greatest number of rows of a layer.
pub const MAX_ROWS: usize = 128;
/// Greatest number of columns of a layer (the observation is the longest input).
pub const MAX_INPUTS: usize = 160;
/// Greatest magnitude of a bias. With 160 columns of int8 products the biased sum
/// stays below 2²³ + 2²⁴ < 2²⁵.
pub const MAX_BIAS: i32 = 1 << 24;

/// A dense layer of known width.
#[derive(Clone, Copy, Debug, Default)]
pub struct Layer<'a> {
    columns: usize,
    dense: Dense<'a>,
}

/// Values between layers, int8 in 16 bits, at a multiple of four bytes: so the kernel takes
/// two at a time.
#[repr(align(4))]
pub(crate) struct Activations<const N: usize>(pub(crate) [i16; N]);

impl<const N: usize> Activations<N> {
    pub(crate) const fn zero() -> Self {
        Self([0; N])
    }
}

/// The next even number.
pub(crate) const fn even(n: usize) -> usize {
    n + (n & 1)
}

/// What is wrong with the numbers of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerError {
    /// The weights or the table end before the layer does.
    Short,
    /// A bias beyond ±[`MAX_BIAS`] or a negative multiplier.
    OutOfRange,
}

impl<'a> Layer<'a> {
    /// Bytes of weights of a layer of this shape.
    #[must_use]
    pub const fn weight_bytes(rows: usize, columns: usize) -> usize {
        even(rows) * even(columns)
    }

    /// Bytes of biases and multipliers of a layer of this many rows.
    #[must_use]
    pub const fn table_bytes(rows: usize) -> usize {
        8 * rows
    }

    /// Takes a layer off the front of `weights` and `tables`.
    pub(crate) fn take(
        weights: &mut &'a [u8],
        tables: &mut &'a [u8],
        rows: usize,
        columns: usize,
    ) -> Result<Self, LayerError> {
        let (own, rest) = weights.split_at_checked(Self::weight_bytes(rows, columns)).ok_or(LayerError::Short)?;
        *weights = rest;
        let Rectified { biases, multipliers } = Rectified::take(tables, rows)?;
        Ok(Self { columns, dense: Dense { weights: own, biases, multipliers } })
    }

    /// `out[r] = clamp(round(m_r·(Σ_c w[r][c]·x[c] + b_r) / 2³²), 0, 127)` for every row;
    /// `x` holds at least the layer's columns, padded with a zero to an even number,
    /// `out` at least its rows.
    pub(crate) fn apply(&self, x: &[i16], out: &mut [i16]) {
        self.run(x, out, Finish::Rectified);
    }

    /// As [`Self::apply`], with the sum shifted left by [`kernel::WIDE_SHIFT`] first and
    /// the whole i16 range as output.
    pub(crate) fn apply_wide(&self, x: &[i16], out: &mut [i16]) {
        self.run(x, out, Finish::Wide);
    }

    /// Its first row, for sums that the kernel has no form for.
    pub(crate) fn first_row(&self) -> Row<'a> {
        let word = |words: &[[u8; 4]]| words.first().map_or(0, |&w| i32::from_le_bytes(w));
        Row {
            pairs: self.dense.weights.as_chunks().0,
            bias: word(self.dense.biases),
            multiplier: word(self.dense.multipliers),
        }
    }

    fn run(&self, x: &[i16], out: &mut [i16], finish: Finish) {
        // Loading bounds the columns, and callers size their buffers by the maximum.
        if let Some(x) = x.get(..even(self.columns)) {
            self.dense.apply(x, out, finish);
        }
    }
}

/// A row of a layer of one row or two.
#[derive(Clone, Copy)]
pub(crate) struct Row<'a> {
    pairs: &'a [[u8; 2]],
    bias: i32,
    multiplier: i32,
}

impl Row<'_> {
    /// Its weights, column by column.
    pub(crate) fn weights(&self) -> impl Iterator<Item = i8> {
        self.pairs.iter().map(|&[_, first]| first as i8)
    }

    /// The output from the sum, as [`Layer::apply_wide`] has it. Sums within ±2²⁵ do not overflow.
    pub(crate) fn wide(&self, sum: i32) -> i32 {
        let wide = kernel::requantise((sum + self.bias) << kernel::WIDE_SHIFT, self.multiplier);
        wide.clamp(i32::from(i16::MIN), i32::from(i16::MAX))
    }
}

/// Biases and multipliers of a layer.
pub(crate) struct Rectified<'a> {
    pub(crate) biases: &'a [[u8; 4]],
    pub(crate) multipliers: &'a [[u8; 4]],
}

impl<'a> Rectified<'a> {
    /// Takes those of a layer of this many rows off the front of `tables`.
    pub(crate) fn take(tables: &mut &'a [u8], rows: usize) -> Result<Self, LayerError> {
        let (biases, rest) = tables.split_at_checked(4 * rows).ok_or(LayerError::Short)?;
        let (multipliers, rest) = rest.split_at_checked(4 * rows).ok_or(LayerError::Short)?;
        *tables = rest;
        let (biases, multipliers) = (biases.as_chunks().0, multipliers.as_chunks().0);
        let sound = words(biases).all(|b| (-MAX_BIAS..=MAX_BIAS).contains(&b)) && words(multipliers).all(|m| m >= 0);
        if sound { Ok(Self { biases, multipliers }) } else { Err(LayerError::OutOfRange) }
    }

    /// A row's output from its sum: `clamp(round(m·(sum + b) / 2³²), 0, 127)`.
    pub(crate) fn finish(sum: i32, bias: [u8; 4], multiplier: [u8; 4]) -> i16 {
        let (b, m) = (i32::from_le_bytes(bias), i32::from_le_bytes(multiplier));
        kernel::requantise(sum + b, m).clamp(0, 127) as i16
    }
}

fn words(words: &[[u8; 4]]) -> impl Iterator<Item = i32> + '_ {
    words.iter().map(|word| i32::from_le_bytes(*word))
}

const _: () = assert!(MAX_INPUTS <= kernel::MAX_COLUMNS);
