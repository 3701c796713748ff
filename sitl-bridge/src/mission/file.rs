//! Mission files: reading and checking.

use super::geojson;
use super::plane::{OriginError, Plane, Scale, to_e7};
use super::{DEFAULT_MARGIN_U, Layers, Mission, gate_fence, square_fence};
use covey_env::Scenario;
use firmware_core::actor::Mode;
use firmware_core::geometry::Vec2;
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, STEP_MS_LIMIT};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Steps shorter than this leave no time for two messages, ms.
const LEAST_STEP_MS: u16 = 200;
/// Longest side of a map, m: well inside the plane's reach.
const LONGEST_SIDE_M: f64 = 10_000.0;

/// Why a mission was refused.
#[derive(Debug, Error)]
pub enum MissionError {
    /// The file cannot be read.
    #[error("cannot read the mission {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// The file is no TOML or JSON, lacks a field, has one too many or one of another type.
    #[error("mission {}: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Where and what.
        message: String,
    },
    /// A value that cannot be flown.
    #[error("mission {}{}: {problem}", path.display(), line.map(|n| format!(", line {n}")).unwrap_or_default())]
    Value {
        /// The file.
        path: PathBuf,
        /// The line, where the form of the file tells it.
        line: Option<usize>,
        /// The field.
        field: String,
        /// What is wrong with it and what would be right.
        problem: String,
    },
}

/// A field and what is wrong with it.
pub(super) struct Fault {
    pub field: String,
    pub problem: String,
}

pub(super) fn fault(field: &str, problem: impl std::fmt::Display) -> Fault {
    Fault { field: field.to_owned(), problem: format!("{field} {problem}") }
}

/// A mission as it is written. `docs/mission.md` tells each field.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MissionFile {
    pub origin: Origin,
    #[serde(default = "two_and_a_half")]
    pub scale_m: f64,
    #[serde(default = "default_step_ms")]
    pub step_ms: u16,
    #[serde(default = "default_side_u")]
    pub side_u: f64,
    #[serde(default = "ten")]
    pub policy_seed: u64,
    #[serde(default)]
    pub decide: Decide,
    #[serde(default)]
    pub epoch_unix_ms: i64,
    #[serde(default)]
    pub pois_u: Vec<[f64; 2]>,
    #[serde(default)]
    pub pois_lat_lon: Vec<[f64; 2]>,
    #[serde(default)]
    pub altitude: AltitudeFile,
    #[serde(default)]
    pub fence: FenceFile,
}

const fn two_and_a_half() -> f64 {
    2.5
}
const fn default_step_ms() -> u16 {
    DEFAULT_STEP_MS
}
const fn default_side_u() -> f64 {
    firmware_core::geometry::MAP_SIDE_U as f64
}
const fn ten() -> u64 {
    10
}

/// The south-west corner of the map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Latitude, degrees.
    pub lat: f64,
    /// Longitude, degrees.
    pub lon: f64,
    /// Altitude above mean sea level, m.
    pub alt_m: f64,
}

impl Default for Origin {
    /// Where simulators of copters commonly start.
    fn default() -> Self {
        Self { lat: 47.397_742, lon: 8.545_594, alt_m: 488.0 }
    }
}

/// How actions are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Decide {
    #[default]
    Sample,
    Argmax,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct AltitudeFile {
    pub base_m: f64,
    pub spacing_m: f64,
    pub layers: u16,
}

impl Default for AltitudeFile {
    fn default() -> Self {
        Self { base_m: 20.0, spacing_m: 2.5, layers: 20 }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FenceFile {
    pub margin_u: Option<f64>,
    pub polygon_u: Option<Vec<[f64; 2]>>,
    pub polygon_lat_lon: Option<Vec<[f64; 2]>>,
}

impl Mission {
    /// Reads a mission file; `.geojson` and `.json` are GeoJSON, all others TOML.
    ///
    /// # Errors
    /// See [`MissionError`].
    pub fn read(path: &Path) -> Result<Self, MissionError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| MissionError::Read { path: path.to_owned(), source })?;
        let json =
            path.extension().is_some_and(|e| e.eq_ignore_ascii_case("geojson") || e.eq_ignore_ascii_case("json"));
        if json { Self::from_geojson(&text, path) } else { Self::from_toml(&text, path) }
    }

