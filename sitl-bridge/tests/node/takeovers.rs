//! Who has the vehicle: pilots who are easily taken for the node's own doing, and answers that are lost.

use crate::flight::Flight;
use crate::stages::{Stage, let_go_on};
use crate::{commands, flying};
use sitl_bridge::autopilot::{Firmware, Stage as NodeStage};
use sitl_bridge::frame::Encoder;
use sitl_bridge::messages::mav_cmd;
use sitl_bridge::node::OperatorCommand;

const FIRMWARES: [Firmware; 2] = [Firmware::ArduPilot, Firmware::Px4];
/// PX4's AUTO.LOITER, which pilots know as HOLD.
const HOLD: u32 = (3 << 24) | (4 << 16);
const PX4_LAND: u32 = (6 << 24) | (4 << 16);

#[test]
fn a_takeoff_whose_answer_is_lost_is_no_failure() {
    for firmware in FIRMWARES {
        for command in [mav_cmd::NAV_TAKEOFF, mav_cmd::COMPONENT_ARM_DISARM, mav_cmd::DO_SET_MODE] {
            let mut flight = Flight::new(5, firmware, true);
            flight.vehicle.lose_answers = Some(command);
            let up = flight.until(60, |f| f.node.stage() == NodeStage::Flying);
            assert!(up, "{firmware:?} {command}: {:?}", flight.words());
            assert!(!flight.said("not flying") && !flight.said("trying again"), "{:?}", flight.words());
        }
    }
}

#[test]
fn a_pilot_who_arms_and_takes_off_while_arming_is_refused_keeps_it() {
    for firmware in FIRMWARES {
        let mut flight = Flight::new(5, firmware, true);
        flight.vehicle.custom_mode = if firmware == Firmware::Px4 { 3 << 16 } else { 0 };
        flight.vehicle.refuse = Some((mav_cmd::COMPONENT_ARM_DISARM, 4, "PreArm: Compass"));
        assert!(flight.until(30, |f| f.said("arming refused")));
        // The checks pass for the pilot, who stays in the mode in which the vehicle was found.
        let pilots = if firmware == Firmware::Px4 { 3 << 16 } else { 0 };
        (flight.vehicle.armed, flight.vehicle.custom_mode) = (true, pilots);
        flight.vehicle.refuse = None;
        flight.heartbeat();
        let before = flight.vehicle.commands.len();
        flight.vehicle.height_mm = 12_000.0;
        flight.ticks(300);
        assert_eq!(
            (flight.vehicle.custom_mode, flight.vehicle.commands.len()),
            (pilots, before),
            "{:?}",
            flight.words()
        );
        assert!(flight.vehicle.setpoints.is_empty());
    }
}

#[test]
fn a_pilot_who_flies_while_the_change_to_guided_is_refused_keeps_it() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.vehicle.refuse = Some((mav_cmd::DO_SET_MODE, 4, "requires position"));
    assert!(flight.until(30, |f| f.said("requires position")));
    // In STABILIZE, where the bring-up began.
    (flight.vehicle.armed, flight.vehicle.height_mm, flight.vehicle.refuse) = (true, 12_000.0, None);
    flight.heartbeat();
    flight.ticks(300);
    assert_eq!(flight.vehicle.custom_mode, 0, "{:?}", flight.words());
    assert!(flight.said("somebody else armed it, in STABILIZE"), "{:?}", flight.words());
}

#[test]
fn a_pilots_hold_in_the_climb_is_told_from_the_end_of_the_takeoff() {
    let mut flight = Stage::Climb.reach(Firmware::Px4).unwrap();
    let height_mm = flight.vehicle.height_mm;
    (flight.vehicle.custom_mode, flight.vehicle.ceiling_mm) = (HOLD, Some(height_mm));
    flight.ticks(300);
    assert_eq!(flight.vehicle.custom_mode, HOLD, "{:?}", flight.words());
    assert!(flight.said("the mode is AUTO.LOITER: somebody else changed it"), "{:?}", flight.words());
    // Nor is it ordered to land.
    flight.node.command(OperatorCommand::Land);
    flight.ticks(30);
    assert_eq!(flight.vehicle.custom_mode, HOLD);
    assert!(flight.said("not commanded: "), "{:?}", flight.words());
}

