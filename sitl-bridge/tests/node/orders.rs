//! What the operator orders is never lost, and nobody's vehicle is taken.

use crate::flight::Flight;
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::messages::mav_cmd;
use sitl_bridge::node::OperatorCommand;

const FIRMWARES: [Firmware; 2] = [Firmware::ArduPilot, Firmware::Px4];

#[derive(Clone, Copy, Debug, PartialEq)]
enum When {
    /// Climbs by the autopilot's own takeoff.
    Climb,
    /// Flies decisions.
    Flight,
    /// Let go, and still in GUIDED.
    Released,
    /// The vehicle's clock leapt, and the gate let it go.
    ClockLeap,
}

const STAGES: [When; 4] = [When::Climb, When::Flight, When::Released, When::ClockLeap];

fn at(when: When, firmware: Firmware) -> Flight {
    let mut flight = Flight::new(5, firmware, true);
    let there = match when {
        When::Climb => flight.until(60, |f| (3000.0..9000.0).contains(&f.vehicle.height_mm)),
        _ => flight.until(90, |f| f.decisions.len() > 1),
    };
    assert!(there, "{when:?} {firmware:?}: {:?}", flight.words());
    match when {
        When::Climb | When::Flight => {}
        When::Released => {
            flight.node.command(OperatorCommand::Release);
            flight.ticks(20);
        }
        When::ClockLeap => {
            flight.vehicle.boot_ms += 60_000;
            flight.ticks(10);
        }
    }
    flight
}

fn mode_of(order: OperatorCommand, firmware: Firmware) -> u32 {
    match (order, firmware) {
        (OperatorCommand::Land, Firmware::ArduPilot) => 9,
        (OperatorCommand::Return, Firmware::ArduPilot) => 6,
        (OperatorCommand::Land, Firmware::Px4) => (6 << 24) | (4 << 16),
        (_, Firmware::Px4) => (5 << 24) | (4 << 16),
        (other, _) => panic!("{other:?} is no order"),
    }
}

#[test]
fn land_and_return_come_through_in_every_stage() {
    for firmware in FIRMWARES {
        for when in STAGES {
            for order in [OperatorCommand::Land, OperatorCommand::Return] {
                for mute in [false, true] {
                    let mut flight = at(when, firmware);
                    let before = flight.vehicle.setpoints.len();
                    flight.node.command(order);
                    flight.vehicle.mute = mute;
                    // Longer than all repetitions without an answer take.
                    flight.ticks(if mute { 100 } else { 0 });
                    flight.vehicle.mute = false;
                    let done = flight.until(5, |f| f.vehicle.custom_mode == mode_of(order, firmware));
                    assert!(done, "{order:?} {when:?} {firmware:?} mute {mute}: {:?}", flight.words());
                    flight.ticks(50);
                    assert_eq!(flight.vehicle.custom_mode, mode_of(order, firmware));
                    assert_eq!(flight.vehicle.setpoints.len(), before, "{order:?} {when:?} {firmware:?}");
                }
            }
        }
    }
}

#[test]
fn a_refused_landing_is_tried_on() {
    let mut flight = at(When::Flight, Firmware::ArduPilot);
    flight.vehicle.refuse = Some((mav_cmd::DO_SET_MODE, 4, "not now"));
    flight.node.command(OperatorCommand::Land);
    flight.ticks(300);
    assert!(flight.said("refused by the autopilot: not now"), "{:?}", flight.words());
    flight.vehicle.refuse = None;
    assert!(flight.until(5, |f| f.vehicle.custom_mode == 9), "{:?}", flight.words());
}

#[test]
fn a_release_in_the_climb_ends_the_bring_up_at_once() {
    for firmware in FIRMWARES {
        let mut flight = at(When::Climb, firmware);
        let (commands, mode) = (flight.vehicle.commands.len(), flight.vehicle.custom_mode);
        flight.node.command(OperatorCommand::Release);
        flight.ticks(100);
        assert_eq!((flight.vehicle.commands.len(), flight.vehicle.custom_mode), (commands, mode), "{firmware:?}");
    }
}

#[test]
fn an_order_takes_no_vehicle_from_its_pilot() {
    for firmware in FIRMWARES {
        let mut flight = at(When::Flight, firmware);
        let pilots = if firmware == Firmware::Px4 { 3 << 16 } else { 5 };
        flight.vehicle.custom_mode = pilots;
        flight.ticks(10);
        flight.node.command(OperatorCommand::Land);
        flight.ticks(50);
        assert_eq!(flight.vehicle.custom_mode, pilots);
        assert!(flight.said("not commanded: the vehicle is armed, in "), "{:?}", flight.words());
    }
}

#[test]
fn an_automatic_start_takes_no_vehicle_from_its_pilot() {
    for firmware in FIRMWARES {
        let mut flight = Flight::new(5, firmware, true);
        let pilots = if firmware == Firmware::Px4 { 3 << 16 } else { 5 };
        (flight.vehicle.armed, flight.vehicle.custom_mode, flight.vehicle.height_mm) = (true, pilots, 15_000.0);
        flight.ticks(300);
        assert_eq!(flight.vehicle.custom_mode, pilots);
        assert!(flight.said("type `start` to take it"), "{:?}", flight.words());
        assert!(flight.vehicle.commands.iter().all(|c| c.0 == mav_cmd::SET_MESSAGE_INTERVAL));
        // The operator's word is enough.
        flight.node.start();
        assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{firmware:?}: {:?}", flight.words());
    }
}

#[test]
fn a_mode_changed_between_the_answer_and_the_heartbeat_is_left() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    let asked = |f: &Flight| f.vehicle.commands.iter().any(|c| c.0 == mav_cmd::DO_SET_MODE);
    assert!(flight.until(30, asked));
    // GUIDED was taken and the pilot is back in LOITER before any heartbeat told of it.
    flight.vehicle.custom_mode = 5;
    flight.ticks(100);
    assert_eq!((flight.vehicle.custom_mode, flight.node.stage()), (5, Stage::Failed), "{:?}", flight.words());
}

#[test]
fn px4_in_another_mode_after_the_climb_is_left() {
    let mut flight = at(When::Climb, Firmware::Px4);
    assert!(flight.until(30, |f| f.node.is_airborne()));
    flight.vehicle.custom_mode = 3 << 16;
    flight.heartbeat();
    flight.ticks(100);
    assert_eq!((flight.vehicle.custom_mode, flight.node.stage()), (3 << 16, Stage::Failed), "{:?}", flight.words());
}

#[test]
fn a_failed_bring_up_lets_the_vehicle_go() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.vehicle.refuse = Some((mav_cmd::COMPONENT_ARM_DISARM, 4, "PreArm"));
    assert!(flight.until(120, |f| f.node.stage() == Stage::Failed));
    (flight.vehicle.armed, flight.vehicle.custom_mode, flight.vehicle.height_mm) = (true, 4, 12_000.0);
    let before = flight.vehicle.setpoints.len();
    flight.ticks(50);
    assert_eq!(flight.vehicle.setpoints.len(), before);
}