    /// A mission from TOML; `path` is for error messages.
    ///
    /// # Errors
    /// See [`MissionError`].
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, MissionError> {
        let syntax = |e: &toml::de::Error| MissionError::Syntax { path: path.to_owned(), message: e.to_string() };
        let file: MissionFile = toml::from_str(text).map_err(|e| syntax(&e))?;
        file.check().map_err(|Fault { field, problem }| {
            let line = line_of(text, &field);
            MissionError::Value { path: path.to_owned(), line, field, problem }
        })
    }

    /// A mission from GeoJSON; `path` is for error messages.
    ///
    /// # Errors
    /// See [`MissionError`].
    pub fn from_geojson(text: &str, path: &Path) -> Result<Self, MissionError> {
        let path = || path.to_owned();
        let collection: geojson::Collection =
            serde_json::from_str(text).map_err(|e| MissionError::Syntax { path: path(), message: e.to_string() })?;
        let checked = collection.into_file().and_then(|file| file.check());
        checked.map_err(|Fault { field, problem }| MissionError::Value { path: path(), line: None, field, problem })
    }
}

impl MissionFile {
    fn check(&self) -> Result<Mission, Fault> {
        let Origin { lat, lon, alt_m } = self.origin;
        let plane = Plane::new(lat, lon, alt_m).map_err(|e| match e {
            OriginError::Latitude(_) => fault("origin.lat", format!("is the {e}")),
            OriginError::Longitude(_) | OriginError::DateLine(_) => fault("origin.lon", format!("is the {e}")),
            OriginError::Altitude(_) => fault("origin.alt_m", format!("is the {e}")),
        })?;
        within("scale_m", self.scale_m, 0.1, 100.0)?;
        within("step_ms", self.step_ms, LEAST_STEP_MS, STEP_MS_LIMIT)?;
        within("side_u", self.side_u, f64::from(Scenario::MIN_SIDE_U), f64::from(Scenario::MAX_SIDE_U))?;
        let side_m = self.side_u * self.scale_m;
        if side_m > LONGEST_SIDE_M {
            let problem = format!("× scale_m makes a map of {side_m} m; use {LONGEST_SIDE_M} m at most");
            return Err(fault("side_u", problem));
        }
        let scale = Scale { unit_m: self.scale_m, step_ms: self.step_ms };
        let mission = Mission {
            plane,
            scale,
            side_u: self.side_u,
            fence: self.fence(&plane, scale)?,
            layers: self.layers()?,
            pois: self.pois(&plane, scale)?,
            policy_seed: self.policy_seed,
            mode: match self.decide {
                Decide::Sample => Mode::Sample,
                Decide::Argmax => Mode::Argmax,
            },
            epoch_unix_ms: self.epoch_unix_ms,
        };
        if mission.pois.is_empty() {
            return Err(fault("pois_u", "and pois_lat_lon are both empty; a mission has something to cover"));
        }
        Ok(mission)
    }

    fn layers(&self) -> Result<Layers, Fault> {
        let AltitudeFile { base_m, spacing_m, layers } = self.altitude;
        within("altitude.base_m", base_m, 2.0, 500.0)?;
        within("altitude.spacing_m", spacing_m, 0.0, 100.0)?;
        within("altitude.layers", layers, 1, 1000)?;
        let highest_m = base_m + f64::from(layers - 1) * spacing_m;
        if highest_m > 1000.0 {
            return Err(fault(
                "altitude.layers",
                format!("puts the highest layer at {highest_m} m; use 1000 m at most"),
            ));
        }
        Ok(Layers { base_m, spacing_m, count: layers })
    }

