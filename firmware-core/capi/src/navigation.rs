//! From an autopilot's degrees and metres to ticks and back, and headings.

use crate::scene::CoveyVec2;
use crate::status::Status;
use firmware_core::geometry::Vec2;
use firmware_core::navigation::{LocalFrame, MapScale, heading_centidegrees, heading_rad};

/// `covey_map`
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveyMap {
    /// Latitude of the map's south-west corner, 1e-7 degrees.
    pub lat_e7: i32,
    /// Longitude of it, 1e-7 degrees.
    pub lon_e7: i32,
    /// Metres in a map unit.
    pub unit_m: f64,
    /// Milliseconds in a step.
    pub step_ms: u16,
}

impl CoveyMap {
    fn parts(&self) -> Option<(LocalFrame, MapScale)> {
        let sound = self.unit_m.is_finite() && self.unit_m > 0.0 && self.step_ms > 0;
        let scale = MapScale { unit_m: self.unit_m, step_ms: self.step_ms };
        LocalFrame::new(self.lat_e7, self.lon_e7).filter(|_| sound).map(|frame| (frame, scale))
    }
}

/// The position of a latitude and longitude on the map.
///
/// # Safety
/// `map` and `position` are NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_map_position(
    map: *const CoveyMap,
    lat_e7: i32,
    lon_e7: i32,
    position: *mut CoveyVec2,
) -> i32 {
    // SAFETY: NULL or valid by this function's contract.
    let (map, position) = unsafe { (map.as_ref(), position.as_mut()) };
    let (Some(map), Some(position)) = (map, position) else { return Status::Null as i32 };
    let Some((frame, scale)) = map.parts() else { return Status::Argument as i32 };
    let Some(place) = frame.local(lat_e7, lon_e7) else { return Status::Argument as i32 };
    let Vec2 { x, y } = scale.position(place);
    *position = CoveyVec2 { x, y };
    Status::Ok as i32
}

/// Latitude and longitude of a position on the map.
///
/// # Safety
/// `map`, `lat_e7` and `lon_e7` are NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_map_degrees(
    map: *const CoveyMap,
    position: CoveyVec2,
    lat_e7: *mut i32,
    lon_e7: *mut i32,
) -> i32 {
    // SAFETY: NULL or valid by this function's contract.
    let (map, lat, lon) = unsafe { (map.as_ref(), lat_e7.as_mut(), lon_e7.as_mut()) };
    let (Some(map), Some(lat), Some(lon)) = (map, lat, lon) else { return Status::Null as i32 };
    let Some((frame, scale)) = map.parts() else { return Status::Argument as i32 };
    (*lat, *lon) = frame.geodetic_e7(scale.place(position.into()));
    Status::Ok as i32
}

/// A velocity in m/s as ticks per step.
///
/// # Safety
/// `map` and `velocity` are NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covey_map_velocity(
    map: *const CoveyMap,
    east_mps: f32,
    north_mps: f32,
    velocity: *mut CoveyVec2,
) -> i32 {
    // SAFETY: NULL or valid by this function's contract.
    let (map, velocity) = unsafe { (map.as_ref(), velocity.as_mut()) };
    let (Some(map), Some(velocity)) = (map, velocity) else { return Status::Null as i32 };
    let Some((_, scale)) = map.parts() else { return Status::Argument as i32 };
    if !(east_mps.is_finite() && north_mps.is_finite()) {
        return Status::Argument as i32;
    }
    let Vec2 { x, y } = scale.velocity(east_mps.into(), north_mps.into());
    *velocity = CoveyVec2 { x, y };
    Status::Ok as i32
}

/// Heading of a vector in radians, −1 when it has none.
#[unsafe(no_mangle)]
pub extern "C" fn covey_heading_rad(east: f32, north: f32) -> f32 {
    heading_rad(east, north).unwrap_or(-1.0)
}

/// Heading of a vector in hundredths of a degree, −1 when it has none.
#[unsafe(no_mangle)]
pub extern "C" fn covey_heading_cdeg(east: f32, north: f32) -> i32 {
    heading_centidegrees(east, north).map_or(-1, i32::from)
}
