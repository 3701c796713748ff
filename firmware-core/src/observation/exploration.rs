//! Exploration: the value of candidate places beyond the view.
//!
//! Sixteen places 16 u away, all round, are valued by the PoIs to be expected there: fewer
//! towards the edge of the map, more where PoIs in view lie that way. A place that a neighbour
//! sees is worth less, or nothing when that neighbour has priority.

use super::poi::VisiblePoi;
use super::scene::Scene;
use crate::geometry::{TICKS_PER_U, Vec2};

/// Directions in which places are valued.
pub(super) const DIRECTIONS: usize = 16;
/// How far away the places are, u: a flight of four steps.
const FAR_U: i32 = 16;
/// PoIs in view are counted around a point this far along the direction, u.
const HINT_U: i32 = 10;
/// PoIs within this distance of that point count, in 1/4 u: 9 u.
const HINT_RANGE: i16 = 4 * 9;
/// A neighbour within this distance of a place sees it, in 1/2 u: 15 u.
const SEEN_RANGE: i16 = 2 * 15;
/// Distance from the edge of the map from which on PoIs are as likely as anywhere, u.
const EDGE_U: i32 = 32;

/// PoIs to be expected at a place far from the edge, in 1/64.
const EXPECTED: i16 = 170;
/// What a PoI in view that lies that way adds, in 1/64.
const HINTED: i16 = 40;
/// What all of them add at most, in 1/64.
const HINTED_MOST: i16 = 195;
/// Steps of the horizon that are left after the flight, in 16ths.
const LEFT: i16 = 4 * 16;
/// What a neighbour that yields leaves of them, in 16ths.
const LEFT_BY_YIELDING: i16 = 41;

/// One number for each direction.
type PerDirection = [i16; DIRECTIONS];

/// Unit vectors of the directions in 1/1024, from east counter-clockwise.
pub(super) static UNIT_VECTORS: [(i32, i32); DIRECTIONS] = [
    (1024, 0),
    (946, 392),
    (724, 724),
    (392, 946),
    (0, 1024),
    (-392, 946),
    (-724, 724),
    (-946, 392),
    (-1024, 0),
    (-946, -392),
    (-724, -724),
    (-392, -946),
    (0, -1024),
    (392, -946),
    (724, -724),
    (946, -392),
];

/// Points at one distance all round.
struct Points {
    x: PerDirection,
    y: PerDirection,
}

impl Points {
    /// `reach` away, in whatever unit.
    const fn new(reach: i32) -> Self {
        let (mut points, mut k) = (Self { x: [0; DIRECTIONS], y: [0; DIRECTIONS] }, 0);
        while k < DIRECTIONS {
            (points.x[k], points.y[k]) =
                ((UNIT_VECTORS[k].0 * reach / 1024) as i16, (UNIT_VECTORS[k].1 * reach / 1024) as i16);
            k += 1;
        }
        points
    }

    /// Calls `near` with what belongs to the points within `range` of a place, in the same unit;
    /// squares of distances must fit 16 bits.
    fn near(&self, (x, y): (i16, i16), range: i16, values: &mut PerDirection, near: impl Fn(i16) -> i16) {
        for ((value, px), py) in values.iter_mut().zip(&self.x).zip(&self.y) {
            let (dx, dy) = (x - px, y - py);
            *value = if dx * dx + dy * dy <= range * range { near(*value) } else { *value };
        }
    }
}

/// The places in 1/2 u, and the points around which PoIs in view are counted in 1/4 u.
static PLACES: Points = Points::new(2 * FAR_U);
static HINTS: Points = Points::new(4 * HINT_U);

/// The offset of the place along one of [`UNIT_VECTORS`], ticks.
pub(super) const fn place_offset((ux, uy): (i32, i32)) -> Vec2 {
    Vec2 { x: ux * FAR_U, y: uy * FAR_U }
}

/// Values of the places, 64ths of a PoI-step.
pub(super) fn exploration_values(scene: &Scene<'_>, half_side: i32, pois: &[VisiblePoi]) -> PerDirection {
    let position = scene.own.position;
    let mut hints = [0; DIRECTIONS];
    for poi in pois {
        let at = poi.offset();
        HINTS.near(((at.x >> 8) as i16, (at.y >> 8) as i16), HINT_RANGE, &mut hints, |n| n + 1);
    }
    let mut left = [LEFT; DIRECTIONS];
    for n in scene.neighbours.as_slice() {
        let most = if scene.has_priority_over(n) { LEFT_BY_YIELDING } else { 0 };
        PLACES.near(((n.offset.x >> 9) as i16, (n.offset.y >> 9) as i16), SEEN_RANGE, &mut left, |l| l.min(most));
    }
    // 0 to 32: how likely PoIs are so far from the edge.
    let inside = |at: i32, way: i32| {
        let at = at.saturating_add(way * FAR_U);
        let from_edge = half_side.saturating_sub(at.saturating_sub(half_side).saturating_abs());
        (from_edge.clamp(0, EDGE_U * TICKS_PER_U) >> TICKS_PER_U.ilog2()) as i16
    };
    let mut values = [0; DIRECTIONS];
    for (((value, &(ux, uy)), hints), left) in values.iter_mut().zip(&UNIT_VECTORS).zip(hints).zip(left) {
        let likely = (inside(position.x, ux) * inside(position.y, uy)) >> 5;
        let hinted = if likely > 0 { (hints * HINTED).min(HINTED_MOST) } else { 0 };
        *value = ((((EXPECTED * likely) >> 5) + hinted) * left) >> 4;
    }
    values
}