    fn pois(&self, plane: &Plane, scale: Scale) -> Result<Vec<Vec2>, Fault> {
        let mut pois = Vec::with_capacity(self.pois_u.len() + self.pois_lat_lon.len());
        let side = Mission::ticks_of_u(self.side_u, self.side_u).x;
        let on_map = |p: &Vec2| (0..=side).contains(&p.x) && (0..=side).contains(&p.y);
        for (i, &[x, y]) in self.pois_u.iter().enumerate() {
            // To ticks first: a point at the very edge is inside, whichever way it rounds.
            let p = Mission::ticks_of_u(x, y);
            if x.is_nan() || y.is_nan() || !on_map(&p) {
                let problem = format!("is at ({x}, {y}) u, outside the map of 0 to {} u", self.side_u);
                return Err(fault(&format!("pois_u[{i}]"), problem));
            }
            pois.push(p);
        }
        for (i, &[lat, lon]) in self.pois_lat_lon.iter().enumerate() {
            let field = format!("pois_lat_lon[{i}]");
            let p = on_plane(plane, scale, lat, lon).ok_or_else(|| far(&field, lat, lon))?;
            if !on_map(&p) {
                let (x, y) = p.to_u();
                let problem = format!(
                    "lies at ({x:.1}, {y:.1}) u, outside the map of 0 to {} u; is it latitude first?",
                    self.side_u
                );
                return Err(fault(&field, problem));
            }
            pois.push(p);
        }
        if pois.len() > Scenario::MAX_POIS {
            return Err(fault("pois_u", format!("has {} points; use {} at most", pois.len(), Scenario::MAX_POIS)));
        }
        Ok(pois)
    }

    fn fence(&self, plane: &Plane, scale: Scale) -> Result<Vec<Vec2>, Fault> {
        let FenceFile { margin_u, polygon_u, polygon_lat_lon } = &self.fence;
        let (field, corners) = match (margin_u, polygon_u, polygon_lat_lon) {
            (margin, None, None) => {
                let margin = margin.unwrap_or(DEFAULT_MARGIN_U);
                within("fence.margin_u", margin, 0.0, 1000.0)?;
                return Ok(square_fence(self.side_u, margin));
            }
            (None, Some(corners), None) => {
                for &[x, y] in corners {
                    if !(x.abs() <= 1e5 && y.abs() <= 1e5) {
                        return Err(fault("fence.polygon_u", format!("has the corner ({x}, {y}) u, far off the map")));
                    }
                }
                ("fence.polygon_u", corners.iter().map(|&[x, y]| Mission::ticks_of_u(x, y)).collect::<Vec<_>>())
            }
            (None, None, Some(corners)) => {
                let field = "fence.polygon_lat_lon";
                let corner =
                    |&[lat, lon]: &[f64; 2]| on_plane(plane, scale, lat, lon).ok_or_else(|| far(field, lat, lon));
                (field, corners.iter().map(corner).collect::<Result<Vec<_>, _>>()?)
            }
            _ => return Err(fault("fence", "has more than one form; give margin_u, polygon_u or polygon_lat_lon")),
        };
        checked_polygon(field, corners, scale)
    }
}

/// A polygon without a repeated last corner that the safety gate can use.
fn checked_polygon(field: &str, mut corners: Vec<Vec2>, scale: Scale) -> Result<Vec<Vec2>, Fault> {
    if corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    match gate_fence(&corners, scale) {
        Ok(_) => Ok(corners),
        Err(error) => Err(fault(field, format!("cannot be used: {error}"))),
    }
}

fn on_plane(plane: &Plane, scale: Scale, lat: f64, lon: f64) -> Option<Vec2> {
    let sound = (-90.0..=90.0).contains(&lat) && (-180.0..=180.0).contains(&lon);
    sound.then(|| plane.place(to_e7(lat), to_e7(lon))).flatten().map(|place| scale.position(place))
}

fn far(field: &str, lat: f64, lon: f64) -> Fault {
    fault(
        field,
        format!("is at latitude {lat}, longitude {lon}, more than 20 km from the origin; is it latitude first?"),
    )
}

fn within<T: PartialOrd + std::fmt::Display + Copy>(field: &str, value: T, low: T, high: T) -> Result<(), Fault> {
    if value >= low && value <= high { Ok(()) } else { Err(fault(field, format!("= {value}; use {low} to {high}"))) }
}

