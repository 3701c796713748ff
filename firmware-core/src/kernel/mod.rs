//! Dense int8 layers, in integers from end to end.
//!
//! # Packed row pairs
//! Weights are read in place from the actor file. A layer of R rows and C columns is R/2 pairs, rows (0, 1) first; an
//! odd R has a last row of zeros, an odd C a last column of zeros. Pair (a, b) holds two bytes for each column c,
//! [`pack`]`(w_a[c], w_b[c])`. As a little-endian 16-bit integer they are
//!
//! ```text
//! v = 256·w_a + u      with u = w_b + 128 in 0..=255
//! ```
//!
//! Two sums over the columns give both rows:
//!
//! ```text
//! acc1 = Σ v·x         Σ w_a·x = (acc1 − acc2) / 256
//! acc2 = Σ u·x         Σ w_b·x = acc2 − 128·Σ x
//! ```
//!
//! So the flash holds one byte a weight, yet two columns of v fill a word as SMLAD wants them, and UXTB16 turns that
//! word into two columns of u: one unpacking instruction for four multiplications. Both sums begin at −128·Σ x, which
//! is what row b needs and what cancels in row a.
//!
//! # Overflow bounds
//! x and w are int8, −128 to 127, and C is at most [`MAX_COLUMNS`] = 511.
//! - Σ w_a·x lies within ±511·2¹⁴ < 2²³, so acc1 − acc2 = 256·Σ w_a·x lies within ±511·2²² < 2³¹: it is exact whenever
//!   it is computed modulo 2³², however often acc1 wraps on the way. (A column of zeros that pads C to 512 adds
//!   nothing: its x is zero.)
//! - u·x lies within ±255·2⁷ and 128·x within ±2¹⁴, so acc2 lies within ±511·(2¹⁵ + 2¹⁴) < 2²⁵ at all times.
//! - With a bias up to ±2²⁴ the sum stays within ±2²⁵, and shifted by [`WIDE_SHIFT`] within ±2²⁹.
//!
//! Larger values wrap, the same way on every target; nothing panics.

pub mod portable;
#[cfg(smlad)]
mod smlad;

#[cfg(not(smlad))]
use portable as fastest;
#[cfg(smlad)]
use smlad as fastest;

/// The most columns a layer may have; see the overflow bounds of this module.
pub const MAX_COLUMNS: usize = 511;

/// [`Finish::Wide`] shifts the sum left by this before it is requantised, so that its factor may be up to 8.
pub const WIDE_SHIFT: u32 = 4;

/// A layer of R rows and C columns, read in place.
///
/// Fastest on Cortex-M where `weights` begins at a multiple of four.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dense<'a> {
    /// int8 weights in packed row pairs: R and C rounded up to even, multiplied, in bytes.
    pub weights: &'a [u8],
    /// R biases, i32 little-endian, at most ±2²⁴.
    pub biases: &'a [[u8; 4]],
    /// R multipliers, i32 little-endian, not negative.
    pub multipliers: &'a [[u8; 4]],
}

/// How a row's biased sum `s` becomes an output, with the row's multiplier `m`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// `clamp(requantise(s, m), 0, 127)`: an int8 activation behind a rectifier.
    Rectified,
    /// `clamp(requantise(s·2⁴, m), −2¹⁵, 2¹⁵ − 1)`: a number in 16 bits.
    Wide,
}

impl Dense<'_> {
    /// `out[r] = finish(Σ_c w[r][c]·x[c] + bias[r])` for each row.
    ///
    /// `x` has C int8 values, with a zero behind them if C is odd; `out` has R places. Whoever loads a layer checks
    /// that its parts are of these lengths. Should they not be, the rows that some part lacks are not computed.
    ///
    /// On Cortex-M4 and M7 this is assembly, elsewhere [`portable::apply`]; both give the same numbers.
    #[inline]
    pub fn apply(&self, x: &[i16], out: &mut [i16], finish: Finish) {
        fastest::apply(self, x, out, finish);
    }
}

/// `round(acc·m / 2³²)`, halves up: one SMMULR on Cortex-M.
#[inline]
#[must_use]
pub const fn requantise(acc: i32, m: i32) -> i32 {
    // |acc·m| ≤ 2⁶², so the sum fits i64, and its upper half fits i32.
    ((acc as i64 * m as i64 + (1 << 31)) >> 32) as i32
}

/// Packs two rows' weights of one column.
#[must_use]
pub const fn pack(a: i8, b: i8) -> [u8; 2] {
    [b as u8 ^ 0x80, a as u8]
}
