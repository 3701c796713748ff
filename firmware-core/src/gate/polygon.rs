//! The polygon of a geofence: what is a sound one, and what is inside.

use super::geofence_error::GeofenceError;
use super::vector::{Unit, Vector, difference};

/// Least half-angle of a corner, as its sine in 32,768ths: corners of 30° and more.
const LEAST_HALF_ANGLE: u32 = 8400;

/// The edges of a closed line.
pub(super) fn edges(corners: &[Vector]) -> impl Iterator<Item = (Vector, Vector)> + Clone + '_ {
    let next = corners.iter().skip(1).chain(corners.first());
    corners.iter().zip(next).map(|(a, b)| (*a, *b))
}

/// Whether the ray from `place` to the east crosses the edge.
pub(super) fn crosses_ray(place: Vector, a: Vector, b: Vector) -> bool {
    if (a.north > place.north) == (b.north > place.north) {
        return false;
    }
    let turn = turn(a, b, place);
    // Upward edges have the place on their left, downward ones on their right.
    if b.north > a.north { turn > 0 } else { turn < 0 }
}

/// Positive when `c` is on the left of the line from `a` to `b`, negative on its right.
fn turn(a: Vector, b: Vector, c: Vector) -> i64 {
    let ((ex, ey), (px, py)) = (difference(b, a), difference(c, a));
    ex * py - ey * px
}

/// Twice the area, positive when counter-clockwise.
pub(super) fn doubled_area(corners: &[Vector]) -> i64 {
    // Sixteen terms below 2^56.
    let cross =
        |(a, b): (Vector, Vector)| i64::from(a.east) * i64::from(b.north) - i64::from(a.north) * i64::from(b.east);
    edges(corners).map(cross).sum()
}

pub(super) fn check_crossings(corners: &[Vector]) -> Result<(), GeofenceError> {
    for (i, (a, b)) in edges(corners).enumerate() {
        if a == b {
            return Err(GeofenceError::SamePoint(i));
        }
        for (j, (c, d)) in edges(corners).enumerate().skip(i + 1) {
            // Neighbouring edges share a corner; whether they fold back is a matter of its angle.
            let share = b == c || d == a;
            if !share && meet(a, b, c, d) {
                return Err(GeofenceError::Crossing(i, j));
            }
        }
    }
    Ok(())
}

/// Whether two edges have a point in common.
fn meet(a: Vector, b: Vector, c: Vector, d: Vector) -> bool {
    let sides = |p, q, r, s| turn(p, q, r).signum() * turn(p, q, s).signum();
    let boxes_apart = a.east.max(b.east) < c.east.min(d.east)
        || c.east.max(d.east) < a.east.min(b.east)
        || a.north.max(b.north) < c.north.min(d.north)
        || c.north.max(d.north) < a.north.min(b.north);
    !boxes_apart && sides(a, b, c, d) <= 0 && sides(c, d, a, b) <= 0
}

/// Sine of half the sharpest corner that points outward, in 32,768ths.
pub(super) fn sharpest(corners: &[Vector], clockwise: bool) -> Result<u32, GeofenceError> {
    let mut least = 1 << 15;
    let following = edges(corners).skip(1).chain(edges(corners).take(1));
    for (i, ((a, b), (_, c))) in edges(corners).zip(following).enumerate() {
        let ((ax, ay), (bx, by)) = (difference(b, a), difference(c, b));
        let (Some((incoming, _)), Some((outgoing, _))) = (Unit::new(ax, ay), Unit::new(bx, by)) else { continue };
        let reflex = if clockwise { turn(a, b, c) > 0 } else { turn(a, b, c) < 0 };
        let half = incoming.half_angle_sine(outgoing);
        // A reflex corner does not narrow, but a fold onto itself is no corner at all.
        if half < LEAST_HALF_ANGLE {
            return Err(GeofenceError::TooSharp(if i + 1 < corners.len() { i + 1 } else { 0 }));
        }
        if !reflex {
            least = least.min(half);
        }
    }
    Ok(least)
}
