//! Nodes against scripted vehicles, in virtual time, through the public interface.

mod batteries;
mod early;
mod ending;
mod faults;
mod flight;
mod heights;
mod identity;
mod keys;
mod mission;
mod muster;
mod neighbours;
mod orders;
mod parameters;
mod robust;
mod stages;
mod standing;
mod table;
mod takeovers;
mod vehicle;

use firmware_core::gate::Reason;
use firmware_core::geometry::Vec2;
use flight::{Flight, mission};
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::messages::mav_cmd;
use vehicle::{TICK_MS, Vehicle};

fn flying(id: u16, firmware: Firmware) -> Flight {
    let mut flight = Flight::new(id, firmware, true);
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
    flight
}

/// Commands besides message rates, without repetitions.
fn commands(vehicle: &Vehicle) -> Vec<u16> {
    let mut commands: Vec<u16> =
        vehicle.commands.iter().map(|&(id, _)| id).filter(|&id| id != mav_cmd::SET_MESSAGE_INTERVAL).collect();
    commands.dedup();
    commands
}

#[test]
fn ardupilot_is_brought_into_flight() {
    let flight = flying(5, Firmware::ArduPilot);
    let v = &flight.vehicle;
    assert_eq!(commands(v), [mav_cmd::DO_SET_MODE, mav_cmd::COMPONENT_ARM_DISARM, mav_cmd::NAV_TAKEOFF]);
    // Layer 5 of 8: 12 m.
    assert_eq!(v.commands.last().unwrap().1, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 12.0]);
    assert!((v.height_mm - 12_000.0).abs() <= 1000.0);
    let rates: Vec<_> =
        v.commands.iter().filter(|c| c.0 == mav_cmd::SET_MESSAGE_INTERVAL).map(|c| (c.1[0], c.1[1])).collect();
    assert!(rates.contains(&(33.0, 200_000.0)) && rates.contains(&(193.0, 500_000.0)), "{rates:?}");
    assert!(v.setpoints.len() <= 1, "setpoints before it flies");
}

#[test]
fn px4_gets_setpoints_before_offboard() {
    let flight = flying(5, Firmware::Px4);
    let v = &flight.vehicle;
    assert_eq!(commands(v), [mav_cmd::COMPONENT_ARM_DISARM, mav_cmd::NAV_TAKEOFF, mav_cmd::DO_SET_MODE]);
    assert_eq!(v.commands.iter().find(|c| c.0 == mav_cmd::NAV_TAKEOFF).unwrap().1[6], 500.0);
    assert!(v.setpoints.len() >= 5, "{:?}", v.setpoints);
    assert!(v.setpoints.iter().all(|s| s.velocity == [0.0; 2]), "{:?}", v.setpoints);
    assert!(v.is_guided());
}

#[test]
fn nothing_is_commanded_that_nobody_asked_for() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, false);
    flight.ticks(300);
    assert!(commands(&flight.vehicle).is_empty());
    assert!(flight.vehicle.setpoints.is_empty() && flight.told.is_empty());
    // The pilot flies it, and then lets the node.
    flight.vehicle.armed = true;
    flight.vehicle.custom_mode = 5;
    flight.vehicle.height_mm = 15_000.0;
    flight.ticks(50);
    assert!(flight.vehicle.setpoints.is_empty());
    assert!(!flight.told.is_empty(), "in the air it says where it is");
    flight.vehicle.custom_mode = 4;
    flight.ticks(50);
    assert!(flight.vehicle.setpoints.len() > 30);
    assert!(commands(&flight.vehicle).is_empty());
}

#[test]
fn a_refused_arming_is_told_in_the_autopilots_words() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.vehicle.refuse = Some((mav_cmd::COMPONENT_ARM_DISARM, 4, "PreArm: Compass not calibrated"));
    assert!(flight.until(120, |f| f.node.stage() == Stage::Failed), "{:?}", flight.words());
    assert!(flight.said("not flying: arming refused by the autopilot: PreArm: Compass not calibrated"));
    let asked = flight.vehicle.commands.len();
    flight.ticks(100);
    assert_eq!(flight.vehicle.commands.len(), asked, "asked on after giving up");
    // The operator tries again.
    flight.vehicle.refuse = None;
    flight.node.start();
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
}

#[test]
fn commands_without_an_answer_are_repeated_and_then_given_up() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.until(20, |f| f.vehicle.commands.iter().any(|c| c.0 == mav_cmd::DO_SET_MODE));
    flight.vehicle.mute = true;
    flight.ticks(20);
    flight.vehicle.mute = false;
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.vehicle.mute = true;
    assert!(flight.until(200, |f| f.node.stage() == Stage::Failed), "{:?}", flight.words());
    assert!(flight.said("does not take a rate") && flight.said("no answer from the autopilot"));
}

#[test]
fn it_waits_for_the_estimator() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.vehicle.healthy = false;
    flight.ticks(200);
    assert!(commands(&flight.vehicle).is_empty());
    flight.vehicle.healthy = true;
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
}

