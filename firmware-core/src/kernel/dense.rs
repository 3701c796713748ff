//! A layer's numbers, as they lie in memory.

/// The most columns a layer may have; see the overflow bounds of this module.
pub const MAX_COLUMNS: usize = 511;

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

/// Packs two rows' weights of one column.
#[must_use]
pub const fn pack(a: i8, b: i8) -> [u8; 2] {
    [b as u8 ^ 0x80, a as u8]
}