#[test]
fn px4_holding_by_itself_takes_orders_and_a_pilots_hold_does_not() {
    // The node falls silent, and PX4 holds.
    let mut flight = Stage::Released.reach(Firmware::Px4).unwrap();
    assert_eq!(flight.vehicle.custom_mode, HOLD);
    flight.node.command(OperatorCommand::Land);
    flight.ticks(10);
    assert_eq!(flight.vehicle.custom_mode, PX4_LAND, "{:?}", flight.words());
    // Or returns by itself, as COM_OBL_RC_ACT may say; but not where it waits for a pilot at the sticks.
    for (by_itself, is_ours) in [((5 << 24) | (4 << 16), true), (3 << 16, false)] {
        let mut flight = Stage::Flight.reach(Firmware::Px4).unwrap();
        flight.vehicle.offboard_loss_ms = None;
        flight.node.command(OperatorCommand::Release);
        flight.ticks(40);
        flight.vehicle.custom_mode = by_itself;
        flight.ticks(10);
        flight.node.command(OperatorCommand::Land);
        flight.ticks(10);
        assert_eq!(flight.vehicle.custom_mode, if is_ours { PX4_LAND } else { by_itself }, "{:?}", flight.words());
    }
    // The pilot holds while the node streams.
    let mut flight = Stage::Flight.reach(Firmware::Px4).unwrap();
    flight.vehicle.custom_mode = HOLD;
    flight.ticks(10);
    flight.node.command(OperatorCommand::Land);
    flight.ticks(30);
    assert_eq!(flight.vehicle.custom_mode, HOLD, "{:?}", flight.words());
    assert!(flight.said("not commanded: the vehicle is armed, in AUTO.LOITER"), "{:?}", flight.words());
}

#[test]
fn an_order_outlives_a_leap_of_the_clock_and_another_commands_answer() {
    for firmware in FIRMWARES {
        for leap in [-20_000_i32, 0, 59_000] {
            let mut flight = flying(5, firmware);
            flight.ticks(20);
            flight.vehicle.ignore = Some(mav_cmd::DO_SET_MODE);
            flight.node.command(OperatorCommand::Land);
            flight.ticks(1);
            // The late answer to the change to GUIDED.
            let ack = [176, 0, 0];
            flight.hear_autopilot(&Encoder::new(7, 1).encode_payload(77, &ack).unwrap());
            flight.vehicle.boot_ms = flight.vehicle.boot_ms.wrapping_add_signed(leap);
            flight.ticks(2);
            let_go_on(&mut flight);
            let land = if firmware == Firmware::Px4 { PX4_LAND } else { 9 };
            assert!(flight.until(5, |f| f.vehicle.custom_mode == land), "{firmware:?} {leap}: {:?}", flight.words());
        }
    }
}

#[test]
fn an_order_before_the_vehicle_is_heard_waits_and_starts_nothing() {
    for firmware in FIRMWARES {
        let mut flight = Stage::SilentInAir.reach(firmware).unwrap();
        // Disarmed on the ground after all.
        (flight.vehicle.armed, flight.vehicle.height_mm, flight.vehicle.custom_mode) = (false, 0.0, 0);
        flight.node.command(OperatorCommand::Land);
        flight.ticks(100);
        assert!(flight.said("commanded as soon as the vehicle is this node's") && flight.said("not commanded: "));
        assert!(commands(&flight.vehicle).is_empty() && flight.vehicle.setpoints.is_empty());
        // The order does not come back when it flies.
        flight.node.command(OperatorCommand::Start);
        assert!(flight.until(60, |f| f.node.stage() == NodeStage::Flying), "{:?}", flight.words());
        flight.ticks(50);
        assert!(flight.vehicle.is_guided());
    }
}

#[test]
fn a_start_in_the_climb_commands_no_second_takeoff() {
    for firmware in FIRMWARES {
        let mut flight = Stage::Climb.reach(firmware).unwrap();
        flight.node.command(OperatorCommand::Start);
        assert!(flight.until(60, |f| f.node.stage() == NodeStage::Flying), "{:?}", flight.words());
        let takeoffs = flight.vehicle.commands.iter().filter(|c| c.0 == mav_cmd::NAV_TAKEOFF).count();
        assert!(takeoffs == 1 && flight.vehicle.height_mm > 10_000.0, "{takeoffs}: {:?}", flight.words());
    }
}

#[test]
fn a_return_that_was_ordered_can_still_become_a_landing() {
    for firmware in FIRMWARES {
        let mut flight = Stage::Returning.reach(firmware).unwrap();
        // Whenever within the second between two heartbeats.
        for ticks in 0..5 {
            let mut flight = Stage::Returning.reach(firmware).unwrap();
            flight.ticks(ticks);
            flight.node.command(OperatorCommand::Land);
            let land = if firmware == Firmware::Px4 { PX4_LAND } else { 9 };
            flight.ticks(10);
            assert_eq!(flight.vehicle.custom_mode, land, "{firmware:?} {ticks}: {:?}", flight.words());
            flight.node.command(OperatorCommand::Return);
            flight.ticks(10);
            assert_ne!(flight.vehicle.custom_mode, land, "{firmware:?} {ticks}: {:?}", flight.words());
        }
        // The pilot takes it on the way: no more orders.
        let pilots = if firmware == Firmware::Px4 { 3 << 16 } else { 5 };
        let rtl = std::mem::replace(&mut flight.vehicle.custom_mode, pilots);
        flight.ticks(10);
        flight.vehicle.custom_mode = rtl;
        flight.ticks(10);
        flight.node.command(OperatorCommand::Land);
        flight.ticks(30);
        assert_eq!(flight.vehicle.custom_mode, rtl, "{firmware:?}: {:?}", flight.words());
        assert!(flight.said("not commanded: "), "{:?}", flight.words());
    }
}
