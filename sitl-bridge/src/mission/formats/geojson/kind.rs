//! The member `type` of GeoJSON objects.

use crate::mission::fault::{Fault, broken};
use crate::mission::formats::json;
use serde_json::{Map, Value};

/// Kinds of geometry, by the names that RFC 7946 gives them.
const GEOMETRIES: [&str; 7] =
    ["Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon", "GeometryCollection"];

/// The member `type`, one of those there are.
pub(super) fn kind<'o>(object: &'o Map<String, Value>, at: &str) -> Result<&'o str, Fault> {
    let place = lead(at);
    let kind = match object.get("type") {
        Some(Value::String(kind)) => kind.as_str(),
        Some(other) => {
            return Err(broken(format!("{place}`type` is {}; it is a text such as \"Feature\"", json::named(other))));
        }
        None => {
            let cased = object.keys().find(|key| key.eq_ignore_ascii_case("type"));
            let hint = cased.map(|key| format!(" (`{key}` is written `type`)")).unwrap_or_default();
            return Err(broken(format!("{place}the member `type` is missing{hint}: is it GeoJSON?")));
        }
    };
    let all = || GEOMETRIES.into_iter().chain(["Feature", "FeatureCollection"]);
    if all().any(|known| known == kind) {
        return Ok(kind);
    }
    let near = all().find(|known| known.eq_ignore_ascii_case(kind.trim()));
    Err(broken(match near {
        Some(known) => format!("{place}the type \"{kind}\" is written \"{known}\": upper and lower case count"),
        None => {
            format!("{place}\"{kind}\" is no type of GeoJSON; PoIs are Point or MultiPoint, the fence is a Polygon")
        }
    }))
}

/// The beginning of an error: where it is; nothing for the whole file.
pub(super) fn lead(at: &str) -> String {
    if at.is_empty() { String::new() } else { format!("{at}: ") }
}
