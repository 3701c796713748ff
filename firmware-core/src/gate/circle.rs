//! A circular geofence.

use super::boundary::Boundary;
use super::geofence_error::GeofenceError;
use super::vector::{POSITION_LIMIT_MM, Unit, Vector, difference};

/// A circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Circle {
    /// Centre, mm.
    pub centre: Vector,
    /// Radius, mm.
    pub radius_mm: u32,
}

impl Circle {
    pub(super) fn check(self) -> Result<(), GeofenceError> {
        if self.radius_mm < 1000 {
            return Err(GeofenceError::TooSmall);
        }
        let reach = i64::from(self.centre.east.unsigned_abs().max(self.centre.north.unsigned_abs()));
        if reach + i64::from(self.radius_mm) > i64::from(POSITION_LIMIT_MM) {
            Err(GeofenceError::TooFar)
        } else {
            Ok(())
        }
    }

    /// The nearest piece of the circle from `place`, and whether that is inside.
    pub(super) fn boundary(self, place: Vector) -> (Boundary, bool) {
        let radius = i64::from(self.radius_mm);
        let (east, north) = difference(place, self.centre);
        // In the very centre every direction is as good.
        let (outward, from_centre) = Unit::new(east, north).unwrap_or((Unit::EAST, 0));
        let inside = from_centre <= radius;
        let toward = if inside { outward } else { outward.reversed() };
        (Boundary { toward, distance_mm: (radius - from_centre).abs() }, inside)
    }
}
