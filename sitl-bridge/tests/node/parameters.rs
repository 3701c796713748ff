//! What the autopilot's parameters cost is told, and refused with `--strict`.

use crate::commands;
use crate::flight::{Flight, mission, settings};
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::{Firmware, Speeds, Stage, left_standing_m};
use sitl_bridge::frame::Encoder;
use sitl_bridge::messages::mav_cmd;
use sitl_bridge::node::{OperatorCommand, Settings};

const ARDUPILOT: Firmware = Firmware::ArduPilot;
const PX4: Firmware = Firmware::Px4;

/// Names and values of parameters.
type Values = &'static [(&'static str, f32)];

/// Values that cost something, and how the warning begins. The UAV's layer is 12 m above home and it sends as
/// system 6.
const COSTS: &[(Firmware, Values, &str)] = &[
    (ARDUPILOT, &[("GUID_TIMEOUT", 3.0)], "GUID_TIMEOUT is 3: after the node dies the vehicle goes on for up to 22 m"),
    (ARDUPILOT, &[("GUID_TIMEOUT", 0.2)], "GUID_TIMEOUT is 0.2: the vehicle brakes whenever two setpoints are late"),
    (ARDUPILOT, &[("FS_GCS_ENABLE", 0.0)], "FS_GCS_ENABLE is 0: nothing happens when the node dies"),
    (
        ARDUPILOT,
        &[("MAV_GCS_SYSID", 255.0), ("MAV_GCS_SYSID_HI", 0.0)],
        "MAV_GCS_SYSID is 255: heartbeats of this node, which sends as system 6, do not count: nothing happens when it \
         dies. Set it to 6, or start with --system 255",
    ),
    (ARDUPILOT, &[("MAV_GCS_SYSID", 1.0), ("MAV_GCS_SYSID_HI", 5.0)], "MAV_GCS_SYSID is 1: heartbeats of this node"),
    (
        ARDUPILOT,
        &[("RTL_ALT_M", 15.0)],
        "RTL_ALT_M is 15: on a return this vehicle climbs from its layer, 12 m above home, to 15 m",
    ),
    (ARDUPILOT, &[("FENCE_ENABLE", 0.0)], "FENCE_ENABLE is 0: the autopilot has no fence of its own"),
    (ARDUPILOT, &[("FENCE_ACTION", 0.0)], "FENCE_ACTION is 0: the autopilot only tells of its own fence"),
    (
        ARDUPILOT,
        &[("FENCE_ALT_MAX", 10.0)],
        "FENCE_ALT_MAX is 10: the autopilot's own fence ends below this vehicle's layer, 12 m above home",
    ),
    (PX4, &[("COM_OF_LOSS_T", 3.0)], "COM_OF_LOSS_T is 3: after the node dies the vehicle goes on for up to 22 m"),
    (
        PX4,
        &[("COM_OBL_RC_ACT", 0.0)],
        "COM_OBL_RC_ACT is 0: when setpoints cease the autopilot changes to Position mode",
    ),
    (PX4, &[("COM_OBL_RC_ACT", 7.0)], "COM_OBL_RC_ACT is 7: when setpoints cease the motors are stopped"),
    (
        PX4,
        &[("NAV_DLL_ACT", 0.0)],
        "NAV_DLL_ACT is 0: when node and ground station are lost nothing brings the vehicle home",
    ),
    (PX4, &[("NAV_DLL_ACT", 6.0)], "NAV_DLL_ACT is 6: when the ground station is lost the motors are stopped"),
    (PX4, &[("RTL_RETURN_ALT", 60.0)], "RTL_RETURN_ALT is 60: on a return this vehicle climbs from its layer, 12 m"),
    (PX4, &[("GF_ACTION", 1.0)], "GF_ACTION is 1: the autopilot only tells of its own fence"),
];

/// Values that cost nothing.
const HARMLESS: &[(Firmware, Values)] = &[
    (ARDUPILOT, &[]),
    (ARDUPILOT, &[("GUID_TIMEOUT", 0.6)]),
    (ARDUPILOT, &[("FS_GCS_ENABLE", 5.0)]),
    (ARDUPILOT, &[("MAV_GCS_SYSID", 6.0), ("MAV_GCS_SYSID_HI", 0.0)]),
    (ARDUPILOT, &[("RTL_ALT_M", 0.0)]),
    (ARDUPILOT, &[("RTL_ALT_M", 12.0)]),
    (ARDUPILOT, &[("FENCE_ALT_MAX", 10.0), ("FENCE_TYPE", 6.0)]),
    (PX4, &[]),
    (PX4, &[("COM_OBL_RC_ACT", 3.0)]),
    (PX4, &[("NAV_DLL_ACT", 1.0)]),
];

