//! Small swarms against the simulated autopilots: with the scenario's own dynamics every
//! decision is the trainer's, whatever the clocks, the autopilot and the signatures.

use covey_env::Scenario;
use firmware_core::actor::Actor;
use serde_json::json;
use sitl_bridge::signing::{Key, LinkSigning, Unsigned};
use sitl_bridge::simulation::{Simulation, WorldFlight};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Close together, so that they hear each other.
fn scenario() -> Scenario {
    Scenario { uavs: 5, pois: 30, side_u: 50.0, steps: 12, ..Scenario::default() }
}

fn actor() -> Actor<'static> {
    let bytes = include_bytes!("../../host-trainer/actors/gcn.postcard");
    let actor = Actor::load(bytes).expect("sound");
    actor.self_test().expect("sound");
    actor
}

fn ideal() -> Simulation<'static> {
    Simulation { ideal: true, ..Simulation::new(actor(), scenario()) }
}

fn fly(simulation: &Simulation<'_>) -> WorldFlight {
    simulation.fly(2, &Arc::new(AtomicBool::new(false))).unwrap_or_else(|error| panic!("{error}"))
}

/// Every decision is made and is the trainer's.
fn check(flight: &WorldFlight) {
    assert_eq!(flight.first_difference, None);
    assert_eq!((flight.compared, flight.equal, flight.counters.decisions), (60, 60, 60));
    assert_eq!((flight.counters.late_decisions, flight.counters.missed_decisions), (0, 0));
    assert_eq!(flight.counters.limited_setpoints, 0);
    assert_eq!((&flight.coverage, &flight.true_coverage), (&flight.trainer_coverage, &flight.trainer_coverage));
    assert!(flight.trouble.is_empty(), "{:?}", flight.trouble);
    let linked = flight.decisions.iter().flatten().flatten().filter(|d| !d.neighbours().is_empty()).count();
    assert!(linked > 10, "only {linked} decisions with neighbours");
}

#[test]
fn ideal_flights_are_the_trainers() {
    check(&fly(&ideal()));
}

#[test]
fn px4_flies_the_same() {
    check(&fly(&Simulation { px4: true, ..ideal() }));
}

/// As behind one MAVProxy: a node that took the first autopilot that it hears would fly the wrong one.
#[test]
fn every_vehicle_on_every_port_changes_nothing() {
    let mut simulation = ideal();
    simulation.fleet.insert("shared_ports".into(), json!(true));
    check(&fly(&simulation));
}

#[test]
fn wrapping_clocks_and_sequence_numbers_change_nothing() {
    // The vehicles' clocks wrap in flight, after takeoff and the wait for step 0.
    let mut simulation = Simulation { sequence: Some(u16::MAX - 10), ..ideal() };
    simulation.fleet.insert("boot_ms".into(), json!(u64::from(u32::MAX) - 40_000));
    check(&fly(&simulation));
}

#[test]
fn signatures_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("key");
    std::fs::write(&file, "ab".repeat(32)).unwrap();
    #[cfg(unix)]
    std::fs::set_permissions(&file, std::os::unix::fs::PermissionsExt::from_mode(0o600)).unwrap();
    let key = Key::from_file(&file).unwrap();
    let link = |id| LinkSigning::new(key.clone(), id, Unsigned::Refuse);
    check(&fly(&Simulation { signing: (link(0), link(1)), key_file: Some(file.clone()), ..ideal() }));
}

/// A point mass with limits, lag and drag: the nodes decide what the trainer would where they are.
#[test]
fn real_dynamics_are_decided_as_the_trainer_would() {
    let simulation = Simulation::new(actor(), scenario());
    let (first, second) = (fly(&simulation), fly(&simulation));
    assert_eq!((first.compared, first.counters.decisions), (60, 60));
    assert!(first.equal >= 57, "{} of 60: {:?}", first.equal, first.first_difference);
    // In lock-step a flight is the same every time.
    let states = |flight: &WorldFlight| format!("{:?}", flight.states);
    assert!(states(&first) == states(&second), "two flights of the same world differ");
}
