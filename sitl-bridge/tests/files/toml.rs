//! Missions in TOML.

use super::{load, loaded, refused, utf16};
use firmware_core::geometry::Vec2;
use sitl_bridge::mission::Scale;

const SOUND: &str = "origin = { lat = 47.4, lon = 8.5, alt_m = 400.0 }\npois_u = [[1.0, 2.0], [3, 4]]\n";

#[test]
fn what_is_left_out_has_the_scenarios_values() {
    let (m, remarks) = loaded("m.toml", SOUND);
    assert_eq!((m.scale, m.side_u, m.policy_seed), (Scale { unit_m: 2.5, step_ms: 2000 }, 200.0, 10));
    assert_eq!(m.half_side(), covey_env::Scenario::default().half_side_ticks());
    assert_eq!(m.pois, [Vec2 { x: 1024, y: 2048 }, Vec2 { x: 3072, y: 4096 }]);
    assert_eq!(m.fence[0], Vec2 { x: -10_240, y: -10_240 });
    assert_eq!(remarks, "");
}

#[test]
fn errors_name_the_field_the_line_and_the_way_out() {
    for (line, parts) in [
        ("speed = 3", &["line 3", "unknown field `speed`", "scale_m"][..]),
        ("scale_m = -1.0", &["m.toml, line 3", "scale_m = -1; use 0.1 to 100"]),
        ("scale_m = nan", &["line 3", "scale_m = NaN"]),
        ("scale_m = \"wide\"", &["line 3", "expected f64"]),
        ("step_ms = 70000", &["line 3", "u16"]),
        ("step_ms = 50", &["line 3", "use 200 to 32767"]),
        ("\n[altitude]\nlayers = 0", &["line 5", "altitude.layers = 0; use 1 to 1000"]),
        ("[altitude]\nbase_m = 400.0\nspacing_m = 90.0", &["puts the highest layer at 2110 m"]),
        ("[fence]\nmargin_u = 3.0\npolygon_u = [[0,0],[1,0],[1,1]]", &["line 3", "more than one form"]),
        ("[fence]\npolygon_u = [[0,0],[1,0],[0,0]]", &["line 4", "3 to 16 corners, not 2"]),
        (
            "[fence]\npolygon_u = [[0,0],[50,50],[50,0],[0,50]]",
            &["line 4", "the edges after corners 0 and 2 touch or cross"],
        ),
        ("[fence]\npolygon_u = [[0,0],[0,0],[50,50],[50,0],[0,50]]", &["after corners 0 and 3 touch or cross"]),
        ("[fence]\npolygon_u = [[0,0],[100,1],[100,2]]", &["line 4", "corner 0 is sharper than 30°"]),
        ("[fence]\npolygon_lat_lon = [[47.4,8.5],[8.51,47.41],[47.41,8.5]]", &["line 4", "are swapped"]),
        ("pois_lat_lon = [\n [47.4, 8.5],\n [8.5, 47.4]]", &["line 5", "pois_lat_lon[1]", "the latitude comes first"]),
        ("pois_lat_lon = [[147.4, 8.5]]", &["line 3", "pois_lat_lon[0]", "swapped"]),
        ("pois_lat_lon = [[48.4, 8.5]]", &["line 3", "111 km from the origin"]),
        ("pois_lat_lon = [[5251234.0, 690123.0]]", &["line 3", "EPSG:4326"]),
        ("pois_lat_lon = [[nan, 8.5]]", &["line 3", "that is no number"]),
        ("side_u = 16000.0", &["line 3", "40000 m; use 10000 m at most"]),
        ("a = 'x", &["line 3"]),
    ] {
        let message = refused("m.toml", format!("{SOUND}{line}"));
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?}");
        }
    }
    assert!(refused("m.toml", "pois_u = [[1, 2]]").contains("missing field `origin`"));
    assert!(refused("m.toml", "pois_u = [[1, 2]]").contains("origin = { lat = "));
    assert!(refused("m.toml", SOUND.replace("8.5", "9999.5")).contains("line 1: origin.lon is the longitude 9999.5"));
    let (turned, said) = loaded("m.toml", SOUND.replace("8.5", "368.5"));
    assert_eq!((turned, said.as_str()), (loaded("m.toml", SOUND).0, "note: origin.lon: 368.5 is 8.5"));
    let long = refused("m.toml", format!("a = [{}", "1, ".repeat(1000)));
    assert!(long.contains("TOML parse error at line 1") && long.len() < 300, "{long}");
    assert!(refused("m.toml", SOUND.replace("pois_u", "# ")).contains("both empty"));
    assert!(refused("m.toml", SOUND.replace("[3, 4]", "[3, nan]")).contains("pois_u[1] is at (3, NaN) u"));
    let swapped = SOUND.replace("lat = 47.4, lon = 8.5", "lat = 8.5, lon = 47.4") + "pois_lat_lon = [[47.401, 8.501]]";
    assert!(refused("m.toml", swapped).contains("swapped, here or in the origin"));
}

