//! The fields of a mission as they are written, and where TOML has them.

use super::definition::{HeightLimits, Layers};
use super::fault::{Fault, broken};
use super::text::place;
use firmware_core::neighbour_table::DEFAULT_STEP_MS;
use serde::{Deserialize, Serialize};

/// Longer lines are not shown in errors, characters.
const LONGEST_LINE: usize = 200;

/// A mission as it is written. `docs/mission.md` tells each field.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct MissionFile {
    pub origin: Option<Origin>,
    pub scale_m: f64,
    pub step_ms: u16,
    pub side_u: f64,
    pub policy_seed: u64,
    pub decide: Decide,
    pub epoch_unix_ms: i64,
    pub pois_u: Vec<[f64; 2]>,
    pub pois_lat_lon: Vec<[f64; 2]>,
    pub altitude: AltitudeFile,
    pub fence: FenceFile,
}

impl Default for MissionFile {
    fn default() -> Self {
        Self {
            origin: None,
            scale_m: 2.5,
            step_ms: DEFAULT_STEP_MS,
            side_u: firmware_core::geometry::MAP_SIDE_U.into(),
            policy_seed: 10,
            decide: Decide::Sample,
            epoch_unix_ms: 0,
            pois_u: Vec::new(),
            pois_lat_lon: Vec::new(),
            altitude: AltitudeFile::default(),
            fence: FenceFile::default(),
        }
    }
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
    pub highest_above_home_m: f64,
    pub home_within_m: f64,
    pub check_m: f64,
}

impl Default for AltitudeFile {
    fn default() -> Self {
        let Layers { base_m, spacing_m, count } = Layers::default();
        let HeightLimits { highest_above_home_m, home_within_m, check_m } = HeightLimits::default();
        Self { base_m, spacing_m, layers: count, highest_above_home_m, home_within_m, check_m }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FenceFile {
    pub margin_u: Option<f64>,
    pub polygon_u: Option<Vec<[f64; 2]>>,
    pub polygon_lat_lon: Option<Vec<[f64; 2]>>,
}

impl MissionFile {
    pub(super) fn from_toml(text: &str) -> Result<Self, Fault> {
        toml::from_str(text).map_err(|e| broken(explain(&e, text)))
    }

    /// From the member `covey` of a JSON document.
    pub(super) fn from_json(member: serde_json::Value) -> Result<Self, Fault> {
        serde_path_to_error::deserialize(member).map_err(|e| {
            let path = e.path().to_string();
            let place = if path == "." { "covey".to_owned() } else { format!("covey.{path}") };
            broken(format!("{place}: {}", e.into_inner()))
        })
    }
}

/// An error as the parser draws it, unless the line is too long to be shown.
fn explain(error: &toml::de::Error, text: &str) -> String {
    let drawn = error.to_string();
    if drawn.lines().all(|line| line.chars().count() <= LONGEST_LINE) {
        return drawn.trim_end().to_owned();
    }
    let (line, column) = place(text.as_bytes(), error.span().map_or(0, |span| span.start));
    format!("TOML parse error at line {line}, column {column}: {}", error.message())
}

/// The line of a field like `altitude.base_m` or `pois_u[3]` in TOML, from 1.
pub(super) fn line_of(text: &str, field: &str) -> Option<usize> {
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
