//! The origin of a mission, and from degrees to the map and back.
//!
//! The swarm agrees on one origin, the map's south-west corner. The conversion around it is
//! [`firmware_core::navigation`]'s, the same as on a microcontroller.

pub use firmware_core::navigation::{LocalPosition as Place, MapScale as Scale, REACH_MM, degrees_to_e7 as to_e7};

use firmware_core::navigation::{LATITUDE_LIMIT_E7, LocalFrame};
use thiserror::Error;

const UNITS_PER_DEG: f64 = 1e7;
/// Greatest latitude of an origin, north and south, degrees.
const LATITUDE_LIMIT_DEG: f64 = LATITUDE_LIMIT_E7 as f64 / UNITS_PER_DEG;

/// An origin around which no map is laid.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OriginError {
    /// Not a latitude, or too near to a pole.
    #[error("latitude {0}; use one between -80 and 80 degrees")]
    Latitude(f64),
    /// Not a longitude.
    #[error("longitude {0}; use one between -180 and 180 degrees")]
    Longitude(f64),
    /// Not an altitude.
    #[error("altitude {0} m; use one between -500 and 9000 m above mean sea level")]
    Altitude(f64),
}

/// The tangent plane of a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Latitude of the origin, 1e-7 degrees.
    pub lat_e7: i32,
    /// Longitude of the origin, 1e-7 degrees.
    pub lon_e7: i32,
    /// Altitude of the origin above mean sea level, mm.
    pub alt_mm: i32,
    frame: LocalFrame,
}

impl Plane {
    /// The plane at an origin in degrees and metres above mean sea level.
    ///
    /// # Errors
    /// See [`OriginError`].
    pub fn new(lat: f64, lon: f64, alt_m: f64) -> Result<Self, OriginError> {
        if !(-LATITUDE_LIMIT_DEG..=LATITUDE_LIMIT_DEG).contains(&lat) {
            return Err(OriginError::Latitude(lat));
        }
        if !(-180.0..=180.0).contains(&lon) {
            return Err(OriginError::Longitude(lon));
        }
        if !(-500.0..=9000.0).contains(&alt_m) {
            return Err(OriginError::Altitude(alt_m));
        }
        let (lat_e7, lon_e7) = (to_e7(lat), to_e7(lon));
        let frame = LocalFrame::new(lat_e7, lon_e7).ok_or(OriginError::Latitude(lat))?;
        // At most 9,000,000.
        Ok(Self { lat_e7, lon_e7, alt_mm: (alt_m * 1000.0).round() as i32, frame })
    }

    /// Where a latitude and longitude (1e-7 degrees) lie; `None` beyond [`REACH_MM`]. On either side of the date line
    /// the plane goes on.
    #[must_use]
    pub fn place(&self, lat_e7: i32, lon_e7: i32) -> Option<Place> {
        self.frame.local(lat_e7, lon_e7)
    }

    /// Latitude and longitude of a place, 1e-7 degrees, rounded to the nearest.
    #[must_use]
    pub fn degrees_e7(&self, place: Place) -> (i32, i32) {
        self.frame.geodetic_e7(place)
    }

    /// Distance along the globe from the origin to a latitude and longitude in degrees, km, for words.
    #[must_use]
    pub fn distance_km(&self, lat: f64, lon: f64) -> f64 {
        let (olat, olon) = self.origin_degrees();
        let [dlat, dlon] = [olat - lat, olon - lon].map(|d| (d.to_radians() / 2.0).sin().powi(2));
        let h = dlat + lat.to_radians().cos() * olat.to_radians().cos() * dlon;
        12_742.0 * h.sqrt().min(1.0).asin()
    }

