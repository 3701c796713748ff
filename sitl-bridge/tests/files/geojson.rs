//! GeoJSON as QGIS, geojson.io, Leaflet and scripts write it.

use super::{load, loaded, refused, utf16};
use sitl_bridge::mission::Mission;

const COVEY: &str = r#""covey": {"origin": {"lat": 47.4, "lon": 8.5, "alt_m": 400}}"#;
const POINT: &str = r#"{"type": "Point", "coordinates": [8.501, 47.401]}"#;
const RING: &str = "[8.4995,47.3995],[8.508,47.3995],[8.508,47.406],[8.4995,47.406],[8.4995,47.3995]";

fn feature(geometry: &str) -> String {
    format!(r#"{{"type": "Feature", "properties": {{"name": "Zürich"}}, "geometry": {geometry}}}"#)
}

fn geometry(kind: &str, coordinates: &str) -> String {
    format!(r#"{{"type": "{kind}", "coordinates": {coordinates}}}"#)
}

/// A collection of a point and this geometry.
fn with(other: &str) -> String {
    format!(r#"{{"type": "FeatureCollection", {COVEY}, "features": [{}, {}]}}"#, feature(POINT), feature(other))
}

fn plain() -> Mission {
    loaded("m.geojson", format!(r#"{{"type": "FeatureCollection", {COVEY}, "features": [{}]}}"#, feature(POINT))).0
}

#[test]
fn points_and_polygons_in_every_form_are_read() {
    let fenced = loaded("m.geojson", with(&geometry("Polygon", &format!("[[{RING}]]")))).0;
    assert_eq!((fenced.pois.len(), fenced.fence.len()), (1, 4));
    let mut reversed: Vec<_> = RING.split("],[").map(|c| format!("[{}]", c.trim_matches(['[', ']']))).collect();
    reversed.reverse();
    let open = RING.rsplit_once(",[").unwrap().0;
    let same_fence = [
        ("one polygon in a multipolygon", geometry("MultiPolygon", &format!("[[[{RING}]]]"))),
        ("an open ring", geometry("Polygon", &format!("[[{open}]]"))),
        ("a corner twice", geometry("Polygon", &format!("[[[8.4995,47.3995],{RING}]]"))),
        (
            "positions with altitudes",
            geometry("Polygon", &format!("[[{}]]", RING.replace("],", ",0],").replace("5]", "5,0]"))),
        ),
        ("an empty hole", geometry("Polygon", &format!("[[{RING}],[]]"))),
        (
            "a collection",
            format!(
                r#"{{"type": "GeometryCollection", "geometries": [{}]}}"#,
                geometry("Polygon", &format!("[[{RING}]]"))
            ),
        ),
    ];
    for (what, polygon) in same_fence {
        assert_eq!(loaded("m.geojson", with(&polygon)).0, fenced, "{what}");
    }
    let clockwise = loaded("m.geojson", with(&geometry("Polygon", &format!("[[{}]]", reversed.join(","))))).0;
    assert_eq!(clockwise.fence.len(), 4);
    let straight = RING.replacen("],[", "],[8.5037,47.3995],[", 1);
    assert_eq!(loaded("m.geojson", with(&geometry("Polygon", &format!("[[{straight}]]")))).0.fence.len(), 5);
    for (pois, points) in [
        (3, geometry("MultiPoint", "[[8.502,47.401],[8.503,47.401,430,99]]")),
        (2, geometry("Point", "[8.502,47.401,430.5,1,2]")),
        (2, format!(r#"{{"type": "GeometryCollection", "geometries": [{}]}}"#, geometry("Point", "[8.502,47.401]"))),
        (1, "null".into()),
        (1, geometry("Point", "[]")),
        (1, geometry("MultiPoint", "[]")),
        (1, geometry("LineString", "[[8.5,47.4],[8.501,47.401]]")),
        (1, geometry("MultiLineString", "[[[8.5,47.4],[8.501,47.401]]]")),
    ] {
        let (m, said) = loaded("m.geojson", with(&points));
        assert_eq!(m.pois.len(), pois, "{points}");
        assert!(pois > 1 || said.contains("features[1]"), "{points}: {said}");
    }
    let no_member = with("null").replace(r#", "geometry": null"#, "");
    assert!(loaded("m.geojson", no_member).1.contains("features[1] has no geometry"));
    let extras = with("null").replace(r#""covey""#, r#""name": "x", "bbox": [8.5,47.4,8.6,47.5], "id": "a1", "covey""#);
    assert_eq!(loaded("m.geojson", extras).0, plain());
}

#[test]
fn what_cannot_be_used_is_named_with_its_place_and_the_way_out() {
    let circle: Vec<_> = (0..36)
        .map(|i| (f64::from(i) * 0.174_532_925).sin_cos())
        .map(|(s, c)| format!("[{},{}]", 8.504 + 0.003 * c, 47.403 + 0.002 * s))
        .collect();
    for (other, parts) in [
        (
            geometry("MultiPolygon", &format!("[[[{RING}]],[[{RING}]]]")),
            &["features[1] is a MultiPolygon of 2 polygons", "join them"][..],
        ),
        (
            geometry("Polygon", &format!("[[{RING}],[[8.502,47.401],[8.503,47.401],[8.503,47.402],[8.502,47.401]]]")),
            &["features[1]", "with a hole"],
        ),
        (geometry("Polygon", "[]"), &["features[1] is a Polygon without corners"]),
        (geometry("Polygon", "[[]]"), &["features[1] is a Polygon without corners"]),
        (geometry("MultiPolygon", "[]"), &["features[1] is a MultiPolygon without corners"]),
        (
            geometry("Polygon", &format!("[[{}]]", circle.join(","))),
            &["features[1] has 36 corners", "16 at most", "convert m.geojson m.toml --simplify-fence"],
        ),
        (geometry("Polygon", "[[[8.5,47.4],[8.51,47.4]]]"), &["features[1]", "3 to 16 corners, not 2"]),
        (
            geometry("Polygon", "[[[8.5,47.4],[8.51,47.41],[8.51,47.4],[8.5,47.41]]]"),
            &["features[1]", "touch or cross"],
        ),
        (
            geometry("Polygon", "[[[8.5,47.4],[47.4,8.51],[8.51,47.41]]]"),
            &["features[1] corner 1 is at longitude 47.4, latitude 8.51", "swapped"],
        ),
        (
            geometry("LineString", &format!("[{RING}]")),
            &["features[1] is a LineString that ends where it begins", "Polygon"],
        ),
        (
            geometry("Point", "[47.401,8.501]"),
            &["features[1] is at longitude 47.401, latitude 8.501", "swapped", "longitude comes first"],
        ),
        (geometry("Point", "[8.501,147.401]"), &["features[1]", "swapped"]),
        (geometry("Point", "[8.501]"), &["features[1] has a position of 1 number; give longitude and latitude"]),
        (
            geometry("Point", r#"["8.501","47.401"]"#),
            &["features[1] has the text \"8.501\"", "write 8.501 without quotes"],
        ),
        (geometry("Point", r#"["8,501","47,401"]"#), &["write 8.501 without quotes and with a point"]),
        (geometry("Point", "[[8.501,47.401]]"), &["features[1]", "a pair of brackets too many"]),
        (geometry("Polygon", &format!("[{RING}]")), &["features[1] lacks a pair of brackets"]),
        (geometry("Polygon", &format!("[[[{RING}]]]")), &["features[1] corner 0", "a pair of brackets too many"]),
        (geometry("MultiPolygon", &format!("[[{RING}]]")), &["features[1] lacks a pair of brackets"]),
        (
            geometry("MultiPoint", "[8.501,47.401]"),
            &["features[1] coordinates[0] has a number where a position belongs"],
        ),
        (geometry("Point", "[null,47.401]"), &["features[1] has null in its position"]),
        (geometry("Point", "[9.9,47.401]"), &["features[1]", "105 km from the origin at latitude 47.4, longitude 8.5"]),
        (geometry("Point", "[946326.9,6001234.5]"), &["features[1]", "no degrees", "EPSG:3857", "Export in EPSG:4326"]),
        (geometry("point", "[8.501,47.401]"), &["features[1]: the type \"point\" is written \"Point\""]),
        (geometry("Circle", "[8.501,47.401]"), &["features[1]: \"Circle\" is no type of GeoJSON"]),
        (r#"{"type": "Point"}"#.into(), &["features[1]: the Point has no member `coordinates`"]),
        (r#"{"coordinates": [8.5,47.4]}"#.into(), &["features[1]: the member `type` is missing"]),
        ("[8.501,47.401]".into(), &["features[1].geometry is an array"]),
    ] {
        let said = refused("m.geojson", with(&other));
        for part in parts {
            assert!(said.contains(part), "{part:?} is not in {said:?}");
        }
    }
    let two = with(&geometry("Polygon", &format!("[[{RING}]]")))
        .replace("features\": [", &format!("features\": [{},", feature(&geometry("Polygon", &format!("[[{RING}]]")))));
    assert!(refused("m.geojson", two).contains("features[2] is a second polygon besides features[0]"));
}

#[test]
fn longitudes_go_around_the_earth() {
    let (m, said) = loaded("m.geojson", with(&geometry("Point", "[368.502,47.401]")));
    assert_eq!(m.pois.len(), 2);
    assert!(said.contains("features[1]: 368.502 is 8.502"), "{said}");
    let at = |origin: &str, lon: &str| {
        let text = with(&geometry("Point", &format!("[{lon},-16.8]")))
            .replace("\"lat\": 47.4, \"lon\": 8.5", &format!("\"lat\": -16.801, \"lon\": {origin}"));
        loaded("m.geojson", text.replace("[8.501, 47.401]", &format!("[{lon}, -16.8]"))).0
    };
    for (origin, lon) in [
        ("179.998", "-179.999"),
        ("179.998", "180.001"),
        ("-180", "-179.997"),
        ("-180", "180.003"),
        ("180", "-179.997"),
    ] {
        let m = at(origin, lon);
        let x = m.pois[0].to_u().0;
        assert!((x - 127.9).abs() < 0.2, "{origin} {lon}: {x}");
    }
}

#[test]
fn only_degrees_on_wgs_84_are_read() {
    let crs = |name: &str| {
        with("null").replace(
            r#""covey""#,
            &format!(r#""crs": {{"type": "name", "properties": {{"name": "{name}"}}}}, "covey""#),
        )
    };
    for name in ["urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:4326", "urn:ogc:def:crs:EPSG::4326"] {
        assert_eq!(loaded("m.geojson", crs(name)).0, plain(), "{name}");
    }
    for name in ["urn:ogc:def:crs:EPSG::3857", "urn:ogc:def:crs:EPSG::4149", "EPSG:25832"] {
        let said = refused("m.geojson", crs(name));
        assert!(said.contains(name) && said.contains("export in EPSG:4326"), "{said}");
    }
}

#[test]
fn single_features_geometries_and_sequences_are_read() {
    let bare = feature(POINT).replacen('{', &format!("{{{COVEY}, "), 1);
    let geometry = POINT.replacen('{', &format!("{{{COVEY}, "), 1);
    let lines = format!("{bare}\n{}\n", feature(&self::geometry("Point", "[8.502,47.401]")));
    let separated = format!("\u{1e}{bare}\n\u{1e}{}\n", feature(&self::geometry("Point", "[8.502,47.401]")));
    assert_eq!(loaded("m.geojson", &bare).0, plain());
    assert_eq!(loaded("m.geojson", geometry).0, plain());
    assert_eq!(loaded("m.geojsonl", &lines).0.pois.len(), 2);
    assert_eq!(loaded("m.json", separated).0, loaded("m.ndjson", &lines).0);
    let said = refused("m.geojsonl", lines.replace("8.502", "88.502"));
    assert!(said.contains("line 2 is at longitude 88.502"), "{said}");
    let said = refused("m.geojsonl", format!("{bare}\n{bare}\n"));
    assert!(said.contains("line 2 has a member `covey`"), "{said}");
    assert!(refused("m.json", format!("[{bare}]")).contains("FeatureCollection"));
}

#[test]
fn a_file_without_a_map_is_shown_what_to_add() {
    for (name, text) in [
        ("no.geojson", format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, feature(POINT))),
        ("no.geojson", feature(POINT)),
        ("no.geojson", POINT.to_owned()),
        ("no.geojson", format!("{}\n{}", feature(POINT), feature(POINT))),
    ] {
        let said = refused(name, &text);
        let snippet = said.split_once("\"type\",\n").unwrap().1.split_once("\nwith").unwrap().0;
        assert!(said.contains("sitl-bridge mission convert --alt-m METRES no.geojson no.toml"), "{said}");
        // It can be pasted as it is.
        let pasted = text.replacen('{', &format!("{{{snippet}"), 1);
        let (m, _) = loaded(name, pasted);
        let (x, y) = m.pois[0].to_u();
        let middle = m.side_u as f32 / 2.0;
        assert!((x - middle).abs() < 1.0 && (y - middle).abs() < 1.0, "{x} {y}");
    }
    let without_origin = with("null").replace(r#""origin": {"lat": 47.4, "lon": 8.5, "alt_m": 400}"#, "");
    assert!(refused("m.geojson", without_origin).contains("missing field `covey.origin`"));
    let cased = with("null").replace("\"covey\"", "\"Covey\"");
    assert!(refused("m.geojson", cased).contains("`Covey` is written `covey`"));
    let typed = with("null").replace("\"lat\": 47.4", "\"lat\": \"47.4\"");
    assert!(refused("m.geojson", typed).contains("covey.origin.lat: invalid type: string"));
    let wide = with("null").replace("\"covey\": {", "\"covey\": {\"scale_m\": 1000, ");
    assert!(refused("m.geojson", wide).contains("covey.scale_m = 1000; use 0.1 to 100"));
    let unknown = with("null").replace("\"covey\": {", "\"covey\": {\"speed\": 1, ");
    assert!(refused("m.geojson", unknown).contains("unknown field `speed`"));
}

#[test]
fn broken_json_says_where_and_what_to_do() {
    let sound = with("null");
    for (text, parts) in [
        (sound.replace("[8.501, 47.401]", "[NaN, 47.401]"), &["line 1 column", "JSON has no NaN"][..]),
        (sound.replace("[8.501, 47.401]", "[8.501, -Infinity]"), &["JSON has no NaN and no infinity"]),
        (sound.replace("]}", "],}"), &["trailing comma at line 1", "remove the comma"]),
        (sound.replace('"', "'"), &["double quotes"]),
        (sound.replace("null", "None"), &["that is Python"]),
        (sound.replace("\"features\"", "// a comment\n\"features\""), &["line 1", "no comments"]),
        (sound[..sound.len() / 2].to_owned(), &["cut off"]),
        (sound.replace("8.501", ".501"), &["0.5"]),
        (sound.replace("\"features\"", "\"Features\""), &["has a member `features`"]),
        (sound.replace("8.501", "1e999"), &["line 1", "number out of range"]),
        (format!("{}{}", "[".repeat(500), "]".repeat(500)), &["recursion limit"]),
    ] {
        let said = refused("m.geojson", &text);
        for part in parts {
            assert!(said.contains(part), "{part:?} is not in {said:?}");
        }
    }
}

#[test]
fn whatever_the_editor_saved_is_read_or_named() {
    let text = with("null");
    assert_eq!(loaded("m.geojson", format!("\u{feff}{text}")).0, plain());
    assert_eq!(loaded("M.GEOJSON", &text).0, plain());
    assert_eq!(loaded("m", &text).0, plain());
    assert!(refused("m.geojson", utf16(&text, false, true)).contains("UTF-16"));
    let latin1: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    assert!(refused("m.geojson", latin1).contains("0xFC"));
    let (m, said) = loaded("m.kml", &text);
    assert_eq!(m, plain());
    assert!(said.contains("its content is GeoJSON, though its name says KML"), "{said}");
    let said = refused("m.kml", text.replace("47.401", "8.401"));
    assert!(said.contains("(its content is GeoJSON, its name says KML)"), "{said}");
    assert!(load("m.json", r#"{"type": "Topology", "objects": {}}"#).unwrap_err().contains("TopoJSON"));
}

#[test]
fn doubled_and_high_points_are_told() {
    let (m, said) = loaded("m.geojson", with(POINT));
    assert_eq!(m.pois.len(), 2);
    assert!(
        said.contains("1 of 2 PoIs lies where another does, and each counts: features[1] as features[0]"),
        "{said}"
    );
    let (_, said) = loaded("m.geojson", with(&geometry("Point", "[8.502,47.401,700]")));
    assert!(said.contains("1 of 2 PoIs lies higher than the lowest layer (420 m above sea level)"), "{said}");
    let (m, said) = loaded("m.geojson", with(&geometry("Point", "[8.49,47.401]")));
    assert_eq!(m.pois.len(), 1);
    assert!(said.contains("beyond the map of 0 to 200 u and left out: features[1] at (-301.4, 44.5) u"), "{said}");
    let small = "[[8.4995,47.3995],[8.502,47.3995],[8.502,47.402],[8.4995,47.402]]";
    let far = with(&geometry("Polygon", &format!("[{small}]"))).replace("[8.501, 47.401]", "[8.5065, 47.4044]");
    assert!(loaded("m.geojson", far).1.contains("the only PoI lies outside the fence"));
}
