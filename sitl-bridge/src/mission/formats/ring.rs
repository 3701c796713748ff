//! A round fence as corners.

use crate::mission::drawing::{Drawing, METRES_PER_DEGREE, Spot, turned_back};
use crate::mission::fault::{Fault, fault};
use crate::mission::outline::MOST_CORNERS;

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
        let lat = centre.lat + radius_m / METRES_PER_DEGREE * sin;
        let lon = centre.lon + radius_m / METRES_PER_DEGREE / centre.lat.to_radians().cos() * cos;
        Spot { at: format!("{at} corner {i}"), lat, lon: turned_back(lon), alt_m: None }
    };
    let corners = (0..MOST_CORNERS).map(corner).collect();
    drawing.notes.push(format!("{at}: the circle of {radius_m} m becomes a fence of {MOST_CORNERS} corners inside it"));
    drawing.set_fence(at, corners)
}
