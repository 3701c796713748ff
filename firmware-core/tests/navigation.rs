//! Degrees, metres, ticks and headings.

use core::f64::consts::TAU;
use firmware_core::geometry::{TICKS_PER_U, Vec2};
use firmware_core::navigation::{
    HEADING_ERROR_RAD, LATITUDE_LIMIT_E7, LocalFrame, LocalPosition, MapScale, REACH_MM, degrees_to_e7,
    heading_centidegrees, heading_rad,
};
use proptest::prelude::*;

const SCALE: MapScale = MapScale { unit_m: 2.5, step_ms: 2000 };

fn latitude() -> impl Strategy<Value = i32> {
    -LATITUDE_LIMIT_E7..=LATITUDE_LIMIT_E7
}

fn longitude() -> impl Strategy<Value = i32> {
    -1_800_000_000..=1_800_000_000
}

/// A longitude as it is written on the other side of the date line.
fn within_a_turn(lon_e7: i32) -> i32 {
    match lon_e7 {
        1_800_000_001.. => (i64::from(lon_e7) - 3_600_000_000) as i32,
        ..=-1_800_000_001 => (i64::from(lon_e7) + 3_600_000_000) as i32,
        _ => lon_e7,
    }
}

/// How far two headings are apart, the short way round.
fn apart(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(TAU);
    d.min(TAU - d)
}

proptest! {
    #[test]
    fn degrees_come_back_to_the_unit(lat in latitude(), lon in longitude(), north in -1_000_000..1_000_000, east in -1_000_000..1_000_000) {
        let frame = LocalFrame::new(lat, lon).unwrap();
        let (lat, lon) = (lat + north, within_a_turn(lon + east));
        let place = frame.local(lat, lon).unwrap();
        prop_assert_eq!(frame.geodetic_e7(place), (lat, lon));
    }

    #[test]
    fn a_place_comes_back_within_a_grain(lat in latitude(), lon in longitude(), east_mm in -1e6f64..1e6, north_mm in -1e6f64..1e6) {
        let frame = LocalFrame::new(lat, lon).unwrap();
        let (a, b) = frame.geodetic_e7(LocalPosition { east_mm, north_mm });
        let back = frame.local(a, b).unwrap();
        // A grain is 1e-7 degrees, 11.2 mm at most; half of it is the most that rounding takes.
        prop_assert!((back.east_mm - east_mm).abs() < 5.7 && (back.north_mm - north_mm).abs() < 5.7);
    }

    /// The same on every target, so libm's cosine, which is the system's to the last bit or next to it.
    #[test]
    fn the_scale_of_longitudes_is_the_cosine(lat in latitude()) {
        let place = LocalFrame::new(lat, 0).unwrap().local(lat, 1_000_000).unwrap();
        let exact = 11.131_884_502_145_034 * (f64::from(lat) / 1e7).to_radians().cos() * 1e6;
        prop_assert!((place.east_mm - exact).abs() <= exact * 4.0 * f64::EPSILON);
    }

    #[test]
    fn ticks_survive_the_autopilots_metres(x in -300_000i32..300_000, y in -300_000i32..300_000, vx in -8192i32..8192) {
        // LOCAL_POSITION_NED speaks in f32 metres.
        let place = SCALE.place(Vec2 { x, y });
        let metres = [place.east_mm, place.north_mm].map(|mm| f64::from((mm / 1000.0) as f32));
        prop_assert_eq!(metres.map(|m| SCALE.ticks(m)), [x, y]);
        let mps = f64::from(SCALE.mps(vx as f32 / TICKS_PER_U as f32) as f32);
        prop_assert_eq!(SCALE.velocity(mps, -mps), Vec2 { x: vx, y: -vx });
    }

    #[test]
    fn a_heading_is_within_its_error(turn in 0.0..TAU, exponent in -30i32..30) {
        let length = 10f64.powi(exponent);
        let (east, north) = ((length * turn.sin()) as f32, (length * turn.cos()) as f32);
        let exact = libm::atan2(east.into(), north.into());
        let heading = f64::from(heading_rad(east, north).unwrap());
        prop_assert!((0.0..TAU).contains(&heading));
        prop_assert!(apart(heading, exact) <= f64::from(HEADING_ERROR_RAD), "{} for {}", heading, exact);
        let hundredths = heading_centidegrees(east, north).unwrap();
        prop_assert!(hundredths < 36_000);
        prop_assert!(apart(f64::from(hundredths) * TAU / 36_000.0, heading) <= 1.001 * TAU / 72_000.0);
    }

    #[test]
    fn any_bits_have_a_heading_or_none(east: u32, north: u32) {
        let (east, north) = (f32::from_bits(east), f32::from_bits(north));
        let length = east.is_finite() && north.is_finite() && (east != 0.0 || north != 0.0);
        prop_assert_eq!(heading_rad(east, north).is_some(), length);
        prop_assert!(heading_rad(east, north).is_none_or(|h| (0.0..core::f32::consts::TAU).contains(&h)));
    }
}

