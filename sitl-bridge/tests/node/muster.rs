//! UAVs that start together, and those that share an id or an altitude layer.

use crate::commands;
use crate::flight::{Flight, mission, settings};
use firmware_core::gate::{Limits, Reason};
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::node::{Settings, gate_limits};

fn uav(id: u16, x: f32, layers: u16) -> Flight {
    one_of(1, id, x, layers)
}

/// One of so many UAVs that start together.
fn one_of(wait_for: u16, id: u16, x: f32, layers: u16) -> Flight {
    let mut mission = mission();
    mission.layers.count = layers;
    let limits = gate_limits(Limits::default(), &mission);
    let settings = Settings { limits, wait_for, ..settings(id, &mission, true) };
    Flight::with(settings, Firmware::ArduPilot, Vec2::from_u(x, 100.0))
}

/// Both tick and hear each other.
fn together(a: &mut Flight, b: &mut Flight, ticks: u32) {
    for _ in 0..ticks {
        let (from_a, from_b) = (a.tick(), b.tick());
        from_b.iter().for_each(|frame| a.hear_swarm(frame));
        from_a.iter().for_each(|frame| b.hear_swarm(frame));
    }
}

fn is_waiting(flight: &Flight) -> bool {
    flight.node.verdict().reason() == Some(Reason::SwarmIncomplete)
}

#[test]
fn those_that_start_together_wait_for_the_last() {
    let (mut a, mut b) = (one_of(2, 1, 100.0, 8), one_of(2, 2, 104.0, 8));
    b.vehicle.healthy = false;
    together(&mut a, &mut b, 300);
    assert!(is_waiting(&a) && a.vehicle.setpoints.iter().all(|s| s.velocity == [0.0; 2]), "{:?}", a.words());
    assert!(a.decisions.len() > 5, "it decides meanwhile");
    b.vehicle.healthy = true;
    let mut ticks = 0;
    while is_waiting(&a) {
        together(&mut a, &mut b, 1);
        ticks += 1;
        assert!(ticks < 300, "{:?}", a.words());
    }
    // It was let go when the other was on its layer, and not before.
    assert!((b.vehicle.height_mm - 9000.0).abs() <= 1000.0, "{}", b.vehicle.height_mm);
    together(&mut a, &mut b, 60);
    assert!(a.vehicle.speed() > 0.5 || b.vehicle.speed() > 0.5);
    assert!(!a.said("crosses their layers") && !b.said("crosses their layers"), "{:?}", b.words());
    // Who is lost later does not stop the others.
    a.ticks(100);
    assert_eq!(a.node.verdict().reason(), None);
}

#[test]
fn the_operator_need_not_wait_for_the_last() {
    let mut a = one_of(3, 1, 100.0, 8);
    assert!(a.until(90, is_waiting), "{:?}", a.words());
    a.ticks(50);
    assert!(is_waiting(&a));
    a.node.start();
    assert!(a.until(10, |f| f.node.verdict().name() == "stream"), "{:?}", a.words());
    a.ticks(50);
    assert_eq!(a.node.verdict().name(), "stream");
}

#[test]
fn a_uav_with_the_own_id_in_the_air_is_refused_before_the_bring_up() {
    let (mut a, mut twin) = (uav(1, 100.0, 8), uav(1, 104.0, 8));
    assert!(twin.until(60, |f| f.node.stage() == Stage::Flying));
    twin.ticks(20);
    a.vehicle.healthy = false;
    together(&mut a, &mut twin, 30);
    a.vehicle.healthy = true;
    together(&mut a, &mut twin, 100);
    assert_eq!(a.node.stage(), Stage::Failed);
    assert!(a.said("not flying: another UAV in the air has the id 1 too"), "{:?}", a.words());
    assert!(commands(&a.vehicle).is_empty() && a.vehicle.setpoints.is_empty());
    // The other one has landed.
    a.node.start();
    assert!(a.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", a.words());
    // In flight it is told of, and flown on from.
    together(&mut a, &mut twin, 50);
    assert!(a.said("another UAV of the swarm has the same id"));
    assert_eq!(a.node.verdict().reason(), None);
}

#[test]
fn a_uav_on_the_same_layer_is_refused_before_the_bring_up_and_told_of_in_flight() {
    let (mut a, mut other) = (uav(5, 100.0, 8), uav(13, 104.0, 16));
    assert!(other.until(60, |f| f.node.stage() == Stage::Flying), "{:?}", other.words());
    other.ticks(20);
    a.vehicle.healthy = false;
    together(&mut a, &mut other, 30);
    a.vehicle.healthy = true;
    together(&mut a, &mut other, 100);
    assert!(
        a.said("not flying: UAV 13 flies at the height of UAV 5: the mission has 8 altitude layers"),
        "{:?}",
        a.words()
    );
    assert!(commands(&a.vehicle).is_empty() && a.vehicle.setpoints.is_empty());
    let mut a = uav(5, 100.0, 8);
    assert!(a.until(60, |f| f.node.stage() == Stage::Flying));
    together(&mut a, &mut other, 50);
    let told = a.notices.iter().filter(|n| n.warning && n.text.starts_with("UAV 13 flies at the height of")).count();
    assert_eq!((told, a.node.stage()), (1, Stage::Flying), "{:?}", a.words());
}

#[test]
fn a_uav_beyond_the_layers_is_refused_before_the_bring_up() {
    let mut a = uav(9, 100.0, 8);
    a.ticks(100);
    assert_eq!(a.node.stage(), Stage::Failed);
    assert!(a.said("not flying: UAV 9 has no altitude layer of its own: the mission has 8"), "{:?}", a.words());
    assert!(commands(&a.vehicle).is_empty() && a.vehicle.setpoints.is_empty());
}

#[test]
fn who_takes_off_after_the_others_is_told_so() {
    let (mut a, mut b) = (uav(1, 100.0, 8), uav(2, 104.0, 8));
    assert!(b.until(60, |f| f.node.stage() == Stage::Flying));
    together(&mut a, &mut b, 200);
    assert_eq!(a.node.stage(), Stage::Flying, "{:?}", a.words());
    let told =
        a.notices.iter().filter(|n| n.warning && n.text.starts_with("a UAV flies already: on its way up")).count();
    assert_eq!(told, 1, "{:?}", a.words());
    assert!(!b.said("crosses their layers"));
}
