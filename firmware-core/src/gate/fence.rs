//! The fence: a polygon, a circle, or both, and how fast a UAV may go toward it.

use super::vector::{POSITION_LIMIT_MM, Unit, Vector};
use heapless::Vec;

/// Most corners of a fence.
pub const MAX_CORNERS: usize = 16;
/// Most walls: the edges and the circle.
pub(super) const MAX_WALLS: usize = MAX_CORNERS + 1;
/// Least half-angle of a corner, as its sine in 32,768ths: corners of 30° and more.
const LEAST_HALF_ANGLE: u32 = 8400;

/// The area that a UAV stays in. At least one of polygon and circle; with both, what is inside both.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fence {
    /// Counter-clockwise; empty without a polygon.
    corners: Vec<Vector, MAX_CORNERS>,
    circle: Option<Circle>,
    /// Sine of half the sharpest corner, in 32,768ths; 32,768 without corners.
    half_angle: u32,
}

/// A circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Circle {
    /// Centre, mm.
    pub centre: Vector,
    /// Radius, mm.
    pub radius_mm: u32,
}

/// A fence that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FenceError {
    /// Not 3 to [`MAX_CORNERS`] corners.
    #[error("a fence has 3 to {MAX_CORNERS} corners, not {0}")]
    Corners(usize),
    /// A corner, or a part of the circle, is too far away.
    #[error("the fence reaches beyond 100 km from the origin")]
    TooFar,
    /// A corner lies on the next one.
    #[error("corners {0} and the next one are the same point")]
    SamePoint(usize),
    /// Edges touch or cross.
    #[error("the edges after corners {0} and {1} touch or cross")]
    Crossing(usize, usize),
    /// A corner is sharper than 30°.
    #[error("corner {0} is sharper than 30°")]
    TooSharp(usize),
    /// The circle is smaller than 1 m.
    #[error("the circle's radius is below 1 m")]
    TooSmall,
}

impl Fence {
    /// A polygon, convex or not, its corners in either direction (mm).
    ///
    /// # Errors
    /// It has too few or too many corners, one is too far away or too sharp, or its edges touch or cross.
    pub fn polygon(corners: &[Vector]) -> Result<Self, FenceError> {
        if corners.len() < 3 {
            return Err(FenceError::Corners(corners.len()));
        }
        let mut corners: Vec<Vector, MAX_CORNERS> =
            Vec::from_slice(corners).map_err(|_| FenceError::Corners(corners.len()))?;
        if corners.iter().any(|c| c.clamped(POSITION_LIMIT_MM) != *c) {
            return Err(FenceError::TooFar);
        }
        refuse_crossings(&corners)?;
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
    pub fn rectangle(a: Vector, b: Vector) -> Result<Self, FenceError> {
        Self::polygon(&[a, Vector::new(b.east, a.north), b, Vector::new(a.east, b.north)])
    }

    /// A circle.
    ///
    /// # Errors
    /// It is smaller than 1 m or reaches too far.
    pub fn circle(circle: Circle) -> Result<Self, FenceError> {
        circle.check()?;
        Ok(Self { corners: Vec::new(), circle: Some(circle), half_angle: 1 << 15 })
    }

    /// This fence and a circle besides.
    ///
    /// # Errors
    /// The circle is smaller than 1 m or reaches too far.
    pub fn and_circle(mut self, circle: Circle) -> Result<Self, FenceError> {
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
        let distance = view.nearest.map_or(0, |wall| wall.distance_mm);
        // Coordinates are within 10^8 mm, so distances are below 2^29.
        (if view.inside { distance } else { -distance }) as i32
    }

    /// The fence as seen from a place (clamped to ±[`POSITION_LIMIT_MM`]).
    pub(super) fn view(&self, place: Vector) -> View {
        let place = place.clamped(POSITION_LIMIT_MM);
        let mut view = View { inside: true, walls: Vec::new(), nearest: None };
        if !self.corners.is_empty() {
            let mut inside = false;
            for (a, b) in edges(&self.corners) {
                inside ^= crosses_ray(place, a, b);
                view.add(Wall::edge(place, a, b));
            }
            // On the fence itself is inside.
            view.inside = inside || view.nearest.is_some_and(|wall| wall.distance_mm == 0);
        }
        if let Some(circle) = self.circle {
            let (wall, inside) = circle.wall(place);
            if view.inside && !inside {
                // Outside the circle alone: the way back is to it.
                (view.inside, view.nearest) = (false, None);
            }
            if inside == view.inside {
                view.add(Some(wall));
            }
        }
        view
    }
}

impl Circle {
    fn check(self) -> Result<(), FenceError> {
        if self.radius_mm < 1000 {
            return Err(FenceError::TooSmall);
        }
        let reach = i64::from(self.centre.east.unsigned_abs().max(self.centre.north.unsigned_abs()));
        if reach + i64::from(self.radius_mm) > i64::from(POSITION_LIMIT_MM) { Err(FenceError::TooFar) } else { Ok(()) }
    }

