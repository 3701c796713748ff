//! A local frame: metres east and north of a geodetic origin.

/// Positions farther than this from the origin on either axis are outside every frame, mm.
pub const REACH_MM: f64 = 20_000_000.0;
/// Greatest latitude of an origin, north and south, 1e-7 degrees: beyond it the earth is not
/// flat enough within the reach.
pub const LATITUDE_LIMIT_E7: i32 = 800_000_000;
/// Half-way around the earth, 1e-7 degrees: at this longitude, the date line, longitudes jump.
const HALF_TURN_E7: i64 = 1_800_000_000;
const E7_PER_DEGREE: f64 = 1e7;
/// Millimetres in 1e-7 degrees of latitude: ArduPilot's `LOCATION_SCALING_FACTOR`, of a globe
/// with the equatorial radius of 6,378,100 m.
const MM_PER_E7: f64 = 11.131_884_502_145_034;

/// Millimetres east and north of the origin of a [`LocalFrame`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalPosition {
    /// East, mm.
    pub east_mm: f64,
    /// North, mm.
    pub north_mm: f64,
}

/// The earth taken as flat around an origin, with ArduPilot's own metres per degree, so that
/// what an autopilot says in degrees fits what it says in metres. They are within 0.7 % of the
/// true ones; all UAVs of a swarm must take the same origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    lat_e7: i32,
    lon_e7: i32,
    mm_per_lat_e7: f64,
    mm_per_lon_e7: f64,
}

impl LocalFrame {
    /// The frame around an origin, 1e-7 degrees; `None` beyond 80° north or south, or for a
    /// longitude beyond ±180°. A frame near the date line reaches across it.
    #[must_use]
    pub fn new(lat_e7: i32, lon_e7: i32) -> Option<Self> {
        let fits = lat_e7.unsigned_abs() <= LATITUDE_LIMIT_E7.unsigned_abs() && i64::from(lon_e7).abs() <= HALF_TURN_E7;
        let lat = f64::from(lat_e7) / E7_PER_DEGREE;
        let mm_per_lon_e7 = MM_PER_E7 * libm::cos(lat.to_radians());
        fits.then_some(Self { lat_e7, lon_e7, mm_per_lat_e7: MM_PER_E7, mm_per_lon_e7 })
    }

    /// Latitude and longitude of the origin, 1e-7 degrees.
    #[must_use]
    pub const fn origin_e7(&self) -> (i32, i32) {
        (self.lat_e7, self.lon_e7)
    }

    /// Where a latitude and longitude (1e-7 degrees) lie; `None` beyond [`REACH_MM`].
    #[must_use]
    pub fn local(&self, lat_e7: i32, lon_e7: i32) -> Option<LocalPosition> {
        let units = |a: i32, b: i32| i64::from(a) - i64::from(b);
        let place = LocalPosition {
            east_mm: shorter_way_e7(units(lon_e7, self.lon_e7)) as f64 * self.mm_per_lon_e7,
            north_mm: units(lat_e7, self.lat_e7) as f64 * self.mm_per_lat_e7,
        };
        let near = |mm: f64| libm::fabs(mm) <= REACH_MM;
        (near(place.east_mm) && near(place.north_mm)).then_some(place)
    }

    /// Latitude and longitude of a local position, 1e-7 degrees, rounded to the nearest.
    /// Not-a-number becomes 0: callers refuse it first.
    #[must_use]
    pub fn geodetic_e7(&self, place: LocalPosition) -> (i32, i32) {
        let units = |mm: f64, per: f64, from: i32| f64::from(from) + libm::round(mm / per);
        let lat_e7 = units(place.north_mm, self.mm_per_lat_e7, self.lat_e7) as i32;
        // Within the reach of any frame the sum fits; farther away it saturates.
        let lon_e7 = units(place.east_mm, self.mm_per_lon_e7, self.lon_e7) as i32;
        (lat_e7, shorter_way_e7(i64::from(lon_e7)) as i32)
    }
}

/// A difference of longitudes of less than one and a half turns, 1e-7 degrees, the shorter way
/// around the earth.
const fn shorter_way_e7(units: i64) -> i64 {
    if units > HALF_TURN_E7 {
        units - 2 * HALF_TURN_E7
    } else if units < -HALF_TURN_E7 {
        units + 2 * HALF_TURN_E7
    } else {
        units
    }
}

/// Degrees to 1e-7 degrees, rounded to the nearest; for `degrees` within ±180.
#[must_use]
pub fn degrees_to_e7(degrees: f64) -> i32 {
    libm::round(degrees * E7_PER_DEGREE) as i32
}
