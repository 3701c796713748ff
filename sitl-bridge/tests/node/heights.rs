//! Heights: what is flown above home, what is believed, and how vehicles come to their layers.

use crate::commands;
use crate::flight::{Flight, mission, settings};
use firmware_core::gate::Reason;
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::mission::{Mission, Plane};

const FIRMWARES: [Firmware; 2] = [Firmware::ArduPilot, Firmware::Px4];

/// UAV 5, whose layer is 12 m above the origin, with its home so much above it.
fn from_home_at(home_m: f64, firmware: Firmware, take_off: bool, change: impl FnOnce(&mut Mission)) -> Flight {
    let mut mission = mission();
    change(&mut mission);
    let mut flight = Flight::with(settings(5, &mission, take_off), firmware, Vec2::from_u(100.0, 100.0));
    flight.vehicle.home_mm = home_m * 1000.0;
    flight
}

/// Nothing was commanded, and these words were said, as a warning.
fn assert_refused(flight: &mut Flight, words: &[&str]) {
    assert!(flight.until(30, |f| f.node.stage() == Stage::Failed), "{words:?}: {:?}", flight.words());
    flight.ticks(50);
    assert!(commands(&flight.vehicle).is_empty() && flight.vehicle.setpoints.is_empty(), "{words:?}");
    let said = |word: &str| flight.notices.iter().any(|n| n.warning && n.text.contains(word));
    assert!(words.iter().all(|word| said(word)), "{words:?}: {:?}", flight.words());
}

