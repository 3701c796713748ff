//! Headings: where a velocity or a setpoint points.

use core::f32::consts::TAU;
use micromath::F32Ext;

/// No heading is farther than this from the exact one, rad (0.17°): micromath's `atan2` is an
/// approximation, a few multiplications and one division.
pub const HEADING_ERROR_RAD: f32 = 0.002_9;

/// The heading of a vector east and north, in whatever unit: radians clockwise from north,
/// 0 to 2π (2π itself not included), within [`HEADING_ERROR_RAD`]. `None` for a vector without
/// length or with a part that is not finite: a vehicle that stands keeps the heading it has.
#[must_use]
pub fn heading_rad(east: f32, north: f32) -> Option<f32> {
    let largest = if east.abs() > north.abs() { east.abs() } else { north.abs() };
    if !(largest > 0.0 && east.is_finite() && north.is_finite()) {
        return None;
    }
    // As a share of the larger part, so that no square over- or underflows.
    // By name: where std is about, its method of this name would be taken.
    let angle = F32Ext::atan2(east / largest, north / largest);
    let turned = if angle < 0.0 { angle + TAU } else { angle };
    Some(if turned < TAU { turned } else { 0.0 })
}

/// [`heading_rad`] in hundredths of a degree, 0 to 35,999: MAVLink's `hdg`.
#[must_use]
pub fn heading_centidegrees(east: f32, north: f32) -> Option<u16> {
    let heading = heading_rad(east, north)?;
    // At most 36,000.
    let rounded = (heading * (36_000.0 / TAU) + 0.5) as u16;
    Some(if rounded < 36_000 { rounded } else { 0 })
}
