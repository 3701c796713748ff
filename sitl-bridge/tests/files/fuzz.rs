//! Runs the checks of the bridge's fuzz targets on the stable compiler: over their corpus, so that what they once found
//! stays fixed, and over some thousand inputs each made of it.

#[path = "../../../fuzz/bridge_checks.rs"]
mod checks;
#[path = "../../../fuzz/made_inputs.rs"]
mod made_inputs;

use made_inputs::{corpus, run};
use proptest::prelude::*;
use sitl_bridge::frame::Encoder;
use std::fs;

#[test]
fn mission_files() {
    run("mission_file", checks::mission_file);
}

#[test]
fn tlogs() {
    run("tlog", checks::tlog);
}

#[test]
fn connection_strings() {
    run("connection_string", checks::connection_string);
}

#[test]
fn mavlink_frames() {
    run("mavlink_frames", checks::mavlink_frames);
}

proptest! {
    #[test]
    fn no_bytes_break_a_reader(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        checks::mission_file(&bytes);
        checks::tlog(&bytes);
        checks::connection_string(&bytes);
        checks::mavlink_frames(&bytes);
    }
}

fn frames() -> Vec<u8> {
    let mut autopilot = Encoder::new(1, 1);
    let mut node = Encoder::new(4, 191);
    let mut out = Vec::new();
    for (id, payload) in [
        (0, &[4, 0, 0, 0, 2, 3, 81, 4, 3][..]),
        (33, &[9; 28]),
        (253, b"\x06PreArm: Compass not calibrated"),
        (77, &[22, 0, 0]),
    ] {
        out.extend_from_slice(autopilot.encode_payload(id, payload).unwrap().bytes());
        out.extend_from_slice(node.encode_payload(84, &[5; 53]).unwrap().bytes());
    }
    out.extend_from_slice(node.encode_payload(248, &[0x56, 0xC0, 0, 0, 0, 1, 2, 3, 4]).unwrap().bytes());
    out
}

fn tlog() -> Vec<u8> {
    let time = 1_790_000_000_000_000u64;
    let mut out = Vec::new();
    let bytes = frames();
    let mut reader = sitl_bridge::frame::Reader::new(sitl_bridge::frame::Source::Datagrams);
    reader.push(&bytes);
    while let Some(frame) = reader.next_frame() {
        out.extend((time + out.len() as u64 * 1000).to_be_bytes());
        out.extend_from_slice(frame.bytes());
    }
    out
}

/// `COVEY_BLESS=1 cargo test -p sitl-bridge --test files` writes the first inputs anew, from which the fuzzer starts.
#[test]
fn seeds_are_what_this_code_writes() {
    let toml = "origin = { lat = 47.4, lon = 8.5, alt_m = 400.0 }\npois_u = [[1, 2], [3, 4]]\npois_lat_lon = [[47.401, 8.501]]\n\
        [altitude]\nlayers = 3\n[fence]\npolygon_u = [[0,0],[90,0],[90,90]]\n";
    let geojson = r#"{"type":"FeatureCollection","covey":{"origin":{"lat":47.4,"lon":8.5,"alt_m":400}},"features":[{"type":"Feature",
        "geometry":{"type":"Polygon","coordinates":[[[8.4995,47.3995],[8.508,47.3995],[8.508,47.406],[8.4995,47.3995]]]}},
        {"type":"Feature","geometry":{"type":"GeometryCollection","geometries":[{"type":"MultiPoint","coordinates":[[368.501,47.401]]}]}}]}"#;
    let kml = "<kml><Placemark><name>a</name><MultiGeometry><Point><coordinates>8.501,47.401,3</coordinates></Point><Polygon>\
        <outerBoundaryIs><LinearRing><coordinates>8.5,47.4 8.51,47.4 8.51,47.41</coordinates></LinearRing></outerBoundaryIs></Polygon>\
        </MultiGeometry></Placemark></kml>";
    let plan = r#"{"fileType":"Plan","geoFence":{"polygons":[],"circles":[{"circle":{"center":[47.4,8.5],"radius":150}}]},
        "mission":{"plannedHomePosition":[47.4,8.5,400],"items":[{"type":"SimpleItem","command":16,"params":[0,0,0,null,47.4,8.5,9]}]}}"#;
    let list = "QGC WPL 110\n0 1 0 16 0 0 0 0 47.4 8.5 400 1\n1 0 3 16 0 0 0 0 47.401 8.501 20 1\n2 0 0 5001 3 0 0 0 47.4 8.5 0 1\n";
    // The first byte chooses the name.
    let named = |kind: u8, text: &str| [&[kind], text.as_bytes()].concat();
    let seeds = [
        ("mission_file", "toml", named(0, toml)),
        ("mission_file", "geojson", named(1, geojson)),
        ("mission_file", "kml", named(2, kml)),
        ("mission_file", "csv", named(3, "name;lat;lng\n\"a;b\";47.4;8.5\nc;47.401;8.501\n")),
        ("mission_file", "plan", named(4, plan)),
        ("mission_file", "waypoints", named(5, list)),
        ("mission_file", "utf-16", [&[0, 0xFF, 0xFE][..], &[b'a', 0, b'=', 0]].concat()),
        ("tlog", "flight", tlog()),
        ("tlog", "stream", frames()),
        ("connection_string", "udpin", b"udpin:0.0.0.0:14550".to_vec()),
        ("connection_string", "serial", b"serial:/dev/ttyACM0:57600".to_vec()),
        ("connection_string", "tcp6", b"tcp://[::1]:5760".to_vec()),
        ("connection_string", "multicast", b"multicast:239.86.67.1:14600".to_vec()),
        ("connection_string", "peers", b"peers:0.0.0.0:14600,10.0.0.2:14600,10.0.0.3:14600".to_vec()),
        ("mavlink_frames", "traffic", frames()),
    ];
    for (target, name, bytes) in seeds {
        let path = corpus(target).join(name);
        if std::env::var_os("COVEY_BLESS").is_some() {
            fs::create_dir_all(corpus(target)).unwrap();
            fs::write(&path, &bytes).unwrap();
        }
        assert!(fs::read(&path).unwrap() == bytes, "{} differs", path.display());
    }
}