#[test]
fn a_layer_too_high_above_home_is_refused_before_arming_with_both_heights() {
    for firmware in FIRMWARES {
        // The origin's altitude in feet.
        let feet = |m: &mut Mission| m.plane = Plane::new(47.397_742, 8.545_594, 1601.0).unwrap();
        let mut flight = from_home_at(488.0 - 1601.0, firmware, true, feet);
        let words =
            ["not flying: its layer, 12.0 m above the mission's origin, is 1125.0 m above home", "120 m is the limit"];
        assert_refused(&mut flight, &words);
        assert!(flight.said("origin.alt_m = 1601") && flight.said("feet") && !flight.vehicle.armed);
    }
    let raised = |m: &mut Mission| (m.heights.highest_above_home_m, m.heights.home_within_m) = (150.0, 130.0);
    let mut flight = from_home_at(-123.0, Firmware::ArduPilot, true, raised);
    assert!(flight.until(200, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
    assert!((flight.vehicle.height_mm - 135_000.0).abs() < 1500.0);
}

#[test]
fn a_layer_at_or_under_the_ground_is_refused_before_arming() {
    for firmware in FIRMWARES {
        let mut flight = from_home_at(15.0, firmware, true, |_| {});
        assert_refused(&mut flight, &["is -3.0 m above home (503.0 m above sea level): at or under the ground"]);
        let mut flight = from_home_at(10.5, firmware, true, |_| {});
        assert_refused(&mut flight, &["is 1.5 m above home"]);
    }
}

#[test]
fn ground_at_another_height_than_the_missions_is_refused_unless_it_is_allowed() {
    for firmware in FIRMWARES {
        let mut flight = from_home_at(-48.0, firmware, true, |_| {});
        assert_refused(
            &mut flight,
            &["is 60.0 m above home: home lies 440.0 m above sea level, 48.0 m below", "20 m is"],
        );
        let mut flight = from_home_at(-48.0, firmware, true, |m| m.heights.home_within_m = 50.0);
        assert!(flight.until(90, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
        assert!((flight.vehicle.height_mm - 60_000.0).abs() < 1500.0);
    }
}

#[test]
fn a_vehicle_that_its_pilot_brought_up_is_not_led_to_such_a_layer_either() {
    for (home_m, guided) in [(-48.0, true), (-1113.0, true), (15.0, true), (-48.0, false)] {
        let mut flight = from_home_at(home_m, Firmware::ArduPilot, false, |_| {});
        (flight.vehicle.armed, flight.vehicle.height_mm) = (true, 20_000.0);
        flight.vehicle.custom_mode = if guided { 4 } else { 5 };
        flight.ticks(30);
        flight.vehicle.custom_mode = 4;
        assert_refused(&mut flight, &["not flying: its layer"]);
        assert!((flight.vehicle.height_mm - 20_000.0).abs() < 1.0);
    }
}

#[test]
fn a_vehicle_far_from_the_mission_is_told_of_with_the_distance() {
    for take_off in [true, false] {
        for (north_mm, words) in [(30e6, "30 km from the mission's origin"), (3e6, "from the middle of its map: carry")]
        {
            let mut flight = from_home_at(0.0, Firmware::ArduPilot, take_off, |_| {});
            flight.vehicle.place.north_mm = north_mm;
            flight.ticks(100);
            let told = flight.notices.iter().filter(|n| n.warning && n.text.contains(words)).count();
            let expected = usize::from(take_off || north_mm > 20e6);
            assert_eq!(told, expected, "{words} {take_off}: {:?}", flight.words());
            assert!(commands(&flight.vehicle).is_empty());
            // Carried there it flies.
            flight.vehicle.place.north_mm = 250_000.0;
            let flies = flight.until(60, |f| f.node.stage() == Stage::Flying);
            assert_eq!(flies, take_off, "{:?}", flight.words());
        }
    }
}

/// What goes wrong, and what is said of it.
type Cause = (fn(&mut Flight), &'static str);

#[test]
fn what_a_start_waits_for_is_told_while_the_gate_is_silent() {
    let causes: [Cause; 2] = [
        (|f| f.vehicle.healthy = false, "waiting for the estimator to trust its position"),
        (|f| f.vehicle.gps_fix = 1, "waiting for a 3D GPS fix"),
    ];
    for (cause, words) in causes {
        let mut flight = from_home_at(0.0, Firmware::ArduPilot, true, |_| {});
        cause(&mut flight);
        flight.ticks(100);
        let told = flight.notices.iter().filter(|n| n.text == words).count();
        assert!((1..=3).contains(&told), "{words}: {:?}", flight.words());
    }
}

#[test]
fn nobody_moves_sideways_before_it_is_on_its_layer() {
    for (firmware, height_m) in FIRMWARES.into_iter().flat_map(|f| [(f, 25.0), (f, 7.0)]) {
        let mut flight = from_home_at(0.0, firmware, false, |_| {});
        (flight.vehicle.armed, flight.vehicle.height_mm) = (true, height_m * 1000.0);
        flight.vehicle.custom_mode = if firmware == Firmware::Px4 { 6 << 16 } else { 4 };
        assert!(flight.until(30, |f| f.node.verdict().reason() == Some(Reason::OffLayer)), "{:?}", flight.words());
        while flight.node.verdict().reason() == Some(Reason::OffLayer) {
            assert_eq!(flight.vehicle.speed(), 0.0, "{firmware:?} at {} m", flight.vehicle.height_mm / 1000.0);
            flight.tick();
        }
        assert!((flight.vehicle.height_mm - 12_000.0).abs() < 1300.0, "{}", flight.vehicle.height_mm);
        assert!(flight.until(20, |f| f.vehicle.speed() > 0.5), "{:?}", flight.words());
    }
}

#[test]
fn heights_that_disagree_after_the_climb_hold_the_vehicle() {
    let flies = |f: &Flight| f.node.verdict().name() == "stream";
    for error_mm in [5000.0, 9000.0, -9000.0] {
        let mut flight = from_home_at(0.0, Firmware::ArduPilot, true, |_| {});
        flight.vehicle.gps_error_mm = error_mm;
        let doubted = flight.until(60, |f| f.node.verdict().reason() == Some(Reason::HeightDoubted));
        assert_eq!(doubted, error_mm.abs() > 7500.0, "{error_mm}: {:?}", flight.words());
        flight.ticks(50);
        assert_eq!(flies(&flight), !doubted);
        if doubted {
            let apart =
                |f: &Flight| f.said("the height is in doubt: ") && f.said(" m by the GPS; they may differ by 7.5 m");
            assert!(flight.vehicle.setpoints.iter().all(|s| s.velocity == [0.0; 2]), "it did not wait");
            assert!(apart(&flight), "{:?}", flight.words());
            // Once they agree, or the operator says so, it flies.
            if error_mm > 0.0 {
                flight.vehicle.gps_error_mm = 0.0;
            } else {
                flight.node.start();
            }
            assert!(flight.until(10, flies), "{:?}", flight.words());
        }
    }
}

#[test]
fn a_home_that_moves_in_the_climb_holds_the_vehicle() {
    let mut flight = from_home_at(0.0, Firmware::ArduPilot, true, |_| {});
    assert!(flight.until(60, |f| f.vehicle.height_mm > 8000.0));
    // Its altitude above the sea goes on as it was.
    (flight.vehicle.home_mm, flight.vehicle.height_mm) = (-10_000.0, flight.vehicle.height_mm + 10_000.0);
    flight.vehicle.move_target(10_000.0);
    let doubted = flight.until(60, |f| f.node.verdict().reason() == Some(Reason::HeightDoubted));
    assert!(doubted && flight.said("home was 488.0 m above sea level before the climb"), "{:?}", flight.words());
}