    /// Latitude and longitude of the origin, degrees.
    #[must_use]
    pub fn origin_degrees(&self) -> (f64, f64) {
        (f64::from(self.lat_e7) / UNITS_PER_DEG, f64::from(self.lon_e7) / UNITS_PER_DEG)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use firmware_core::geometry::{TICKS_PER_U, Vec2};
    use proptest::prelude::*;

    /// Millimetres in 1e-7 degrees of latitude and of longitude: ArduPilot's
    /// `LOCATION_SCALING_FACTOR`, the globe's equatorial radius of 6,378,100 m.
    fn mm_per_unit(lat: f64) -> [f64; 2] {
        const MM: f64 = 11.131_884_502_145_034;
        [MM, MM * lat.to_radians().cos()]
    }

    /// A longitude as it is written on the other side of the date line.
    fn within_a_turn(lon_e7: i32) -> i32 {
        let turns = (f64::from(lon_e7) / 3.6e9).round() as i64;
        (i64::from(lon_e7) - turns * 3_600_000_000) as i32
    }

    const SCALE: Scale = Scale { unit_m: 2.5, step_ms: 2000 };

    proptest! {
        #[test]
        fn degrees_come_back_to_the_unit(
            lat in -80.0f64..80.0, lon in -180.0f64..180.0, north in -2_000_000i32..2_000_000, east in -2_000_000i32..2_000_000,
        ) {
            let plane = Plane::new(lat, lon, 0.0).unwrap();
            // Two million units of latitude are 22 km; stay inside the reach.
            let (north, east) = (north / 2, east / 2);
            // Longitudes begin anew at the date line.
            let lon_e7 = within_a_turn(plane.lon_e7 + east);
            let place = plane.place(plane.lat_e7 + north, lon_e7).unwrap();
            prop_assert_eq!(plane.degrees_e7(place), (plane.lat_e7 + north, lon_e7));
        }

        #[test]
        fn the_map_is_that_of_ardupilots_metres_per_degree(
            lat in -80.0f64..80.0, lon in -179.0f64..179.0, north in -1_000_000i32..1_000_000, east in -1_000_000i32..1_000_000,
        ) {
            let plane = Plane::new(lat, lon, 0.0).unwrap();
            let [per_lat, per_lon] = mm_per_unit(f64::from(plane.lat_e7) / UNITS_PER_DEG);
            let place = plane.place(plane.lat_e7 + north, plane.lon_e7 + east).unwrap();
            let (north_mm, east_mm) = (f64::from(north) * per_lat, f64::from(east) * per_lon);
            prop_assert_eq!(place.north_mm, north_mm);
            // The cosines of libm and of this computer may differ by one unit in the last place, and two products
            // are rounded after it.
            prop_assert!((place.east_mm - east_mm).abs() <= 4.0 * f64::EPSILON * east_mm.abs());
            prop_assert_eq!(SCALE.position(place), SCALE.position(Place { east_mm, north_mm }));
        }

        #[test]
        fn a_place_comes_back_within_a_grain(
            lat in -80.0f64..80.0, lon in -180.0f64..180.0, east_mm in -1e6f64..1e6, north_mm in -1e6f64..1e6,
        ) {
            let plane = Plane::new(lat, lon, 100.0).unwrap();
            let (a, b) = plane.degrees_e7(Place { east_mm, north_mm });
            let back = plane.place(a, b).unwrap();
            // A grain is 1e-7 degrees, 11.2 mm at most; half of it is the most that rounding takes.
            prop_assert!((back.east_mm - east_mm).abs() < 5.7 && (back.north_mm - north_mm).abs() < 5.7);
        }

        #[test]
        fn ticks_survive_the_autopilots_metres(x in -300_000i32..300_000, y in -300_000i32..300_000, vx in -8192i32..8192) {
            // LOCAL_POSITION_NED speaks in f32 metres.
            let place = SCALE.place(Vec2 { x, y });
            let metres = [place.east_mm, place.north_mm].map(|mm| f64::from((mm / 1000.0) as f32));
            prop_assert_eq!(metres.map(|m| SCALE.ticks(m)), [x, y]);
            let mps = f64::from(SCALE.mps(vx as f32 / TICKS_PER_U as f32) as f32);
            prop_assert_eq!(SCALE.velocity(mps, -mps), Vec2 { x: vx, y: -vx });
        }
    }

    #[test]
    fn the_date_line_is_no_edge() {
        let plane = Plane::new(-16.8, 179.998, 0.0).unwrap();
        let place = plane.place(to_e7(-16.8), to_e7(-179.999)).unwrap();
        // 0.003 degrees of longitude at 16.8 degrees south.
        assert!((place.east_mm / 1000.0 - 319.7).abs() < 0.1 && place.north_mm == 0.0, "{place:?}");
        assert_eq!(plane.degrees_e7(place), (to_e7(-16.8), to_e7(-179.999)));
        let west = Plane::new(0.0, -179.9995, 0.0).unwrap().place(0, to_e7(179.9995)).unwrap();
        assert!((west.east_mm / 1000.0 + 111.3).abs() < 0.1, "{west:?}");
    }

    #[test]
    fn far_places_and_bad_origins_are_refused() {
        let plane = Plane::new(47.0, 8.0, 400.0).unwrap();
        assert_eq!(plane.place(to_e7(47.3), to_e7(8.0)), None);
        assert_eq!(plane.place(i32::MIN, i32::MAX), None);
        let refused = |lat, lon, alt| Plane::new(lat, lon, alt).unwrap_err().to_string();
        assert!(refused(47.0, 361.0, 0.0).contains("between -180 and 180"));
        assert!(refused(f64::NAN, 8.0, 0.0).contains("NaN"));
        assert!(refused(85.0, 8.0, 0.0).contains("-80 and 80"));
        assert!(refused(47.0, 8.0, f64::INFINITY).contains("inf"));
    }
}
