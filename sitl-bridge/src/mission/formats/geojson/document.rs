//! A GeoJSON text: its features, and the member `covey`.

use super::kind::{kind, lead};
use super::{crs, geometry};
use crate::mission::drawing::{Drawing, Order};
use crate::mission::fault::{Fault, broken, fault};
use crate::mission::file::MissionFile;
use crate::mission::formats::json;
use serde_json::{Map, Value};

/// What a GeoJSON file says.
#[derive(Debug)]
pub(in crate::mission) struct Read {
    /// The member `covey`, where there is one.
    pub covey: Option<MissionFile>,
    pub drawing: Drawing,
}

/// Reads a text.
pub(in crate::mission) fn read(text: &str) -> Result<Read, Fault> {
    let records = json::values(text)?;
    let is_sequence = records.len() > 1 || text.trim_start().starts_with('\u{1e}');
    let mut read = Read { covey: None, drawing: Drawing::new(Order::LonLat) };
    let mut covey_from = String::new();
    for json::Record { line, value } in records {
        let mut object = match value {
            Value::Object(object) => object,
            Value::Array(_) => {
                return Err(broken(
                    "it is a JSON array; put its features into {\"type\": \"FeatureCollection\", \"features\": [...]}",
                ));
            }
            other => return Err(broken(format!("line {line}: {} is no GeoJSON object", json::named(&other)))),
        };
        let at = if is_sequence { format!("line {line}") } else { String::new() };
        if let Some(member) = object.remove("covey") {
            if read.covey.is_some() {
                return Err(broken(format!("{at} has a member `covey`, and {covey_from} has one; a mission has one")));
            }
            read.covey = Some(MissionFile::from_json(member)?);
            covey_from = at.clone();
        } else if let Some(other) = object.keys().find(|key| key.eq_ignore_ascii_case("covey")) {
            return Err(broken(format!("its member `{other}` is written `covey`")));
        }
        document(&mut read.drawing, &object, &at)?;
    }
    Ok(read)
}

/// A collection, a feature or a geometry; `at` is where it stands, empty for the whole file.
fn document(drawing: &mut Drawing, object: &Map<String, Value>, at: &str) -> Result<(), Fault> {
    let kind = kind(object, at)?;
    let within = |name: String| if at.is_empty() { name } else { format!("{at}, {name}") };
    match kind {
        "FeatureCollection" => {
            crs::check(object, at)?;
            let features = object.get("features").ok_or_else(|| {
                broken(format!(
                    "{}a FeatureCollection has a member `features`, an array, and this one has none",
                    lead(at)
                ))
            })?;
            let Value::Array(features) = features else {
                return Err(fault(&within("features".into()), format!("is {}; it is an array", json::named(features))));
            };
            for (i, value) in features.iter().enumerate() {
                let at = within(format!("features[{i}]"));
                let Value::Object(object) = value else {
                    return Err(fault(&at, format!("is {}; it is a Feature", json::named(value))));
                };
                feature(drawing, object, &at)?;
            }
            Ok(())
        }
        "Feature" => feature(drawing, object, if at.is_empty() { "the feature" } else { at }),
        _ => geometry::draw(drawing, object, if at.is_empty() { "the geometry" } else { at }),
    }
}

fn feature(drawing: &mut Drawing, object: &Map<String, Value>, at: &str) -> Result<(), Fault> {
    let kind = kind(object, at)?;
    if kind != "Feature" {
        let advice = if kind == "FeatureCollection" {
            "collections do not stand in collections: take its features out".to_owned()
        } else {
            format!(
                "wrap it: {{\"type\": \"Feature\", \"properties\": {{}}, \"geometry\": {{\"type\": \"{kind}\", ...}}}}"
            )
        };
        return Err(fault(at, format!("is a {kind}, and features are a Feature each; {advice}")));
    }
    crs::check(object, at)?;
    match object.get("geometry") {
        None | Some(Value::Null) => {
            drawing.notes.push(format!("{at} has no geometry and is passed over"));
            Ok(())
        }
        Some(Value::Object(geometry)) => geometry::draw(drawing, geometry, at),
        Some(other) => {
            Err(fault(&format!("{at}.geometry"), format!("is {}; it is an object or null", json::named(other))))
        }
    }
}