#[test]
fn places_in_degrees_are_laid_on_the_map() {
    let text = "origin = { lat = 47.4, lon = 8.5, alt_m = 400.0 }\npois_lat_lon = [[47.401, 8.501]]\n\
        [fence]\npolygon_lat_lon = [[47.4, 8.5], [47.4, 8.51], [47.41, 8.51], [47.4, 8.5]]";
    let (m, _) = loaded("m.toml", text);
    let (x, y) = m.pois[0].to_u();
    // 0.001 degrees: 111.32 m north and 75.35 m east, at 2.5 m a unit.
    assert!((x - 30.14).abs() < 0.02 && (y - 44.53).abs() < 0.02, "{x} {y}");
    assert_eq!((m.fence.len(), m.fence[0]), (3, Vec2::default()));
}

#[test]
fn whatever_the_editor_saved_is_read_or_named() {
    let plain = loaded("m.toml", SOUND).0;
    assert_eq!(loaded("m.toml", format!("\u{feff}{SOUND}")).0, plain);
    assert_eq!(loaded("m.toml", SOUND.replace('\n', "\r\n")).0, plain);
    assert_eq!(loaded("m.txt", SOUND).0, plain, "content tells");
    assert_eq!(loaded("mission", SOUND).0, plain);
    for (big, mark) in [(false, true), (true, true), (false, false), (true, false)] {
        let said = refused("m.toml", utf16(SOUND, big, mark));
        assert!(said.contains("is UTF-16") && said.contains("save it as UTF-8") && said.contains("iconv"), "{said}");
    }
    let latin1 = [b"# Z\xFCrich\n", SOUND.as_bytes()].concat();
    let said = refused("m.toml", latin1);
    assert!(said.contains("line 1, column 4") && said.contains("Latin-1"), "{said}");
    assert!(refused("m.toml", "").contains("is empty"));
    assert!(refused("m.toml", [SOUND.as_bytes(), &[0; 100]].concat()).contains("zero bytes"));
}

#[test]
fn pois_that_no_uav_covers_are_told() {
    let (m, said) = loaded("m.toml", SOUND.replace("[3, 4]", "[3, 400], [-1, 3], [3, -1], [500, 500]"));
    assert_eq!(m.pois.len(), 1);
    let expected = "warning: 4 of 5 PoIs lie beyond the map of 0 to 200 u and left out: pois_u[1] at (3.0, 400.0) u, pois_u[2] at \
        (-1.0, 3.0) u, pois_u[3] at (3.0, -1.0) u, and 1 more";
    assert_eq!(said, expected);
    let all = refused("m.toml", SOUND.replace("[1.0, 2.0], [3, 4]", "[3, 400]"));
    assert!(
        all.contains("line 2: its only PoI lies outside the map") && all.contains("pois_u[0] is at (3.0, 400.0)"),
        "{all}"
    );
    let fence = "[fence]\npolygon_u = [[0,0],[100,0],[100,100],[0,100]]";
    let (m, said) = loaded("m.toml", SOUND.replace("[3, 4]", "[105, 50], [150, 50], [150, 50]") + fence);
    assert_eq!(m.pois.len(), 4);
    assert!(said.contains("3 of 4 PoIs lie outside the fence") && said.contains("1 of them can be covered"), "{said}");
    assert!(said.contains("1 of 4 PoIs lies where another does, and each counts: pois_u[3] as pois_u[2]"), "{said}");
    // So small a unit that the coverage range is shorter than what the gate keeps from the fence.
    let tiny = format!("scale_m = 0.2\nside_u = 200.0\n{SOUND}[fence]\nmargin_u = 0.0");
    let (_, said) = loaded("m.toml", tiny);
    assert!(said.contains("so near to the fence that no UAV can cover them: the safety gate keeps 3 m"), "{said}");
    assert!(load("m.toml", SOUND.replace("pois_u = ", "pois_u = [[0, 0]] #")).is_ok(), "the corner is on the map");
}