/// The line of a field like `altitude.base_m` or `pois_u[3]`, from 1.
fn line_of(text: &str, field: &str) -> Option<usize> {
    let document = toml::de::DeTable::parse(text).ok()?;
    let mut table = document.get_ref();
    let mut at = None;
    for part in field.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, rest)) => (name, rest.trim_end_matches(']').parse::<usize>().ok()),
            None => (part, None),
        };
        let Some((_, value)) = table.iter().find(|(key, _)| key.get_ref().as_ref() == name) else { break };
        at = Some(value.span());
        if let (toml::de::DeValue::Array(items), Some(i)) = (value.get_ref(), index) {
            at = items.get(i).map(toml::Spanned::span).or(at);
        }
        match value.get_ref() {
            toml::de::DeValue::Table(inner) => table = inner,
            _ => break,
        }
    }
    let start = at?.start;
    Some(text.get(..start)?.matches('\n').count() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOUND: &str = "origin = { lat = 47.4, lon = 8.5, alt_m = 400.0 }\npois_u = [[1.0, 2.0], [3, 4]]\n";

    fn refused(text: &str) -> String {
        Mission::from_toml(text, Path::new("m.toml")).unwrap_err().to_string()
    }

    #[test]
    fn what_is_left_out_has_the_scenarios_values() {
        let m = Mission::from_toml(SOUND, Path::new("m.toml")).unwrap();
        assert_eq!((m.scale, m.side_u, m.policy_seed), (Scale { unit_m: 2.5, step_ms: 2000 }, 200.0, 10));
        assert_eq!(m.half_side(), Scenario::default().half_side_ticks());
        assert_eq!(m.pois, [Vec2 { x: 1024, y: 2048 }, Vec2 { x: 3072, y: 4096 }]);
        assert_eq!(m.fence[0], Vec2 { x: -10_240, y: -10_240 });
    }

    #[test]
    fn errors_name_the_field_the_line_and_the_way_out() {
        for (line, parts) in [
            ("speed = 3", &["line 3", "unknown field `speed`", "scale_m"][..]),
            ("scale_m = -1.0", &["m.toml, line 3", "scale_m = -1; use 0.1 to 100"]),
            ("scale_m = nan", &["line 3", "scale_m = NaN"]),
            ("scale_m = \"wide\"", &["line 3", "expected f64"]),
            ("step_ms = 70000", &["line 3", "u16"]),
            ("step_ms = 50", &["line 3", "use 200 to 32767"]),
            ("\n[altitude]\nlayers = 0", &["line 5", "altitude.layers = 0; use 1 to 1000"]),
            ("[fence]\nmargin_u = 3.0\npolygon_u = [[0,0],[1,0],[1,1]]", &["line 3", "more than one form"]),
            ("[fence]\npolygon_u = [[0,0],[1,0],[0,0]]", &["line 4", "3 to 16 corners, not 2"]),
            ("pois_lat_lon = [\n [47.4, 8.5],\n [8.5, 47.4]]", &["line 5", "pois_lat_lon[1]", "latitude first?"]),
            ("side_u = 16000.0", &["line 3", "40000 m; use 10000 m at most"]),
        ] {
            let message = refused(&format!("{SOUND}{line}"));
            for part in parts {
                assert!(message.contains(part), "{part:?} is not in {message:?}");
            }
        }
        assert!(refused("pois_u = [[1, 2]]").contains("missing field `origin`"));
        assert!(refused(&SOUND.replace("8.5", "179.9")).contains("line 1: origin.lon is the longitude 179.9"));
        assert!(refused(&SOUND.replace("[3, 4]", "[3, 400]")).contains("pois_u[1] is at (3, 400) u, outside the map"));
        assert!(refused(&SOUND.replace("pois_u", "# ")).contains("both empty"));
    }

    #[test]
    fn places_in_degrees_are_laid_on_the_map() {
        let text = "origin = { lat = 47.4, lon = 8.5, alt_m = 400.0 }\npois_lat_lon = [[47.401, 8.501]]\n\
            [fence]\npolygon_lat_lon = [[47.4, 8.5], [47.4, 8.51], [47.41, 8.51], [47.4, 8.5]]";
        let m = Mission::from_toml(text, Path::new("m.toml")).unwrap();
        let (x, y) = m.pois[0].to_u();
        // 0.001 degrees: 111.32 m north and 75.35 m east, at 2.5 m a unit.
        assert!((x - 30.14).abs() < 0.02 && (y - 44.53).abs() < 0.02, "{x} {y}");
        assert_eq!((m.fence.len(), m.fence[0]), (3, Vec2::default()));
    }
}
