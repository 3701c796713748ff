//! The geofence around a place: its boundaries, their directions and distances.

use super::geofence_error::MAX_CORNERS;
use super::vector::{Unit, Vector, difference};
use heapless::Vec;

/// Most boundaries of a geofence: the edges and the circle.
pub(super) const MAX_BOUNDARIES: usize = MAX_CORNERS + 1;

/// The part of an edge or circle that is nearest to a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Boundary {
    /// Direction to its nearest point.
    pub toward: Unit,
    /// Distance of that point, mm, rounded down.
    pub distance_mm: i64,
}

impl Boundary {
    /// The edge from `a` to `b`; nothing for a corner that is this very place (the edges' own directions serve
    /// there).
    pub(super) fn edge(place: Vector, a: Vector, b: Vector) -> Option<Self> {
        let (ex, ey) = difference(b, a);
        let (px, py) = difference(place, a);
        // All within 2·10^8: products below 2^56.
        let along = px * ex + py * ey;
        if along < 0 {
            return Self::point(-px, -py);
        }
        if along > ex * ex + ey * ey {
            let (qx, qy) = difference(b, place);
            return Self::point(qx, qy);
        }
        // Counter-clockwise, so the inside is on the left and the outside on the right.
        let (outward, length) = Unit::new(ey, -ex)?;
        let cross = ex * py - ey * px;
        let distance_mm = cross.checked_abs()?.checked_div(length)?;
        Some(Self { toward: if cross >= 0 { outward } else { outward.reversed() }, distance_mm })
    }

    fn point(east: i64, north: i64) -> Option<Self> {
        Unit::new(east, north).map(|(toward, distance_mm)| Self { toward, distance_mm })
    }
}

/// The geofence around a place.
#[derive(Clone, Debug)]
pub(super) struct GeofenceView {
    pub inside: bool,
    pub boundaries: Vec<Boundary, MAX_BOUNDARIES>,
    /// The nearest boundary; outside, the one to go back through.
    pub nearest: Option<Boundary>,
}

impl GeofenceView {
    pub(super) fn add(&mut self, boundary: Option<Boundary>) {
        let Some(boundary) = boundary else { return };
        if self.nearest.is_none_or(|nearest| boundary.distance_mm < nearest.distance_mm) {
            self.nearest = Some(boundary);
        }
        // There is room for every edge and the circle.
        let _ = self.boundaries.push(boundary);
    }
}
