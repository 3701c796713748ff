//! What a file draws on the earth: points and an outline in degrees, whatever its format.

use super::fault::{Fault, fault};

/// Greatest longitude, degrees either way: maps on the web count on when they are moved around the earth.
pub(super) const FARTHEST_LON: f64 = 180.0 + 3.0 * 360.0;

/// Metres in a degree of latitude, as [`super::Plane`] has them.
pub(super) const METRES_PER_DEGREE: f64 = 111_318.845;

/// In which order a format writes a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) enum Order {
    #[default]
    LatLon,
    LonLat,
}

/// A point in degrees, and the name of its place in the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spot {
    pub at: String,
    pub lat: f64,
    /// Within ±180°.
    pub lon: f64,
    /// Above mean sea level, m, where the file says one.
    pub alt_m: Option<f64>,
}

/// A closed line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outline {
    pub at: String,
    pub corners: Vec<Spot>,
}

/// What a file draws.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Drawing {
    pub order: Order,
    pub pois: Vec<Spot>,
    pub fence: Option<Outline>,
    /// Altitude of the home position above mean sea level, m.
    pub home_alt_m: Option<f64>,
    /// What was read otherwise than it stands there, or not at all.
    pub notes: Vec<String>,
    /// Longitudes that were beyond ±180°: the first, and how many.
    turned: Option<(String, usize)>,
}

impl Order {
    /// A position in this format's own order.
    pub(super) fn words(self, lat: f64, lon: f64) -> String {
        match self {
            Self::LatLon => format!("latitude {lat}, longitude {lon}"),
            Self::LonLat => format!("longitude {lon}, latitude {lat}"),
        }
    }

    /// The rule that a swapped position breaks.
    pub(super) const fn rule(self) -> &'static str {
        match self {
            Self::LatLon => "the latitude comes first here",
            Self::LonLat => "the longitude comes first here",
        }
    }
}

impl Drawing {
    pub(super) fn new(order: Order) -> Self {
        Self { order, ..Self::default() }
    }

    /// A checked position; longitudes that count on around the earth are taken back.
    pub(super) fn spot(&mut self, at: &str, lat: f64, lon: f64, alt_m: Option<f64>) -> Result<Spot, Fault> {
        let words = self.order.words(lat, lon);
        if !(lat.is_finite() && lon.is_finite()) {
            return Err(fault(at, format!("is at {words}: that is no number")));
        }
        if lat.abs() > 90.0 && lat.abs() <= 180.0 && lon.abs() <= 90.0 {
            let rule = self.order.rule();
            return Err(fault(at, format!("is at {words}: latitude and longitude are swapped; {rule}")));
        }
        if lat.abs() > 90.0 || lon.abs() > FARTHEST_LON {
            return Err(fault(
                at,
                format!(
                    "is at {words}, and those are no degrees; are they metres of a projection (EPSG:3857, UTM)? Export in \
                     EPSG:4326"
                ),
            ));
        }
        let mut within = lon;
        if lon.abs() > 180.0 {
            within = lon - 360.0 * (lon / 360.0).round();
            // Below 1e-7 degrees is no place of the file.
            within = (within * 1e9).round() / 1e9;
            let first = || (format!("{at}: {lon} is {within}"), 0);
            self.turned.get_or_insert_with(first).1 += 1;
        }
        Ok(Spot { at: at.to_owned(), lat, lon: within, alt_m })
    }

    /// Adds a PoI.
    pub(super) fn poi(&mut self, at: &str, lat: f64, lon: f64, alt_m: Option<f64>) -> Result<(), Fault> {
        let spot = self.spot(at, lat, lon, alt_m)?;
        self.pois.push(spot);
        Ok(())
    }

    /// Takes the fence; there is only one.
    pub(super) fn set_fence(&mut self, at: &str, corners: Vec<Spot>) -> Result<(), Fault> {
        if let Some(first) = &self.fence {
            return Err(fault(
                at,
                format!("is a second polygon besides {}; a mission has one fence: join them or remove one", first.at),
            ));
        }
        self.fence = Some(Outline { at: at.to_owned(), corners });
        Ok(())
    }

    /// A line, of which a mission makes nothing. One that is closed was meant as a fence.
    pub(super) fn line(&mut self, at: &str, kind: &str, ends: Option<bool>) -> Result<(), Fault> {
        if ends == Some(true) {
            return Err(fault(
                at,
                format!(
                    "is a {kind} that ends where it begins: if it is the fence, draw it as a Polygon; else remove it"
                ),
            ));
        }
        self.notes.push(format!("{at} is a {kind} and not used: PoIs are points, and the fence is a Polygon"));
        Ok(())
    }

    /// Notes that longitudes were taken back.
    pub(super) fn note_turns(&mut self) {
        if let Some((first, count)) = self.turned.take() {
            let more = if count > 1 { format!(" ({count} longitudes)") } else { String::new() };
            self.notes.push(format!("longitudes beyond ±180° were taken back by whole turns: {first}{more}"));
        }
    }

    /// The south-west corner of all that is drawn, and how far it reaches, degrees; `None` of nothing.
    pub(super) fn extent(&self) -> Option<Extent> {
        let first = self.fence.iter().flat_map(|f| &f.corners).chain(&self.pois).next()?;
        let all = || self.fence.iter().flat_map(|f| &f.corners).chain(&self.pois);
        // Seen from the first: across the date line it goes on.
        let east = |spot: &Spot| turned_back(spot.lon - first.lon);
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let (south, north) = (least(&mut all().map(|s| s.lat)), -least(&mut all().map(|s| -s.lat)));
        let (west, east) = (least(&mut all().map(east)), -least(&mut all().map(|s| -east(s))));
        Some(Extent { lat: south, lon: turned_back(first.lon + west), north: north - south, east: east - west })
    }
}

/// How far a drawing reaches, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// South-west corner.
    pub lat: f64,
    /// See `lat`.
    pub lon: f64,
    /// Width and height.
    pub north: f64,
    /// See `north`.
    pub east: f64,
}

/// A difference of longitudes within ±180°.
pub(super) fn turned_back(lon: f64) -> f64 {
    lon - 360.0 * (lon / 360.0).round()
}
