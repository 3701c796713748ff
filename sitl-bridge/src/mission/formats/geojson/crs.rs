//! The member `crs` of earlier GeoJSON: only degrees on WGS 84 are read.

use crate::mission::fault::{Fault, broken};
use serde_json::{Map, Value};

/// Refuses any other reference system by its name.
pub(super) fn check(object: &Map<String, Value>, at: &str) -> Result<(), Fault> {
    let Some(crs) = object.get("crs") else { return Ok(()) };
    let name = match crs {
        Value::Null => return Ok(()),
        Value::String(name) => name.clone(),
        other => name(other).unwrap_or_else(|| other.to_string()),
    };
    if is_wgs84(&name) {
        return Ok(());
    }
    let place = if at.is_empty() { String::new() } else { format!("{at}: ") };
    Err(broken(format!(
        "{place}its coordinate reference system is {name}, and missions are in WGS 84 degrees: export in EPSG:4326 (QGIS: Export, \
         Save Features As, CRS), or remove `crs` if the coordinates are longitude and latitude all the same"
    )))
}

fn name(crs: &Value) -> Option<String> {
    let properties = crs.get("properties")?;
    if let Some(code) = properties.get("code") {
        let authority = crs.get("type").and_then(Value::as_str).filter(|t| !t.eq_ignore_ascii_case("name"));
        let code = code.as_str().map_or_else(|| code.to_string(), str::to_owned);
        return Some(format!("{}:{code}", authority.unwrap_or("EPSG")));
    }
    let named = properties.get("name").or_else(|| properties.get("href"))?;
    Some(named.as_str()?.to_owned())
}

/// CRS84 and EPSG:4326 as tools spell them: `urn:ogc:def:crs:OGC:1.3:CRS84`, `EPSG:4326`, `urn:ogc:def:crs:EPSG::4326`,
/// `http://www.opengis.net/def/crs/OGC/1.3/CRS84`, `http://www.opengis.net/gml/srs/epsg.xml#4326`, `WGS 84`.
fn is_wgs84(name: &str) -> bool {
    let name = name.trim().to_ascii_lowercase();
    let parts: Vec<_> = name.split([':', '/', '#', ' ', '_', '-']).filter(|part| !part.is_empty()).collect();
    match parts.as_slice() {
        ["crs84"] | ["crs" | "ogc", "84" | "crs84"] | ["wgs84"] | ["wgs", "84"] | ["4326"] => true,
        [.., last] => {
            let has = |word: &str| parts.contains(&word);
            (*last == "crs84" && has("ogc")) || (*last == "4326" && (has("epsg") || has("epsg.xml")))
        }
        [] => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn wgs_84_in_all_its_spellings_and_nothing_else() {
        for name in [
            "urn:ogc:def:crs:OGC:1.3:CRS84",
            "urn:ogc:def:crs:OGC::CRS84",
            "OGC:CRS84",
            "CRS84",
            "CRS:84",
            "http://www.opengis.net/def/crs/OGC/1.3/CRS84",
            "https://www.opengis.net/def/crs/OGC/0/CRS84",
            "EPSG:4326",
            "epsg:4326",
            "urn:ogc:def:crs:EPSG::4326",
            "urn:ogc:def:crs:EPSG:6.9:4326",
            "urn:x-ogc:def:crs:EPSG:4326",
            "http://www.opengis.net/def/crs/EPSG/0/4326",
            "http://www.opengis.net/gml/srs/epsg.xml#4326",
            "WGS 84",
            "WGS84",
        ] {
            assert!(is_wgs84(name), "{name}");
        }
        for name in [
            "EPSG:3857",
            "urn:ogc:def:crs:EPSG::4149",
            "urn:ogc:def:crs:EPSG::14326",
            "EPSG:4258",
            "urn:ogc:def:crs:OGC:1.3:CRS83",
            "EPSG:4979",
            "WGS 84 / UTM zone 32N",
            "WGS 72",
            "",
        ] {
            assert!(!is_wgs84(name), "{name}");
        }
        for (crs, word) in [
            (json!({"type": "name", "properties": {"name": "EPSG:25832"}}), "EPSG:25832"),
            (json!({"type": "EPSG", "properties": {"code": 3857}}), "EPSG:3857"),
            (json!({"type": "link", "properties": {"href": "http://x/epsg/2056"}}), "epsg/2056"),
            (json!("EPSG:2056"), "EPSG:2056"),
            (json!({"odd": 1}), "odd"),
        ] {
            let object = Map::from_iter([("crs".to_owned(), crs)]);
            let said = check(&object, "features[3]").unwrap_err().problem;
            assert!(said.contains(word) && said.starts_with("features[3]: "), "{said}");
        }
        for crs in [json!(null), json!({"type": "EPSG", "properties": {"code": "4326"}}), json!("EPSG:4326")] {
            assert!(check(&Map::from_iter([("crs".to_owned(), crs)]), "").is_ok());
        }
    }
}
