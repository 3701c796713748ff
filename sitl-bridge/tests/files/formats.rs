//! KML, CSV, plans and waypoint lists, and files that are none of these.

use super::{load, refused};
use sitl_bridge::mission::{Draft, Format, Given, Loaded};
use std::path::Path;

pub(super) const PLAN: &str = r#"{"fileType": "Plan", "version": 1, "geoFence": {"polygons": [{"inclusion": true,
    "polygon": [[47.3995, 8.4995], [47.3995, 8.508], [47.406, 8.508], [47.406, 8.4995]]}], "circles": []},
    "mission": {"plannedHomePosition": [47.4, 8.5, 412.0], "items": [
    {"type": "SimpleItem", "command": 22, "params": [0, 0, 0, null, 47.4, 8.5, 30]},
    {"type": "SimpleItem", "command": 16, "params": [0, 0, 0, null, 47.401, 8.501, 30]}]},
    "rallyPoints": {"points": [[47.4, 8.5, 20]]}}"#;
pub(super) const KML: &str = "<?xml version=\"1.0\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><Placemark><name>Barn</name>\
    <Point><coordinates>8.501,47.401,0</coordinates></Point></Placemark></Document></kml>";
pub(super) const CSV: &str = "name;Latitude;Longitude\nBarn;47.401;8.501\nMill;47.402;8.502\n";
pub(super) const LIST: &str =
    "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t47.4\t8.5\t412\t1\n1\t0\t3\t16\t0\t0\t0\t0\t47.401\t8.501\t30\t1\n";