#[test]
fn a_step_has_its_beacon_its_feature_and_its_decision() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.until(10, |f| !f.decisions.is_empty());
    flight.decisions.clear();
    flight.begun.clear();
    flight.told.clear();
    flight.vehicle.setpoints.clear();
    // From the beginning of a step, ten of them.
    flight.until(3, |f| !f.begun.is_empty());
    flight.told.retain(|&(at, _)| at == flight.vehicle.boot_ms);
    flight.vehicle.setpoints.clear();
    flight.ticks(99);
    assert_eq!((flight.begun.len(), flight.decisions.len(), flight.told.len()), (10, 10, 20));
    let start = flight.told[0].0;
    for (k, (pair, decision)) in flight.told.chunks(2).zip(&flight.decisions).enumerate() {
        let at = start + k as u32 * 2000;
        // Nobody else is there to be waited for.
        assert_eq!((pair[0].0, pair[1].0, decision.boot_ms), (at, at, at));
        assert!(!decision.late && decision.step == flight.begun[k].step);
        // Where its velocity takes it in 1500 ms of a step of 2 s.
        let measured = flight.begun[k].state;
        let ahead = |v: i32| (f64::from(v) * 0.75).round() as i32;
        assert_eq!(decision.state.velocity, measured.velocity);
        assert_eq!(decision.state.position.x - measured.position.x, ahead(measured.velocity.x));
        assert_eq!(decision.state.position.y - measured.position.y, ahead(measured.velocity.y));
    }
    assert_eq!(flight.vehicle.setpoints.len(), 99, "one setpoint a telemetry pair");
    assert!(flight.vehicle.setpoints.iter().any(|s| s.velocity != [0.0; 2]));
    let speed = |v: [f32; 2]| v[0].hypot(v[1]);
    assert!(flight.vehicle.setpoints.iter().all(|s| speed(s.velocity) <= 5.001 && speed(s.acceleration) <= 2.501));
    let counters = flight.node.counters();
    assert_eq!((counters.late_decisions, counters.missed_decisions), (0, 0));
}

#[test]
fn two_nodes_see_each_other_and_use_their_features() {
    let mut a = Flight::at(1, Firmware::ArduPilot, true, Vec2::from_u(100.0, 100.0));
    let mut b = Flight::at(2, Firmware::ArduPilot, true, Vec2::from_u(104.0, 100.0));
    for _ in 0..400 {
        let (from_a, from_b) = (a.tick(), b.tick());
        from_a.iter().for_each(|frame| b.hear_swarm(frame));
        from_b.iter().for_each(|frame| a.hear_swarm(frame));
    }
    let near = a.decisions.iter().filter(|d| d.neighbours() == [2] && d.features == 1).count();
    assert!(near > 3, "{near} of {} decisions with the neighbour", a.decisions.len());
    let counters = a.node.counters();
    assert!(counters.received > 20 && counters.rejected.is_empty(), "{counters:?}");
}

#[test]
fn old_repeated_and_foreign_messages_are_counted_and_not_used() {
    let mut a = flying(1, Firmware::ArduPilot);
    let mut b = flying(2, Firmware::ArduPilot);
    a.ticks(20);
    let mut old = Vec::new();
    for _ in 0..20 {
        old.extend(b.tick());
        a.tick();
    }
    a.ticks(40);
    old.iter().for_each(|frame| a.hear_swarm(frame));
    let rejected = a.node.counters().rejected;
    assert!(rejected.get("late") >= Some(&2), "{rejected:?}");
    let fresh = a.told.last().unwrap().1;
    a.hear_swarm(&fresh);
    assert_eq!(a.node.counters().rejected.get("own_echo"), Some(&1));
    let mut twin = Flight::at(1, Firmware::ArduPilot, true, Vec2::from_u(50.0, 60.0));
    twin.ticks(200);
    twin.told.iter().for_each(|(_, frame)| a.hear_swarm(frame));
    assert!(a.node.counters().rejected.get("id_collision") >= Some(&1), "{:?}", a.node.counters().rejected);
    assert_eq!(a.node.counters().received, 0);
}

#[test]
fn clocks_and_sequence_numbers_wrap_in_flight() {
    let fly = |boot_ms: u32, sequence: u16| {
        let mut pair =
            [1, 2].map(|id| Flight::at(id, Firmware::ArduPilot, true, Vec2::from_u(96.0 + 4.0 * f32::from(id), 100.0)));
        for flight in &mut pair {
            flight.vehicle.boot_ms = boot_ms;
            flight.node.set_sequence(sequence);
        }
        for _ in 0..500 {
            let [a, b] = &mut pair;
            let (from_a, from_b) = (a.tick(), b.tick());
            from_a.iter().for_each(|frame| b.hear_swarm(frame));
            from_b.iter().for_each(|frame| a.hear_swarm(frame));
        }
        pair.map(|flight| {
            let counters = flight.node.counters();
            assert_eq!((counters.missed_decisions, counters.late_decisions), (0, 0));
            assert!(counters.rejected.is_empty(), "{counters:?}");
            assert!(counters.decisions > 30);
            let setpoints = flight.vehicle.setpoints.iter().map(|s| (s.velocity, s.acceleration));
            (
                flight.decisions.iter().map(|d| (d.step, d.observation, d.action)).collect::<Vec<_>>(),
                setpoints.collect::<Vec<_>>(),
            )
        })
    };
    // The same flight with other clocks.
    assert_eq!(fly(u32::MAX - 40_000, u16::MAX - 20), fly(10_000, 100));
}

