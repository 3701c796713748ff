//! One dense layer, read in place from the actor file.

use crate::kernel::{dense, requantise};

/// Greatest number of rows of a layer.
pub const MAX_ROWS: usize = 128;
/// Greatest number of columns of a layer (the observation is the longest input).
pub const MAX_COLUMNS: usize = 144;
/// Greatest magnitude of a bias. With 144 columns of int8 products the biased sum
/// stays below 2²³ + 2²⁴ < 2²⁵.
pub const MAX_BIAS: i32 = 1 << 24;
/// Layers with wide outputs shift the sum left by this before it is requantised, so
/// that their factor may be up to 8. 2²⁵·2⁴ = 2²⁹ fits.
pub const WIDE_SHIFT: u32 = 4;

/// `rows × columns` int8 weights packed in row pairs, with a bias and a multiplier
/// a row.
#[derive(Clone, Copy, Debug, Default)]
pub struct Layer<'a> {
    rows: usize,
    columns: usize,
    weights: &'a [u8],
    /// `rows` biases, then `rows` multipliers, each a little-endian i32.
    biases: &'a [u8],
    multipliers: &'a [u8],
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
        let (biases, rest) = tables.split_at_checked(4 * rows).ok_or(LayerError::Short)?;
        let (multipliers, rest) = rest.split_at_checked(4 * rows).ok_or(LayerError::Short)?;
        *tables = rest;
        let sound = words(biases).all(|b| (-MAX_BIAS..=MAX_BIAS).contains(&b)) && words(multipliers).all(|m| m >= 0);
        if !sound {
            return Err(LayerError::OutOfRange);
        }
        Ok(Self { rows, columns, weights: own, biases, multipliers })
    }

    /// `out[r] = clamp(round(m_r·(Σ_c w[r][c]·x[c] + b_r) / 2³²), low, high)` for every
    /// row; `x` holds at least the layer's columns, padded with a zero to an even
    /// number, `out` at least its rows.
    pub(crate) fn apply(&self, x: &[i16], out: &mut [i16], low: i32, high: i32) {
        self.run(x, out, 0, low, high);
    }

    /// As [`Self::apply`], with the sum shifted left by [`WIDE_SHIFT`] first and the whole
    /// i16 range as output.
    pub(crate) fn apply_wide(&self, x: &[i16], out: &mut [i16]) {
        self.run(x, out, WIDE_SHIFT, i32::from(i16::MIN), i32::from(i16::MAX));
    }

    fn run(&self, x: &[i16], out: &mut [i16], shift: u32, low: i32, high: i32) {
        let mut sums = [0i32; MAX_ROWS];
        let (Some(sums), Some(x)) = (sums.get_mut(..even(self.rows)), x.get(..even(self.columns))) else {
            return; // Loading bounds rows and columns, and callers size their buffers by the maxima.
        };
        dense(self.weights, x, sums);
        let rows = sums.iter().zip(words(self.biases)).zip(words(self.multipliers));
        for (out, ((&sum, bias), m)) in out.iter_mut().zip(rows) {
            *out = requantise((sum + bias) << shift, m).clamp(low, high) as i16;
        }
    }
}

fn words(bytes: &[u8]) -> impl Iterator<Item = i32> + '_ {
    bytes.chunks_exact(4).map(|c| match c {
        &[a, b, c, d] => i32::from_le_bytes([a, b, c, d]),
        _ => 0,
    })
}
