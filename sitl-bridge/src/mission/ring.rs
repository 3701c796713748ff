//! A round fence as corners.

use super::drawing::{Drawing, Spot};
use super::error::{Fault, fault};
use super::outline::MOST_CORNERS;

/// Metres in a degree of latitude, as [`super::Plane`] has them.
const METRES: f64 = 111_318.845;

/// Takes a circle as the fence: the polygon with the most corners that lies inside it.
pub(super) fn draw(drawing: &mut Drawing, at: &str, (lat, lon): (f64, f64), radius_m: f64) -> Result<(), Fault> {
    // A radius that is not a number is refused too.
    if !(1.0..=20_000.0).contains(&radius_m) {
        return Err(fault(at, format!("is a circle of {radius_m} m; a fence has a radius of 1 m to 20 km")));
    }
    let centre = drawing.spot(at, lat, lon, None)?;
    if centre.lat.abs() > 85.0 {
        return Err(fault(at, "is too near to the pole"));
    }
    let corner = |i: usize| {
        let (sin, cos) = (i as f64 / MOST_CORNERS as f64 * std::f64::consts::TAU).sin_cos();
        let lat = centre.lat + radius_m / METRES * sin;
        let lon = centre.lon + radius_m / METRES / centre.lat.to_radians().cos() * cos;
        Spot { at: format!("{at} corner {i}"), lat, lon: super::drawing::turned_back(lon), alt_m: None }
    };
    let corners = (0..MOST_CORNERS).map(corner).collect();
    drawing.notes.push(format!("{at}: the circle of {radius_m} m becomes a fence of {MOST_CORNERS} corners inside it"));
    drawing.set_fence(at, corners)
}