#[test]
fn a_pilot_who_takes_over_keeps_it() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.ticks(50);
    flight.vehicle.custom_mode = 5;
    let (commands, before) = (flight.vehicle.commands.len(), flight.vehicle.setpoints.len());
    flight.ticks(50);
    // The heartbeat that tells of it comes within a second.
    assert!(flight.vehicle.setpoints.len() - before <= 6);
    assert_eq!(flight.node.verdict().reason(), Some(Reason::ModeLeft));
    // Back in GUIDED by the pilot's hand: still nothing without the operator.
    flight.vehicle.custom_mode = 4;
    let before = flight.vehicle.setpoints.len();
    flight.ticks(50);
    assert_eq!((flight.vehicle.commands.len(), flight.vehicle.setpoints.len()), (commands, before));
    flight.node.start();
    flight.ticks(20);
    assert!(flight.vehicle.setpoints.len() > before);
}

#[test]
fn numbers_that_are_none_go_no_further() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.ticks(50);
    flight.vehicle.broken = true;
    flight.tick();
    assert_eq!(flight.node.verdict().reason(), Some(Reason::NumberRefused));
    flight.ticks(4);
    assert_eq!(flight.vehicle.setpoints.last().unwrap().velocity, [0.0; 2]);
    flight.vehicle.broken = false;
    flight.ticks(30);
    assert_eq!(flight.node.verdict().name(), "stream");
}

#[test]
fn heartbeats_follow_the_vehicles_clock_and_stop_with_the_loop() {
    let mut flight = flying(5, Firmware::ArduPilot);
    let before = flight.vehicle.heartbeats;
    flight.ticks(50);
    assert_eq!(flight.vehicle.heartbeats - before, 50 * TICK_MS / 1000);
    // The vehicle falls silent: the host's clock takes over after a second.
    let before = flight.vehicle.heartbeats;
    (0..100).for_each(|_| drop(flight.idle(50)));
    assert_eq!(flight.vehicle.heartbeats - before, 4);
}

#[test]
fn silence_is_told_with_what_to_check() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    (0..110).for_each(|_| drop(flight.idle(50)));
    let told = flight.notices.iter().filter(|n| n.text == "nothing heard for 5 s; is it switched on?").count();
    assert_eq!(told, 1);
    flight.ticks(10);
    assert!(flight.said("heard again"));
}

#[test]
fn a_reboot_in_flight_ends_the_flight() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.ticks(100);
    flight.vehicle.boot_ms = 300;
    flight.vehicle.armed = false;
    let (commands, before) = (flight.vehicle.commands.len(), flight.vehicle.setpoints.len());
    flight.ticks(100);
    assert_eq!(flight.vehicle.setpoints.len(), before);
    let again: Vec<u16> = flight.vehicle.commands[commands..].iter().map(|c| c.0).collect();
    assert!(!again.is_empty() && again.iter().all(|&id| id == mav_cmd::SET_MESSAGE_INTERVAL), "{again:?}");
}

#[test]
fn without_system_time_the_hosts_clock_does() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.vehicle.knows_time = false;
    assert!(flight.until(90, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
    assert!(flight.said("taking this computer's clock"));
}

#[test]
fn a_low_battery_sends_it_home() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.ticks(20);
    flight.vehicle.battery = 10;
    assert!(flight.until(20, |f| f.vehicle.custom_mode == 6), "{:?}", flight.words());
    let before = flight.vehicle.setpoints.len();
    flight.ticks(50);
    assert!(flight.vehicle.setpoints.len() - before <= 6);
}

#[test]
fn released_it_falls_silent_or_lands() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.node.release(false);
    let before = flight.vehicle.setpoints.len();
    flight.ticks(20);
    // It stands: one setpoint says so, and no more.
    let last = &flight.vehicle.setpoints[before..];
    assert!(last.len() == 1 && last[0].velocity == [0.0; 2] && last[0].acceleration == [0.0; 2], "{last:?}");
    assert_eq!(flight.vehicle.custom_mode, 4);
    let mut flight = flying(5, Firmware::Px4);
    flight.node.release(true);
    flight.ticks(20);
    assert_eq!(flight.vehicle.custom_mode, (6 << 24) | (4 << 16));
}

#[test]
fn no_local_position_and_the_grain_of_the_global_one() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    flight.vehicle.with_local = false;
    assert!(flight.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", flight.words());
    flight.ticks(100);
    assert!(flight.decisions.len() >= 9);
    assert_eq!(flight.node.counters().missed_decisions, 0);
}

#[test]
fn the_scripted_vehicle_speaks_what_the_node_reads() {
    let mut vehicle = Vehicle::new(Firmware::ArduPilot, &mission(), Vec2::default());
    assert!(vehicle.tick().iter().all(Vehicle::reads_back));
}