    /// The nearest piece of the circle from `place`, and whether that is inside.
    fn wall(self, place: Vector) -> (Wall, bool) {
        let radius = i64::from(self.radius_mm);
        let (east, north) = difference(place, self.centre);
        // In the very centre every direction is as good.
        let (outward, from_centre) = Unit::of(east, north).unwrap_or((Unit::EAST, 0));
        let inside = from_centre <= radius;
        let toward = if inside { outward } else { outward.reversed() };
        (Wall { toward, distance_mm: (radius - from_centre).abs() }, inside)
    }
}

/// A piece of the fence as seen from a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wall {
    /// Direction to its nearest point.
    pub toward: Unit,
    /// Distance of that point, mm, rounded down.
    pub distance_mm: i64,
}

impl Wall {
    /// The edge from `a` to `b`; nothing for a corner that is this very place (the edges' own directions serve
    /// there).
    fn edge(place: Vector, a: Vector, b: Vector) -> Option<Self> {
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
        let (outward, length) = Unit::of(ey, -ex)?;
        let cross = ex * py - ey * px;
        let distance_mm = cross.checked_abs()?.checked_div(length)?;
        Some(Self { toward: if cross >= 0 { outward } else { outward.reversed() }, distance_mm })
    }

    fn point(east: i64, north: i64) -> Option<Self> {
        Unit::of(east, north).map(|(toward, distance_mm)| Self { toward, distance_mm })
    }
}

/// The fence as seen from a place.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub inside: bool,
    pub walls: Vec<Wall, MAX_WALLS>,
    /// The nearest wall; outside, the one to go back through.
    pub nearest: Option<Wall>,
}

impl View {
    fn add(&mut self, wall: Option<Wall>) {
        let Some(wall) = wall else { return };
        if self.nearest.is_none_or(|nearest| wall.distance_mm < nearest.distance_mm) {
            self.nearest = Some(wall);
        }
        // There is room for every edge and the circle.
        let _ = self.walls.push(wall);
    }
}

/// The edges of a closed line.
fn edges(corners: &[Vector]) -> impl Iterator<Item = (Vector, Vector)> + Clone + '_ {
    let next = corners.iter().skip(1).chain(corners.first());
    corners.iter().zip(next).map(|(a, b)| (*a, *b))
}

/// `a - b`, without saturation.
fn difference(a: Vector, b: Vector) -> (i64, i64) {
    (i64::from(a.east) - i64::from(b.east), i64::from(a.north) - i64::from(b.north))
}

/// Whether the ray from `place` to the east crosses the edge.
fn crosses_ray(place: Vector, a: Vector, b: Vector) -> bool {
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
fn doubled_area(corners: &[Vector]) -> i64 {
    // Sixteen terms below 2^56.
    let cross =
        |(a, b): (Vector, Vector)| i64::from(a.east) * i64::from(b.north) - i64::from(a.north) * i64::from(b.east);
    edges(corners).map(cross).sum()
}

fn refuse_crossings(corners: &[Vector]) -> Result<(), FenceError> {
    for (i, (a, b)) in edges(corners).enumerate() {
        if a == b {
            return Err(FenceError::SamePoint(i));
        }
        for (j, (c, d)) in edges(corners).enumerate().skip(i + 1) {
            // Neighbouring edges share a corner; whether they fold back is a matter of its angle.
            let share = b == c || d == a;
            if !share && meet(a, b, c, d) {
                return Err(FenceError::Crossing(i, j));
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
fn sharpest(corners: &[Vector], clockwise: bool) -> Result<u32, FenceError> {
    let mut least = 1 << 15;
    let following = edges(corners).skip(1).chain(edges(corners).take(1));
    for (i, ((a, b), (_, c))) in edges(corners).zip(following).enumerate() {
        let ((ax, ay), (bx, by)) = (difference(b, a), difference(c, b));
        let (Some((incoming, _)), Some((outgoing, _))) = (Unit::of(ax, ay), Unit::of(bx, by)) else { continue };
        let reflex = if clockwise { turn(a, b, c) > 0 } else { turn(a, b, c) < 0 };
        let half = incoming.half_angle_sine(outgoing);
        // A reflex corner does not narrow, but a fold onto itself is no corner at all.
        if half < LEAST_HALF_ANGLE {
            return Err(FenceError::TooSharp(if i + 1 < corners.len() { i + 1 } else { 0 }));
        }
        if !reflex {
            least = least.min(half);
        }
    }
    Ok(least)
}
