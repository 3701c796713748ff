//! The median of repeated measurements.

/// The middle value, or the mean of the two in the middle; `v` must not be empty.
pub fn median(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    v[v.len() / 2].midpoint(v[(v.len() - 1) / 2])
}
