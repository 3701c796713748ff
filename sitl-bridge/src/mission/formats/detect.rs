//! Which format a mission file has: its content tells, and where that does not, its name.

use super::csv;
use crate::mission::format::Format;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::path::Path;

/// What is said of a file that has none of the formats.
pub(in crate::mission) const FORMATS: &str =
    "missions are TOML, GeoJSON, KML, CSV, QGroundControl's .plan or QGC WPL waypoints";

/// What the content of a file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::mission) enum Content {
    /// It is this.
    Is(Format),
    /// It has the beginnings of this, and may be another.
    Perhaps(Format),
    /// A known format that is no mission, and what to do.
    Foreign(&'static str),
    /// Anything.
    Unknown,
}

#[derive(Deserialize)]
struct Head {
    #[serde(rename = "fileType")]
    file_type: Option<IgnoredAny>,
    #[serde(rename = "type", default)]
    kind: serde_json::Value,
    #[serde(rename = "spatialReference")]
    spatial_reference: Option<IgnoredAny>,
    #[serde(rename = "geometryType")]
    geometry_type: Option<IgnoredAny>,
}

impl Format {
    /// Reads the signs in a text.
    pub(in crate::mission) fn of_content(text: &str) -> Content {
        let text = text.trim_start();
        match text.as_bytes() {
            [b'{' | 0x1E, ..] => return of_json(text),
            [b'<', ..] => return of_xml(text),
            // A header of TOML is a name in one pair of brackets or in two.
            [b'[', ..] => {
                let inner = text.trim_start_matches(|c: char| c == '[' || c.is_whitespace());
                let depth = text.len() - inner.len();
                let is_json = inner.starts_with(|c: char| "{]-".contains(c) || c.is_ascii_digit());
                if is_json || depth > 2 || (depth == 1 && inner.starts_with('"')) {
                    return Content::Is(Self::GeoJson);
                }
            }
            _ => {}
        }
        if text.starts_with("QGC WPL") {
            return Content::Is(Self::Waypoints);
        }
        let meaningful = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
        let Some(line) = text.lines().find(meaningful).map(str::trim) else { return Content::Unknown };
        if csv::is_table(line) {
            return Content::Is(Self::Csv);
        }
        if line.starts_with('[') || line.split_once('=').is_some_and(|(key, _)| is_key(key.trim())) {
            return Content::Is(Self::Toml);
        }
        if line.contains([',', ';', '\t']) { Content::Perhaps(Self::Csv) } else { Content::Unknown }
    }

    /// What the name of a file says; the first is the usual one.
    pub(in crate::mission) fn of_name(path: &Path) -> &'static [Self] {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("toml") => &[Self::Toml],
            Some("geojson" | "geojsonl" | "geojsons" | "geojsonseq" | "ndjson" | "jsonl" | "ndgeojson") => {
                &[Self::GeoJson]
            }
            Some("json") => &[Self::GeoJson, Self::Plan],
            Some("kml" | "xml") => &[Self::Kml],
            Some("csv" | "tsv") => &[Self::Csv],
            Some("plan") => &[Self::Plan],
            Some("waypoints" | "wp" | "wpl" | "mission") => &[Self::Waypoints],
            _ => &[],
        }
    }
}

fn is_key(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "_-.\"' ".contains(c))
}

fn of_json(text: &str) -> Content {
    let Ok(head) = serde_json::from_str::<Head>(text) else {
        let plan = text.contains("\"fileType\"") && text.contains("\"Plan\"");
        return Content::Is(if plan { Format::Plan } else { Format::GeoJson });
    };
    if head.file_type.is_some() {
        return Content::Is(Format::Plan);
    }
    if head.kind == "Topology" {
        return Content::Foreign("it is TopoJSON: convert it to GeoJSON, for instance with mapshaper or QGIS");
    }
    if head.kind.is_null() && (head.spatial_reference.is_some() || head.geometry_type.is_some()) {
        return Content::Foreign("it is Esri JSON: export it as GeoJSON (ArcGIS: `f=geojson`)");
    }
    Content::Is(Format::GeoJson)
}

fn of_xml(text: &str) -> Content {
    // The root: the first tag that is neither a declaration nor a comment.
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        if rest.starts_with("!--") {
            rest = rest.split_once("-->").map_or("", |(_, rest)| rest);
        } else if !rest.starts_with(['?', '!']) {
            break;
        }
    }
    let name: String = rest.chars().take_while(|c| !c.is_whitespace() && !">/".contains(*c)).collect();
    match name.rsplit(':').next().unwrap_or_default().to_ascii_lowercase().as_str() {
        "gpx" => Content::Foreign("it is GPX: export its waypoints as GeoJSON, KML or CSV"),
        "gml" | "featurecollection" => Content::Foreign("it is GML: export it as GeoJSON"),
        "html" => Content::Foreign("it is a web page: the download went wrong"),
        "osm" => Content::Foreign("it is OpenStreetMap data: export it as GeoJSON"),
        _ => Content::Is(Format::Kml),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_tells_the_format() {
        for (text, expected) in [
            ("# a\n\norigin = {}", Content::Is(Format::Toml)),
            ("[altitude]\nbase_m = 3", Content::Is(Format::Toml)),
            ("[[pois]]", Content::Is(Format::Toml)),
            ("  {\"type\": \"Feature\"}", Content::Is(Format::GeoJson)),
            ("\u{1e}{\"type\": \"Feature\"}", Content::Is(Format::GeoJson)),
            ("[{\"type\": \"Feature\"}]", Content::Is(Format::GeoJson)),
            ("[[8.5, 47.4]]", Content::Is(Format::GeoJson)),
            ("[[[", Content::Is(Format::GeoJson)),
            ("{\"fileType\": \"Plan\"}", Content::Is(Format::Plan)),
            ("{\"fileType\": \"Plan\", ", Content::Is(Format::Plan)),
            ("<?xml version=\"1.0\"?><!-- a > b --><kml>", Content::Is(Format::Kml)),
            ("QGC WPL 110\n", Content::Is(Format::Waypoints)),
            ("Name;Latitude;Longitude", Content::Is(Format::Csv)),
            ("sep=;\nlat;lon", Content::Is(Format::Csv)),
            ("47.4,8.5", Content::Is(Format::Csv)),
            ("one, two", Content::Perhaps(Format::Csv)),
            ("Dear all", Content::Unknown),
        ] {
            assert_eq!(Format::of_content(text), expected, "{text}");
        }
        assert!(matches!(Format::of_content("<gpx>"), Content::Foreign(advice) if advice.contains("GPX")));
        assert!(matches!(Format::of_content(r#"{"type":"Topology"}"#), Content::Foreign(_)));
        assert_eq!(Format::of_name(Path::new("A.GEOJSON")), [Format::GeoJson]);
    }
}
