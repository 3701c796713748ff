//! Distances from multiplications, sums and square roots alone, which every target
//! computes to the same bit (`hypot` and `powi` promise no such thing).

/// Squared distance.
pub(crate) fn squared(a: (f32, f32), b: (f32, f32)) -> f32 {
    let (dx, dy) = (a.0 - b.0, a.1 - b.1);
    dx * dx + dy * dy
}

/// Distance.
pub(crate) fn distance(a: (f32, f32), b: (f32, f32)) -> f32 {
    squared(a, b).sqrt()
}
