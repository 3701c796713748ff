//! Sums over rows in whole vectors of the kernel.

use crate::kernel::LANES;

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
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
