//! Layers in safe Rust: the reference on every target, and the one in use where no assembly is.
//!
//! Written so that compilers turn the inner loop into vector instructions (PMADDWD on x86-64, SMLAL on aarch64).

use super::dense::Dense;
use super::finish::{Finish, WIDE_SHIFT, requantise};

/// See [`Dense::apply`].
pub fn apply(layer: &Dense<'_>, x: &[i16], out: &mut [i16], finish: Finish) {
    if x.is_empty() {
        return;
    }
    let start = x.iter().fold(0i32, |sum, &x| sum.wrapping_add(x.into())).wrapping_mul(-128);
    let pairs = layer.weights.chunks_exact(2 * x.len());
    let rows = out.iter_mut().zip(layer.biases).zip(layer.multipliers);
    for (((out, bias), multiplier), sum) in rows.zip(pairs.flat_map(|pair| dot_pair(pair, x, start))) {
        let sum = sum.wrapping_add(i32::from_le_bytes(*bias));
        *out = finish.of(sum, i32::from_le_bytes(*multiplier));
    }
}

/// The dot products of both rows of `pair` with `x`; `start` is −128·Σx.
#[inline]
fn dot_pair(pair: &[u8], x: &[i16], start: i32) -> [i32; 2] {
    let (mut acc1, mut acc2) = (start, start);
    for (bytes, &x) in pair.as_chunks::<2>().0.iter().zip(x) {
        let v = i16::from_le_bytes(*bytes);
        acc1 = acc1.wrapping_add(i32::from(v) * i32::from(x));
        acc2 = acc2.wrapping_add(i32::from(v & 0xff) * i32::from(x));
    }
    [acc1.wrapping_sub(acc2) >> 8, acc2]
}

impl Finish {
    #[inline]
    fn of(self, sum: i32, multiplier: i32) -> i16 {
        match self {
            Self::Rectified => requantise(sum, multiplier).clamp(0, 127) as i16,
            Self::Wide => requantise(sum << WIDE_SHIFT, multiplier).clamp(i16::MIN.into(), i16::MAX.into()) as i16,
        }
    }
}
