//! Whose vehicle a node flies, who else is on the link, and what it believes of clocks.

use crate::flight::{Flight, mission, settings};
use crate::vehicle::Vehicle;
use crate::{commands, flying};
use firmware_core::gate::{Limits, Reason};
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::frame::{Encoder, Frame};
use sitl_bridge::messages::mav_cmd;
use sitl_bridge::node::{Settings, gate_limits};

/// HEARTBEAT of a component: MAV_TYPE and MAV_AUTOPILOT.
fn heartbeat(from: (u8, u8), kind: u8, autopilot: u8) -> Frame {
    let payload = [4, 0, 0, 0, kind, autopilot, 0x81, 4, 3];
    Encoder::new(from.0, from.1).encode_payload(0, &payload).unwrap()
}

fn ack(command: u16, result: u8, to: (u8, u8)) -> Frame {
    let command = command.to_le_bytes();
    let payload = [command[0], command[1], result, 0, 0, 0, 0, 0, to.0, to.1];
    Encoder::new(7, 1).encode_payload(77, &payload).unwrap()
}

/// Everybody whom MAVProxy may put on a port besides the vehicle.
fn others() -> [Frame; 6] {
    [
        heartbeat((9, 1), 2, 3),
        heartbeat((7, 100), 30, 3),
        heartbeat((7, 154), 26, 12),
        heartbeat((7, 191), 18, 8),
        heartbeat((7, 156), 27, 3),
        heartbeat((255, 190), 6, 8),
    ]
}

#[test]
fn other_vehicles_cameras_and_companions_are_never_flown() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    others().iter().for_each(|frame| flight.hear_autopilot(frame));
    assert_eq!(flight.node.stage(), Stage::Silent);
    // Every message is addressed to system 7: the scripted vehicle looks at it.
    for _ in 0..300 {
        flight.tick();
        others().iter().for_each(|frame| flight.hear_autopilot(frame));
    }
    assert_eq!(flight.node.stage(), Stage::Flying, "{:?}", flight.words());
    assert!(flight.said("waiting for the autopilot of system 7"));
}

#[test]
fn a_vehicle_with_another_id_is_named_and_not_commanded() {
    let mission = mission();
    let settings = Settings { vehicle_system: 1, ..settings(0, &mission, true) };
    let mut flight = Flight::with(settings, Firmware::ArduPilot, Vec2::from_u(100.0, 100.0));
    for _ in 0..100 {
        let frames = flight.vehicle.tick();
        flight.hear_all(&frames);
    }
    assert!(flight.said("heard system 7, waiting for system 1: --vehicle-system 7 flies that one"));
    assert!(flight.vehicle.commands.is_empty() && flight.vehicle.setpoints.is_empty());
    assert_eq!(flight.node.stage(), Stage::Silent);
}

#[test]
fn answers_to_others_are_not_taken_for_ones_own() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.vehicle.mute = true;
    flight.ticks(3);
    flight.hear_autopilot(&ack(mav_cmd::SET_MESSAGE_INTERVAL, 3, (255, 190)));
    assert!(!flight.said("does not take a rate"));
    flight.hear_autopilot(&ack(mav_cmd::SET_MESSAGE_INTERVAL, 3, (6, 191)));
    assert!(flight.said("does not take a rate for message 32"));
    flight.ticks(1);
    flight.hear_autopilot(&ack(mav_cmd::SET_MESSAGE_INTERVAL, 3, (0, 0)));
    assert!(flight.said("does not take a rate for message 33"));
}

#[test]
fn a_second_node_on_the_vehicle_is_told() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.hear_autopilot(&ack(mav_cmd::DO_SET_MODE, 0, (9, 191)));
    assert!(flight.said("two nodes must not fly one vehicle"));
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.hear_autopilot(&heartbeat((6, 191), 18, 8));
    assert!(flight.said("is a second node running for this vehicle?"));
}

#[test]
fn two_vehicles_with_one_id_are_refused() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    let mut twin = Vehicle::new(Firmware::ArduPilot, &mission(), Vec2::from_u(50.0, 50.0));
    twin.boot_ms += 100_000;
    for _ in 0..20 {
        let frames = [flight.vehicle.tick(), twin.tick()].concat();
        flight.hear_all(&frames);
    }
    assert!(flight.said("two vehicles send as system 7"), "{:?}", flight.words());
    assert_eq!(flight.node.stage(), Stage::Failed);
    assert!(commands(&flight.vehicle).is_empty(), "{:?}", commands(&flight.vehicle));
    // The other one is switched off.
    flight.node.start();
    assert!(flight.until(90, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
}

#[test]
fn after_a_reboot_the_rates_are_asked_for_again_and_it_can_start() {
    let mission = mission();
    let settings = Settings { limits: gate_limits(Limits::default(), &mission), ..settings(5, &mission, true) };
    let mut flight = Flight::with(settings, Firmware::ArduPilot, Vec2::from_u(100.0, 100.0));
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
    flight.ticks(50);
    flight.vehicle.reboot();
    let before = (commands(&flight.vehicle), flight.vehicle.setpoints.len());
    assert!(flight.until(30, |f| !f.vehicle.waits_for_rates), "{:?}", flight.words());
    assert!(flight.said("asking for the message rates again"));
    flight.ticks(50);
    let after = (commands(&flight.vehicle), flight.vehicle.setpoints.len());
    assert_eq!(after.0, before.0, "nothing but rates was commanded");
    // At most the setpoints until its heartbeat told of it.
    assert!(after.1 - before.1 <= 6, "{}", after.1 - before.1);
    flight.node.start();
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
}

#[test]
fn rates_that_are_of_no_use_are_not_asked_for_all_the_time() {
    let mut flight = Flight::with(
        Settings { limits: gate_limits(Limits::default(), &mission()), ..settings(5, &mission(), false) },
        Firmware::Px4,
        Vec2::from_u(100.0, 100.0),
    );
    // PX4 without a position sends none.
    flight.vehicle.without_positions = true;
    flight.ticks(600);
    // Two minutes: at 3, 9, 21, 45, 69 and 93 s, and at the start.
    assert!(flight.vehicle.commands.len() <= 9 * 8, "{}", flight.vehicle.commands.len());
    let told = flight.notices.iter().filter(|n| n.text.contains("message rates again")).count();
    assert_eq!(told, 1, "{:?}", flight.words());
}

#[test]
fn unix_time_that_runs_at_another_speed_holds_the_vehicle_and_is_told_once() {
    let mut flight = flying(5, Firmware::Px4);
    flight.ticks(60);
    flight.vehicle.unix_rate = 2.0;
    assert!(flight.until(15, |f| f.said("is the simulation's speed not 1?")), "{:?}", flight.words());
    assert!(flight.said("runs 2.00 times as fast"));
    flight.ticks(50);
    assert_eq!(flight.node.verdict().reason(), Some(Reason::NoDecision));
    let decisions = flight.decisions.len();
    flight.ticks(300);
    assert_eq!(flight.decisions.len(), decisions);
    let clock = flight.notices.iter().filter(|n| n.text.contains("clock")).count();
    assert!(clock <= 3, "{:?}", flight.words());
    // Back at speed 1 it flies on.
    flight.vehicle.unix_rate = 1.0;
    assert!(flight.until(60, |f| f.decisions.len() > decisions), "{:?}", flight.words());
}
