//! Integers in ticks to bytes in 1/127 of a scale.

use crate::geometry::div_round;

/// `round(127·a/SCALE)` clamped to ±127; SCALE is below 2²⁴.
pub(super) fn scaled<const SCALE: i32>(a: i32) -> i8 {
    let a = a.clamp(-SCALE, SCALE);
    div_round(a * 127, SCALE) as i8
}

/// [`scaled`] with a scale known at run time only, 1 to 2²³.
pub(super) fn scaled_by(a: i32, scale: i32) -> i8 {
    // |a·127| < 2^30.
    div_round(a.clamp(-scale, scale) * 127, scale) as i8
}
