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

mod apply;
mod dense;
mod finish;
pub mod portable;
#[cfg(smlad)]
mod smlad;

pub use dense::{Dense, MAX_COLUMNS, pack};
pub use finish::{Finish, WIDE_SHIFT, requantise};
