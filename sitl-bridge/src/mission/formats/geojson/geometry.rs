//! Geometries: which are PoIs, which the fence, and which nothing that a mission knows.

use super::crs;
use super::kind::{kind, lead};
use crate::mission::drawing::{Drawing, Spot};
use crate::mission::fault::{Fault, broken, fault};
use crate::mission::formats::json;
use serde_json::{Map, Value};

/// Draws a geometry. Its place in the file is `at`.
pub(super) fn draw(drawing: &mut Drawing, object: &Map<String, Value>, at: &str) -> Result<(), Fault> {
    let kind = kind(object, at)?;
    crs::check(object, at)?;
    match kind {
        "Feature" | "FeatureCollection" => Err(fault(at, format!("has a {kind} where a geometry belongs"))),
        "GeometryCollection" => {
            let parts = object.get("geometries").and_then(Value::as_array).ok_or_else(|| {
                fault(at, "is a GeometryCollection, which has a member `geometries`, an array, and this one has none")
            })?;
            if parts.is_empty() {
                return empty(drawing, at, kind);
            }
            for (i, part) in parts.iter().enumerate() {
                let at = format!("{at} geometries[{i}]");
                match part {
                    Value::Object(part) => draw(drawing, part, &at)?,
                    Value::Null => empty(drawing, &at, "geometry")?,
                    other => return Err(fault(&at, format!("is {}; it is a geometry", json::named(other)))),
                }
            }
            Ok(())
        }
        _ => {
            let coordinates = match object.get("coordinates") {
                None | Some(Value::Null) => {
                    return Err(broken(format!("{}the {kind} has no member `coordinates`", lead(at))));
                }
                Some(Value::Array(coordinates)) => coordinates,
                Some(other) => {
                    return Err(fault(
                        at,
                        format!("has {} for its coordinates; they are an array", json::named(other)),
                    ));
                }
            };
            coordinates_of(drawing, kind, coordinates, at)
        }
    }
}

fn coordinates_of(drawing: &mut Drawing, kind: &str, coordinates: &[Value], at: &str) -> Result<(), Fault> {
    match kind {
        "Point" if coordinates.is_empty() => empty(drawing, at, kind),
        "Point" => {
            let (lat, lon, alt_m) = position(coordinates, at)?;
            drawing.poi(at, lat, lon, alt_m)
        }
        "MultiPoint" if coordinates.is_empty() => empty(drawing, at, kind),
        "MultiPoint" => coordinates.iter().enumerate().try_for_each(|(i, point)| {
            let at = format!("{at} coordinates[{i}]");
            let (lat, lon, alt_m) = position(array(point, &at)?, &at)?;
            drawing.poi(&at, lat, lon, alt_m)
        }),
        "Polygon" => polygon(drawing, coordinates, at),
        "MultiPolygon" => match coordinates {
            [] => Err(no_corners(at, kind)),
            [only] => polygon(drawing, array(only, at)?, at),
            several => Err(fault(
                at,
                format!(
                    "is a MultiPolygon of {} polygons, and a mission has one fence: join them, or keep one (QGIS: Vector, \
                     Geometry Tools, Multipart to Singleparts)",
                    several.len()
                ),
            )),
        },
        "LineString" => drawing.line(at, kind, is_closed(coordinates)),
        _ => {
            let closed = coordinates.iter().any(|line| line.as_array().and_then(|line| is_closed(line)) == Some(true));
            drawing.line(at, kind, Some(closed))
        }
    }
}

/// The fence: one ring without holes.
fn polygon(drawing: &mut Drawing, rings: &[Value], at: &str) -> Result<(), Fault> {
    let is_drawn = |ring: &&Value| ring.as_array().is_none_or(|ring| !ring.is_empty());
    let Some(outer) = rings.first().filter(is_drawn) else { return Err(no_corners(at, "Polygon")) };
    if outer.get(0).is_some_and(Value::is_number) {
        return Err(fault(
            at,
            "lacks a pair of brackets: a polygon's coordinates are rings of positions, [[[longitude, latitude], ...]]",
        ));
    }
    let holes = rings[1..].iter().filter(is_drawn).count();
    if holes > 0 {
        let holes = if holes == 1 { "a hole".to_owned() } else { format!("{holes} holes") };
        return Err(fault(
            at,
            format!(
                "is a polygon with {holes}, and a fence has none: remove the inner rings, or draw the fence around them"
            ),
        ));
    }
    let mut corners: Vec<Spot> = Vec::new();
    for (i, corner) in array(outer, at)?.iter().enumerate() {
        let at = format!("{at} corner {i}");
        let (lat, lon, _) = position(array(corner, &at)?, &at)?;
        corners.push(drawing.spot(&at, lat, lon, None)?);
    }
    drawing.set_fence(at, corners)
}

/// RFC 7946 lets empty coordinates stand for no geometry.
fn empty(drawing: &mut Drawing, at: &str, kind: &str) -> Result<(), Fault> {
    drawing.notes.push(format!("{at} is an empty {kind} and passed over"));
    Ok(())
}

fn no_corners(at: &str, kind: &str) -> Fault {
    fault(at, format!("is a {kind} without corners: draw them, or remove it, and the fence is the map and a margin"))
}

fn is_closed(line: &[Value]) -> Option<bool> {
    Some(line.len() >= 4 && line.first()? == line.last()?)
}

fn array<'v>(value: &'v Value, at: &str) -> Result<&'v [Value], Fault> {
    match value {
        Value::Array(values) => Ok(values),
        Value::Number(_) => Err(fault(at, "has a number where a position belongs: write [longitude, latitude]")),
        other => {
            Err(fault(at, format!("has {} where a position belongs: write [longitude, latitude]", json::named(other))))
        }
    }
}

/// Latitude, longitude and altitude of a position. Numbers behind the altitude mean nothing (RFC 7946, 3.1.1).
fn position(numbers: &[Value], at: &str) -> Result<(f64, f64, Option<f64>), Fault> {
    let number = |value: &Value| {
        value.as_f64().ok_or_else(|| {
            let advice = match value {
                Value::String(text) if text.trim().parse::<f64>().is_ok() => {
                    format!(": write {} without quotes", text.trim())
                }
                Value::String(text) if text.replace(',', ".").trim().parse::<f64>().is_ok() => {
                    format!(": write {} without quotes and with a point", text.replace(',', ".").trim())
                }
                Value::Array(_) => ": there is a pair of brackets too many".to_owned(),
                _ => ": coordinates are numbers".to_owned(),
            };
            fault(at, format!("has {} in its position{advice}", json::named(value)))
        })
    };
    match numbers {
        [lon, lat, rest @ ..] => {
            let (lon, lat) = (number(lon)?, number(lat)?);
            Ok((lat, lon, rest.first().and_then(Value::as_f64)))
        }
        [Value::Array(_)] => Err(fault(at, "has a pair of brackets too many around its position")),
        short => {
            let numbers = if short.len() == 1 { "1 number".to_owned() } else { format!("{} numbers", short.len()) };
            Err(fault(at, format!("has a position of {numbers}; give longitude and latitude")))
        }
    }
}
