//! From a sum of products to an output: requantisation.

/// [`Finish::Wide`] shifts the sum left by this before it is requantised, so that its factor may be up to 8.
pub const WIDE_SHIFT: u32 = 4;

/// How a row's biased sum `s` becomes an output, with the row's multiplier `m`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// `clamp(requantise(s, m), 0, 127)`: an int8 activation behind a rectifier.
    Rectified,
    /// `clamp(requantise(s·2⁴, m), −2¹⁵, 2¹⁵ − 1)`: a number in 16 bits.
    Wide,
}

/// `round(acc·m / 2³²)`, halves up: one SMMULR on Cortex-M.
#[inline]
#[must_use]
pub const fn requantise(acc: i32, m: i32) -> i32 {
    // |acc·m| ≤ 2⁶², so the sum fits i64, and its upper half fits i32.
    ((acc as i64 * m as i64 + (1 << 31)) >> 32) as i32
}