fn with(firmware: Firmware, values: &[(&'static str, f32)], strict: bool) -> Flight {
    let mission = mission();
    let settings = Settings { strict, ..settings(5, &mission, true) };
    let mut flight = Flight::with(settings, firmware, Vec2::from_u(100.0, 100.0));
    flight.vehicle.parameters.extend(values.iter().copied());
    flight
}

fn warnings(flight: &Flight) -> Vec<&str> {
    flight.notices.iter().filter(|notice| notice.warning).map(|notice| notice.text.as_str()).collect()
}

/// Refused before anything was commanded; `words` say why.
fn assert_refused(flight: &mut Flight, words: &str) {
    assert!(flight.until(20, |f| f.node.stage() == Stage::Failed), "{words}: {:?}", flight.words());
    assert!(flight.said("not flying: --strict: ") && flight.said(words), "{words}: {:?}", flight.words());
    flight.ticks(50);
    assert!(commands(&flight.vehicle).is_empty() && !flight.vehicle.armed, "{words}");
}

#[test]
fn each_value_that_costs_something_is_told_once_and_does_not_hinder_the_flight() {
    for &(firmware, values, words) in COSTS {
        let mut flight = with(firmware, values, false);
        assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{values:?}: {:?}", flight.words());
        flight.ticks(50);
        let told = warnings(&flight);
        assert!(told.len() == 1 && told[0].starts_with(words), "{values:?}: {told:?}");
    }
}

#[test]
fn a_height_above_home_that_wavers_is_told_once() {
    let mut flight = with(ARDUPILOT, &[("RTL_ALT_M", 15.0)], false);
    for tick in 0..150 {
        flight.vehicle.home_mm = if tick % 10 < 5 { 900.0 } else { 0.0 };
        flight.tick();
    }
    assert_eq!(warnings(&flight).len(), 1, "{:?}", warnings(&flight));
}

#[test]
fn a_strict_start_is_refused_with_the_same_words() {
    for &(firmware, values, words) in COSTS {
        let mut flight = with(firmware, values, true);
        assert_refused(&mut flight, &format!("--strict: {words}"));
        // Mended, it starts.
        flight.vehicle.parameters = with(firmware, &[], true).vehicle.parameters;
        flight.node.command(OperatorCommand::Start);
        assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{values:?}: {:?}", flight.words());
    }
}

#[test]
fn values_that_cost_nothing_are_not_spoken_of() {
    for &(firmware, values) in HARMLESS {
        let mut flight = with(firmware, values, true);
        assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{values:?}: {:?}", flight.words());
        assert!(warnings(&flight).is_empty(), "{values:?}: {:?}", warnings(&flight));
    }
}

#[test]
fn older_names_do_as_well() {
    for (value, is_told) in [(1500.0, true), (500.0, false)] {
        let mut flight = with(ARDUPILOT, &[("RTL_ALT", value), ("SYSID_MYGCS", 6.0)], false);
        for newer in ["RTL_ALT_M", "MAV_GCS_SYSID", "MAV_GCS_SYSID_HI"] {
            flight.vehicle.parameters.remove(newer);
        }
        assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
        assert_eq!(flight.said("RTL_ALT is 1500: on a return"), is_told, "{:?}", flight.words());
        assert_eq!(warnings(&flight).len(), usize::from(is_told), "{:?}", flight.words());
    }
}

#[test]
fn a_parameter_that_is_not_told_is_said_and_asked_for_a_few_times() {
    let needed: [(Firmware, &[&str]); 2] = [
        (ARDUPILOT, &["GUID_TIMEOUT", "FS_GCS_ENABLE", "MAV_GCS_SYSID", "RTL_ALT_M", "FENCE_ENABLE"]),
        (PX4, &["COM_OF_LOSS_T", "COM_OBL_RC_ACT", "NAV_DLL_ACT", "RTL_RETURN_ALT", "GF_ACTION"]),
    ];
    for (firmware, names) in needed {
        for name in names {
            let words = format!("the autopilot does not tell its {name}: unknown is ");
            let mut flight = with(firmware, &[], false);
            flight.vehicle.parameters.remove(name);
            assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{name}: {:?}", flight.words());
            flight.ticks(100);
            assert!(flight.said(&words), "{name}: {:?}", flight.words());
            assert_eq!(flight.vehicle.asked_for.iter().filter(|asked| asked == name).count(), 4);
            let mut flight = with(firmware, &[], true);
            flight.vehicle.parameters.remove(name);
            assert_refused(&mut flight, &words);
        }
    }
}

#[test]
fn an_autopilot_without_the_protocol_is_brought_up_as_fast_as_another() {
    for firmware in [ARDUPILOT, PX4] {
        let seconds = |silent: bool| {
            let mut flight = with(firmware, &[], false);
            let began = flight.vehicle.boot_ms;
            if silent {
                flight.vehicle.parameters.clear();
            }
            assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
            flight.vehicle.boot_ms - began
        };
        assert_eq!(seconds(true), seconds(false));
    }
}

#[test]
fn orders_do_not_wait_for_parameters() {
    let mut flight = with(ARDUPILOT, &[], false);
    flight.vehicle.parameters.clear();
    (flight.vehicle.armed, flight.vehicle.custom_mode, flight.vehicle.height_mm) = (true, 4, 12_000.0);
    flight.ticks(2);
    flight.node.command(OperatorCommand::Land);
    flight.ticks(1);
    assert_eq!(flight.vehicle.commands.last().map(|c| c.0), Some(mav_cmd::DO_SET_MODE), "{:?}", flight.words());
}

#[test]
fn parameters_of_others_are_not_taken_for_the_vehicles() {
    let mut flight = with(ARDUPILOT, &[], true);
    flight.ticks(3);
    for from in [(9, 1), (7, 100)] {
        let mut payload = [&3f32.to_le_bytes()[..], &[0; 4], b"GUID_TIMEOUT"].concat();
        payload.resize(24, 0);
        payload.push(9);
        flight.hear_autopilot(&Encoder::new(from.0, from.1).encode_payload(22, &payload).unwrap());
    }
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
    assert!(warnings(&flight).is_empty(), "{:?}", flight.words());
}

#[test]
fn a_value_that_changes_in_flight_is_told_and_ends_nothing() {
    let mut flight = with(ARDUPILOT, &[], true);
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
    let changed = flight.vehicle.parameter("FS_GCS_ENABLE", 0.0);
    flight.hear_autopilot(&changed);
    flight.ticks(20);
    assert!(flight.said("FS_GCS_ENABLE is 0"), "{:?}", flight.words());
    assert_eq!(flight.node.stage(), Stage::Flying);
    assert!(!flight.decisions.is_empty() || flight.until(10, |f| !f.decisions.is_empty()));
}

#[test]
fn a_pilots_own_takeoff_is_not_flown_on_from_when_a_strict_start_is_refused() {
    let settings = Settings { strict: true, ..settings(5, &mission(), false) };
    let mut flight = Flight::with(settings, ARDUPILOT, Vec2::from_u(100.0, 100.0));
    flight.vehicle.parameters.insert("FS_GCS_ENABLE", 0.0);
    (flight.vehicle.armed, flight.vehicle.custom_mode, flight.vehicle.height_mm) = (true, 4, 12_000.0);
    flight.ticks(100);
    assert!(flight.said("not flying: --strict: FS_GCS_ENABLE is 0"), "{:?}", flight.words());
    assert!(flight.vehicle.setpoints.is_empty() && commands(&flight.vehicle).is_empty());
}

#[test]
fn the_distance_that_is_told_is_no_shorter_than_the_model_gives() {
    let speeds = Speeds { speed_mps: 5.0, acceleration_mps2: 2.5 };
    // Within the bounds of docs/safety.md.
    assert!((10.0..=12.0).contains(&left_standing_m(1.0, speeds)));
    assert!((21.0..=25.0).contains(&left_standing_m(3.0, speeds)));
    let all: Vec<f64> = (1..=50).map(|tenths| left_standing_m(f64::from(tenths) / 10.0, speeds)).collect();
    assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
}
