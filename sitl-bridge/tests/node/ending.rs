//! The end of a flight in motion: the vehicle is braked before it is let go.

use crate::flight::{Flight, mission, settings};
use crate::vehicle::TICK_MS;
use firmware_core::gate::{Limits, Reason};
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::Firmware;
use sitl_bridge::node::{OperatorCommand, Settings, gate_limits};

/// The gate's greatest acceleration, m/s², and its rounding.
const ACCELERATION: f64 = 2.51;

/// A flight in real time at `speed` m/s or more, of a vehicle that needs time to change its velocity.
fn in_motion(speed: f64) -> Flight {
    let mission = mission();
    let limits = gate_limits(Limits::default(), &mission);
    let settings = Settings { limits, ..settings(5, &mission, true) };
    let mut flight = Flight::with(settings, Firmware::ArduPilot, Vec2::from_u(100.0, 100.0));
    flight.vehicle.acceleration_mps2 = Some(2.0);
    assert!(flight.until(200, |f| f.vehicle.speed() > speed && f.decisions.len() > 1), "{:?}", flight.words());
    flight
}

#[test]
fn released_in_motion_it_brakes_and_is_let_go_at_rest() {
    let mut flight = in_motion(3.0);
    let before = flight.vehicle.setpoints.len();
    flight.node.command(OperatorCommand::Release);
    assert!(flight.node.is_ending());
    let began = flight.vehicle.boot_ms;
    assert!(flight.until(10, |f| !f.node.is_ending()), "{:?}", flight.words());
    assert!(flight.vehicle.boot_ms - began <= 3000 + TICK_MS);
    assert!(flight.vehicle.speed() < 0.3, "let go at {} m/s", flight.vehicle.speed());
    assert_eq!(flight.node.verdict().reason(), Some(Reason::OperatorReleased));
    let ramp = &flight.vehicle.setpoints[before - 1..];
    for pair in ramp.windows(2) {
        let seconds = f64::from(pair[1].at_ms - pair[0].at_ms) / 1000.0;
        let [from, to] = [0, 1].map(|i: usize| pair[i].velocity);
        let change = f64::from((to[0] - from[0]).hypot(to[1] - from[1]));
        assert!(change <= ACCELERATION * seconds + 0.003, "{pair:?}");
        assert!(to[0].hypot(to[1]) <= from[0].hypot(from[1]) + 0.003, "{pair:?}");
        assert!(pair[1].acceleration[0].hypot(pair[1].acceleration[1]) <= ACCELERATION as f32, "{pair:?}");
    }
    let last = ramp.last().unwrap();
    assert_eq!((last.velocity, last.climb, last.acceleration), ([0.0; 2], 0.0, [0.0; 2]));
    // Nothing more, and the mode is the operator's.
    let sent = flight.vehicle.setpoints.len();
    flight.ticks(50);
    assert_eq!((flight.vehicle.setpoints.len(), flight.vehicle.custom_mode), (sent, 4));
}

#[test]
fn braking_ends_in_time_though_nothing_is_heard() {
    let mut flight = in_motion(3.0);
    flight.node.command(OperatorCommand::Release);
    let began = flight.wall_ms;
    for _ in 0..200 {
        if flight.node.is_ending() {
            flight.idle(20);
        }
    }
    assert!(!flight.node.is_ending() && flight.wall_ms - began <= 4000, "{} ms", flight.wall_ms - began);
    let last = flight.vehicle.setpoints.last().unwrap();
    assert_eq!((last.velocity, last.acceleration), ([0.0; 2], [0.0; 2]));
}

#[test]
fn a_vehicle_that_does_not_slow_down_is_let_go_all_the_same() {
    let mut flight = in_motion(3.0);
    flight.vehicle.acceleration_mps2 = Some(0.1);
    flight.node.command(OperatorCommand::Release);
    let began = flight.vehicle.boot_ms;
    assert!(flight.until(10, |f| !f.node.is_ending()));
    assert!((3000..=3000 + 2 * TICK_MS).contains(&(flight.vehicle.boot_ms - began)));
    assert_eq!(flight.vehicle.setpoints.last().unwrap().velocity, [0.0; 2]);
}

#[test]
fn a_pilot_who_takes_over_ends_the_braking() {
    let mut flight = in_motion(3.0);
    flight.node.command(OperatorCommand::Release);
    flight.ticks(2);
    flight.vehicle.custom_mode = 5;
    flight.heartbeat();
    let sent = flight.vehicle.setpoints.len();
    assert!(!flight.node.is_ending());
    flight.ticks(20);
    assert_eq!((flight.vehicle.setpoints.len(), flight.vehicle.custom_mode), (sent, 5));
}

#[test]
fn a_start_while_braking_flies_on() {
    let mut flight = in_motion(3.0);
    flight.node.command(OperatorCommand::Release);
    flight.ticks(3);
    flight.node.command(OperatorCommand::Start);
    flight.ticks(20);
    assert!(!flight.node.is_ending());
    assert_eq!(flight.node.verdict().name(), "stream");
}
