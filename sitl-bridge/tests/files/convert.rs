//! `sitl-bridge mission check` and `convert`, as they are typed.

use super::{bridge, loaded, words};
use proptest::prelude::*;
use sitl_bridge::mission::{Draft, Given, Loaded};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::OsStringExt as _;
use std::path::{Path, PathBuf};
use std::process::Output;

fn mission(args: &[&OsStr]) -> Output {
    bridge(&[&[OsStr::new("mission")], args].concat())
}

/// A folder and a file in it, both with names that are not UTF-8.
fn odd(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join(OsString::from_vec(b"Fl\xFCge".to_vec()));
    fs::create_dir(&inner).unwrap();
    let path = inner.join(OsString::from_vec([b"\xE4", name.as_bytes()].concat()));
    fs::write(&path, bytes).unwrap();
    (folder, path)
}

#[test]
fn a_table_becomes_a_mission_that_is_checked_and_read() {
    let (_folder, input) = odd("points.csv", b"lat,lon\n47.401,8.501\n47.402,8.502\n");
    let output = input.with_extension("toml");
    let paths = [input.as_os_str(), output.as_os_str()];
    let said = words(&mission(&[&[OsStr::new("convert")], &paths[..]].concat()));
    assert!(said.contains("--alt-m METRES"), "{said}");
    let alt = ["--alt-m", "412.5"].map(OsStr::new);
    let made = mission(&[&[OsStr::new("convert")], &alt[..], &paths].concat());
    assert!(made.status.success(), "{}", words(&made));
    assert!(words(&made).contains("2 PoIs from CSV"), "{}", words(&made));
    let read = Loaded::read(&output).unwrap();
    assert_eq!((read.mission.pois.len(), read.mission.plane.alt_mm), (2, 412_500));
    // It is not written over, unless that is asked for.
    let again = mission(&[&[OsStr::new("convert")], &alt[..], &paths].concat());
    assert!(!again.status.success() && words(&again).contains("--force"), "{}", words(&again));
    let forced = mission(&[&[OsStr::new("convert"), OsStr::new("--force")], &alt[..], &paths].concat());
    assert!(forced.status.success(), "{}", words(&forced));
    let printed = mission(&[&[OsStr::new("convert")], &alt[..], &[input.as_os_str(), OsStr::new("-")]].concat());
    assert_eq!(loaded("m.toml", &printed.stdout).0, read.mission);
    let checked = mission(&[OsStr::new("check"), output.as_os_str()]);
    let text = String::from_utf8_lossy(&checked.stdout);
    assert!(checked.status.success() && text.contains("2 PoIs from TOML") && text.contains("no warnings"), "{text}");
    let json = mission(&[OsStr::new("check"), OsStr::new("--json"), output.as_os_str()]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((json["pois"].as_u64(), json["hash"].as_str().map(str::len)), (Some(2), Some(64)));
}

#[test]
fn warnings_are_told_wherever_a_mission_is_read() {
    let text = "origin = { lat = 47.4, lon = 8.5, alt_m = 400.0 }\npois_u = [[1, 2], [1, 2], [300, 1]]\n";
    let (_folder, path) = odd("m.toml", text.as_bytes());
    let checked = mission(&[OsStr::new("check"), path.as_os_str()]);
    let said = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(
        said.contains("warning: 1 of 3 PoIs lies beyond the map") && said.contains("warning: 1 of 2 PoIs lies where"),
        "{said}"
    );
    let made = mission(&[OsStr::new("convert"), path.as_os_str(), OsStr::new("-")]);
    assert!(words(&made).contains("lies beyond the map"), "{}", words(&made));
    // `fly` says them before it opens its links; this one cannot be opened.
    let args = ["fly", "--id", "1", "--autopilot", "serial:/nowhere/tty", "--mission"].map(OsStr::new);
    let flown = bridge(&[&args[..], &[path.as_os_str()]].concat());
    assert!(words(&flown).contains("lies beyond the map"), "{}", words(&flown));
    let args = ["swarm", "--count", "1", "--autopilot", "serial:/nowhere/tty", "--mission"].map(OsStr::new);
    let flown = bridge(&[&args[..], &[path.as_os_str()]].concat());
    assert!(words(&flown).contains("lies beyond the map"), "{}", words(&flown));
}

#[test]
fn a_world_is_written_as_before() {
    let written = mission(&["--world", "3"].map(OsStr::new));
    assert!(written.status.success());
    let (mission, remarks) = loaded("m.toml", written.stdout);
    assert_eq!((mission.pois.len(), remarks.as_str()), (120, ""));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn what_is_converted_reads_as_the_same_mission(
        places in prop::collection::vec((-0.01f64..0.01, -0.01f64..0.01), 1..30),
        (lat, lon, alt_m) in (-79.0f64..79.0, -180.0f64..180.0, -400.0f64..8000.0),
        (scale_m, layers, seed) in (0.5f64..20.0, 1u16..40, any::<u64>()),
        form in 0usize..4,
    ) {
        let places: Vec<_> = places.iter().map(|(north, east)| (lat + north, lon + east)).collect();
        let each = |write: &dyn Fn(f64, f64) -> String, between: &str| {
            places.iter().map(|&(lat, lon)| write(lat, lon)).collect::<Vec<_>>().join(between)
        };
        let (name, text) = match form {
            0 => ("a.csv", format!("lat,lon\n{}\n", each(&|lat, lon| format!("{lat},{lon}"), "\n"))),
            1 => {
                let placemark = |lat, lon| format!("<Placemark><Point><coordinates>{lon},{lat}</coordinates></Point></Placemark>");
                ("a.kml", format!("<kml>{}</kml>", each(&placemark, "")))
            }
            2 => {
                let points = each(&|lat, lon| format!("[{lon:?}, {lat:?}]"), ",");
                ("a.geojson", format!(r#"{{"type": "MultiPoint", "coordinates": [{points}]}}"#))
            }
            _ => ("a.waypoints", format!("QGC WPL 110\n{}", each(&|lat, lon| format!("7 0 3 16 0 0 0 0 {lat} {lon} 0 1\n"), ""))),
        };
        let mut draft = Draft::from_bytes(text.as_bytes(), Path::new(name)).map_err(|e| TestCaseError::fail(e.to_string()))?;
        draft.fill(&Given { alt_m: Some(alt_m), scale_m: Some(scale_m), layers: Some(layers), policy_seed: Some(seed), ..Given::default() });
        let read = draft.finish().map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert_eq!(read.mission.pois.len(), places.len());
        let again = loaded("m.toml", read.mission.to_toml("a\nb")).0;
        prop_assert_eq!(again.hash(), read.mission.hash());
        prop_assert_eq!(again, read.mission);
    }
}