fn filled(name: &str, text: &str, given: &Given) -> Loaded {
    let mut draft = Draft::from_bytes(text.as_bytes(), Path::new(name)).unwrap_or_else(|e| panic!("{e}"));
    draft.fill(given);
    draft.finish().unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn places_become_a_mission_once_an_altitude_is_given() {
    let given = Given { alt_m: Some(400.0), ..Given::default() };
    for (name, text, format, pois) in [
        ("a.kml", KML, Format::Kml, 1),
        ("a.csv", CSV, Format::Csv, 2),
        ("a.plan", PLAN, Format::Plan, 1),
        ("a.waypoints", LIST, Format::Waypoints, 1),
        ("a.txt", CSV, Format::Csv, 2),
        ("a.txt", LIST, Format::Waypoints, 1),
    ] {
        let read = filled(name, text, &given);
        assert_eq!((read.format, read.mission.pois.len()), (format, pois), "{name}");
        assert_eq!(read.mission.plane.alt_mm, 400_000);
        assert!(read.remarks.iter().all(|r| !r.warning), "{:?}", read.remarks);
        // What is drawn lies in the middle of the map.
        let side = read.mission.side_u as f32;
        let (x, y) = read.mission.pois[0].to_u();
        assert!(x > 0.0 && y > 0.0 && x < side && y < side, "{name}: {x} {y} of {side}");
        let said = refused(name, text);
        assert!(said.contains("sitl-bridge mission convert"), "{said}");
        assert_eq!(said.contains("--alt-m METRES"), !matches!(format, Format::Plan | Format::Waypoints), "{said}");
    }
}

#[test]
fn a_home_position_gives_the_altitude_and_everything_can_be_given() {
    let read = filled("a.plan", PLAN, &Given::default());
    assert_eq!((read.mission.plane.alt_mm, read.mission.fence.len()), (412_000, 4));
    let said: Vec<_> = read.remarks.iter().map(ToString::to_string).collect();
    let said = said.join("\n");
    for words in [
        "412 m above sea level",
        "1 waypoints are taken as PoIs",
        "1 rally points are not used",
        "MAV_CMD 22",
        "the map is laid around",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let given = Given {
        lat: Some(47.4),
        lon: Some(8.5),
        alt_m: Some(1.5),
        scale_m: Some(2.0),
        side_u: Some(300.0),
        step_ms: Some(1000),
        policy_seed: Some(7),
        mode: Some(firmware_core::actor::Mode::Argmax),
        epoch_unix_ms: Some(-3),
        base_m: Some(30.0),
        spacing_m: Some(3.0),
        layers: Some(5),
        margin_u: Some(20.0),
        simplify_fence: false,
    };
    let mission = filled("a.csv", CSV, &given).mission;
    assert_eq!((mission.plane.lat_e7, mission.plane.lon_e7, mission.plane.alt_mm), (474_000_000, 85_000_000, 1500));
    assert_eq!((mission.side_u, mission.scale.unit_m, mission.scale.step_ms), (300.0, 2.0, 1000));
    assert_eq!((mission.policy_seed, mission.epoch_unix_ms, mission.layers.count), (7, -3, 5));
    assert_eq!(mission.fence[0].to_u(), (-20.0, -20.0));
}

#[test]
fn a_drawing_across_the_date_line_has_its_map_there() {
    let text = "lat,lon\n-16.8,179.999\n-16.801,-179.999\n";
    let mission = filled("a.csv", text, &Given { alt_m: Some(0.0), ..Given::default() }).mission;
    assert_eq!(mission.pois.len(), 2);
    assert!(mission.side_u < 120.0, "{}", mission.side_u);
}

#[test]
fn fences_of_many_corners_are_made_simpler_on_request_only() {
    let corner = |i: usize| {
        let (sin, cos) = (i as f64 / 40.0 * std::f64::consts::TAU).sin_cos();
        format!("[{}, {}]", 47.403 + 0.002 * sin, 8.504 + 0.003 * cos)
    };
    let ring: Vec<_> = (0..40).map(corner).collect();
    let start = PLAN.find("[[47.3995").unwrap();
    let end = PLAN.find("8.4995]]}").unwrap() + "8.4995]]".len();
    let plan = format!("{}[{}]{}", &PLAN[..start], ring.join(", "), &PLAN[end..]);
    let mut draft = Draft::from_bytes(plan.as_bytes(), Path::new("a.plan")).unwrap();
    draft.fill(&Given::default());
    let said = draft.clone().finish().unwrap_err().to_string();
    assert!(said.contains("geoFence.polygons[0] has 40 corners"), "{said}");
    draft.fill(&Given { simplify_fence: true, ..Given::default() });
    let read = draft.finish().unwrap();
    assert_eq!(read.mission.fence.len(), 16);
    assert!(read.remarks.iter().any(|r| r.text.contains("simplified from 40 corners to 16")), "{:?}", read.remarks);
}

#[test]
fn what_has_nothing_to_cover_says_why() {
    for (name, text, words) in [
        (
            "a.plan",
            r#"{"fileType": "Plan", "geoFence": {"polygons": []}, "mission": {"items": []}, "version": 1}"#,
            "there is no waypoint in it",
        ),
        (
            "a.waypoints",
            "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t47.4\t8.5\t400\t1\n",
            "line 2, number 0, is the home position",
        ),
        (
            "a.kml",
            "<kml><Placemark><LineString><coordinates>8.5,47.4 8.6,47.5</coordinates></LineString></Placemark></kml>",
            "is a LineString",
        ),
        ("a.csv", "lat,lon\n", "no row with a point"),
        ("a.geojson", r#"{"type": "FeatureCollection", "features": []}"#, "draw PoIs as Points"),
    ] {
        let said = refused(name, text);
        assert!(said.contains(words) && said.contains("something to cover"), "{said}");
    }
}

#[test]
fn content_and_name_that_disagree_are_both_named() {
    for (name, text, content, named) in [
        ("a.csv", KML, "KML", "CSV"),
        ("a.toml", PLAN, "a QGroundControl plan", "TOML"),
        ("a.geojson", CSV, "CSV", "GeoJSON"),
        ("a.plan", "origin = { lat = 1.0 }", "TOML", "a QGroundControl plan"),
    ] {
        let said = refused(name, text);
        assert!(said.contains(&format!("(its content is {content}, its name says {named})")), "{said}");
    }
}

#[test]
fn other_files_are_named_as_what_they_are() {
    for (name, bytes, words) in [
        ("a.kmz", &b"PK\x03\x04\x14\0\0\0"[..], "KMZ"),
        ("a.gpx", b"<?xml version=\"1.0\"?><gpx><wpt lat=\"1\" lon=\"2\"/></gpx>", "GPX"),
        ("a.shp", b"\0\0\x27\x0a\0\0\0\0", "shapefile"),
        ("a.gpkg", b"SQLite format 3\0", "GeoPackage"),
        ("a.geojson", b"<!DOCTYPE html><html>", "web page"),
        ("a.json", br#"{"geometryType": "esriGeometryPoint", "features": []}"#, "Esri JSON"),
        ("a.doc", b"Dear all", "neither its content nor its name"),
        ("a.kml", b"not xml", "broken XML"),
        ("a.toml", b"Dear all", "TOML parse error"),
        ("a.csv", b"Dear all", "is one column"),
    ] {
        let said = load(name, bytes).unwrap_err();
        assert!(said.contains(words), "{name}: {said}");
    }
}
