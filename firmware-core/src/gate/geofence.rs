//! The geofence: a polygon, a circle, or both.

use super::boundary::{Boundary, GeofenceView};
use super::circle::Circle;
use super::geofence_error::{GeofenceError, MAX_CORNERS};
use super::polygon::{check_crossings, crosses_ray, doubled_area, edges, sharpest};
use super::vector::{POSITION_LIMIT_MM, Vector};
use heapless::Vec;

/// The area that a UAV stays in. At least one of polygon and circle; with both, what is inside both.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Geofence {
    /// Counter-clockwise; empty without a polygon.
    corners: Vec<Vector, MAX_CORNERS>,
    circle: Option<Circle>,
    /// Sine of half the sharpest corner, in 32,768ths; 32,768 without corners.
    half_angle: u32,
}

impl Geofence {
    /// A polygon, convex or not, its corners in either direction (mm).
    ///
    /// # Errors
    /// It has too few or too many corners, one is too far away or too sharp, or its edges touch or cross.
    pub fn polygon(corners: &[Vector]) -> Result<Self, GeofenceError> {
        if corners.len() < 3 {
            return Err(GeofenceError::Corners(corners.len()));
        }
        let mut corners: Vec<Vector, MAX_CORNERS> =
            Vec::from_slice(corners).map_err(|_| GeofenceError::Corners(corners.len()))?;
        if corners.iter().any(|c| c.clamped(POSITION_LIMIT_MM) != *c) {
            return Err(GeofenceError::TooFar);
        }
        check_crossings(&corners)?;
        let half_angle = if doubled_area(&corners) < 0 {
            // Counted as the caller counts them.
            let sharpest = sharpest(&corners, true)?;
            corners.reverse();
            sharpest
        } else {
            sharpest(&corners, false)?
        };
        Ok(Self { corners, circle: None, half_angle })
    }

    /// A rectangle between two opposite corners (mm).
    ///
    /// # Errors
    /// It is empty or reaches too far.
    pub fn rectangle(a: Vector, b: Vector) -> Result<Self, GeofenceError> {
        Self::polygon(&[a, Vector::new(b.east, a.north), b, Vector::new(a.east, b.north)])
    }

    /// A circle.
    ///
    /// # Errors
    /// It is smaller than 1 m or reaches too far.
    pub fn circle(circle: Circle) -> Result<Self, GeofenceError> {
        circle.check()?;
        Ok(Self { corners: Vec::new(), circle: Some(circle), half_angle: 1 << 15 })
    }

    /// This fence and a circle besides.
    ///
    /// # Errors
    /// The circle is smaller than 1 m or reaches too far.
    pub fn and_circle(mut self, circle: Circle) -> Result<Self, GeofenceError> {
        circle.check()?;
        self.circle = Some(circle);
        Ok(self)
    }

    /// Its corners, counter-clockwise.
    #[must_use]
    pub fn corners(&self) -> &[Vector] {
        &self.corners
    }

    /// Its circle.
    #[must_use]
    pub const fn outer_circle(&self) -> Option<Circle> {
        self.circle
    }

    /// Sine of half the sharpest corner, in 32,768ths.
    pub(super) const fn half_angle(&self) -> u32 {
        self.half_angle
    }

    /// Whether a place is inside, and how far it is from the fence, mm (negative outside).
    #[must_use]
    pub fn depth_mm(&self, place: Vector) -> i32 {
        let view = self.view(place);
        let distance = view.nearest.map_or(0, |boundary| boundary.distance_mm);
        // Coordinates are within 10^8 mm, so distances are below 2^29.
        (if view.inside { distance } else { -distance }) as i32
    }

    /// The geofence around a place (clamped to ±[`POSITION_LIMIT_MM`]).
    pub(super) fn view(&self, place: Vector) -> GeofenceView {
        let place = place.clamped(POSITION_LIMIT_MM);
        let mut view = GeofenceView { inside: true, boundaries: Vec::new(), nearest: None };
        if !self.corners.is_empty() {
            let mut inside = false;
            for (a, b) in edges(&self.corners) {
                inside ^= crosses_ray(place, a, b);
                view.add(Boundary::edge(place, a, b));
            }
            // On the fence itself is inside.
            view.inside = inside || view.nearest.is_some_and(|boundary| boundary.distance_mm == 0);
        }
        if let Some(circle) = self.circle {
            let (boundary, inside) = circle.boundary(place);
            if view.inside && !inside {
                // Outside the circle alone: the way back is to it.
                (view.inside, view.nearest) = (false, None);
            }
            if inside == view.inside {
                view.add(Some(boundary));
            }
        }
        view
    }
}