#[test]
fn the_error_bound_is_no_wider_than_it_must_be() {
    let worst = (0..100_000).map(|k| {
        let turn = f64::from(k) / 100_000.0 * TAU;
        let (east, north) = (turn.sin() as f32, turn.cos() as f32);
        apart(heading_rad(east, north).unwrap().into(), libm::atan2(east.into(), north.into()))
    });
    let worst = worst.fold(0.0, f64::max);
    assert!(worst > 0.9 * f64::from(HEADING_ERROR_RAD), "{worst}");
}

#[test]
fn the_points_of_the_compass() {
    for (east, north, hundredths) in [(0.0, 3.0, 0), (2.0, 0.0, 9000), (0.0, -1.0, 18_000), (-5.0, 0.0, 27_000)] {
        assert_eq!(heading_centidegrees(east, north), Some(hundredths));
    }
    assert_eq!(heading_centidegrees(1.0, 1.0), Some(4500));
    // A hair west of north is not a full turn.
    assert_eq!(heading_centidegrees(-1e-9, 1.0), Some(0));
    assert_eq!(heading_rad(0.0, 0.0), None);
    assert_eq!(heading_rad(f32::NAN, 1.0), None);
}

#[test]
fn metres_per_degree_are_those_of_the_equator() {
    // A degree of the globe is 111.32 km; at 60 degrees a degree of longitude is half of it.
    let place = LocalFrame::new(600_000_000, 0).unwrap().local(601_000_000, 1_000_000).unwrap();
    let (north, east) = (place.north_mm / 100.0, place.east_mm / 100.0);
    assert!((north - 111_318.8).abs() < 0.1 && (east - 55_659.4).abs() < 0.1, "{north} {east}");
}

#[test]
fn the_default_scale_is_the_scenarios() {
    assert_eq!(SCALE.mps(4.0), 5.0);
    assert_eq!(SCALE.mps2(4.0), 2.5);
    assert_eq!(SCALE.velocity(5.0, -2.5), Vec2 { x: 4096, y: -2048 });
}

#[test]
fn the_date_line_is_no_edge() {
    let frame = LocalFrame::new(degrees_to_e7(-16.8), degrees_to_e7(179.998)).unwrap();
    let place = frame.local(degrees_to_e7(-16.8), degrees_to_e7(-179.999)).unwrap();
    // 0.003 degrees of longitude at 16.8 degrees south.
    assert!((place.east_mm / 1000.0 - 319.7).abs() < 0.1 && place.north_mm == 0.0, "{place:?}");
    assert_eq!(frame.geodetic_e7(place), (degrees_to_e7(-16.8), degrees_to_e7(-179.999)));
    let west = LocalFrame::new(0, degrees_to_e7(-179.9995)).unwrap().local(0, degrees_to_e7(179.9995)).unwrap();
    assert!((west.east_mm / 1000.0 + 111.3).abs() < 0.1, "{west:?}");
}

#[test]
fn far_places_and_bad_origins_are_refused() {
    let frame = LocalFrame::new(degrees_to_e7(47.0), degrees_to_e7(8.0)).unwrap();
    assert_eq!(frame.origin_e7(), (470_000_000, 80_000_000));
    assert_eq!(frame.local(degrees_to_e7(47.3), degrees_to_e7(8.0)), None);
    assert_eq!(frame.local(i32::MIN, i32::MAX), None);
    assert!(frame.local(degrees_to_e7(47.1), degrees_to_e7(8.1)).is_some_and(|p| p.north_mm < REACH_MM));
    for (lat, lon) in [(800_000_001, 0), (i32::MIN, 0), (0, 1_800_000_001), (0, i32::MIN)] {
        assert_eq!(LocalFrame::new(lat, lon), None, "{lat} {lon}");
    }
}
