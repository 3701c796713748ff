//! Sums over rows in whole vectors of the kernel.

use crate::kernel::LANES;
use crate::math::exp;

/// `sum += scale · x`, in whole vectors.
#[inline(always)]
pub fn add_scaled(sum: &mut [f32], scale: f32, x: &[f32]) {
    for (sum, x) in sum.chunks_exact_mut(LANES).zip(x.chunks_exact(LANES)) {
        sum.iter_mut().zip(x).for_each(|(s, x)| *s = scale.mul_add(*x, *s));
    }
}

/// `a·b`, in whole vectors.
#[inline(always)]
pub fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0f32; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(s, (a, b))| *s = a.mul_add(*b, *s));
    }
    total(sums)
}

/// Sum over the lanes of a vector.
#[inline(always)]
pub fn total([a, b, c, d, e, f, g, h]: [f32; LANES]) -> f32 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Scores to their softmax.
#[inline(always)]
pub fn softmax(scores: &mut [f32]) {
    let max = scores.iter().fold(f32::NEG_INFINITY, |max, w| max.max(*w));
    let mut sum = 0.0;
    for w in scores.iter_mut() {
        *w = exp(*w - max);
        sum += *w;
    }
    scores.iter_mut().for_each(|w| *w /= sum);
}
