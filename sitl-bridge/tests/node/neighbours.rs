//! What goes wrong with a neighbour: the UAV decides with whom it can trust, and flies on.

use crate::flight::{Flight, mission, settings};
use firmware_core::actor::Actor;
use firmware_core::gate::{Limits, Reason, SwarmLoss};
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::frame::Frame;
use sitl_bridge::node::{Settings, gate_limits};

/// Setpoints and decisions that a flight of this many ticks has.
const TICKS: u32 = 100;
const STEPS: usize = 10;

fn uav(id: u16, x: f32, change: impl FnOnce(&mut Settings<'static>)) -> Flight {
    let mission = mission();
    let mut settings = settings(id, &mission, true);
    settings.limits = gate_limits(Limits::default(), &mission);
    change(&mut settings);
    Flight::with(settings, Firmware::ArduPilot, Vec2::from_u(x, 100.0))
}

/// Both tick; `heard` says what the first hears of the second.
fn together(a: &mut Flight, b: &mut Flight, ticks: u32, mut heard: impl FnMut(&Frame) -> bool) {
    for _ in 0..ticks {
        let (from_a, from_b) = (a.tick(), b.tick());
        from_b.iter().filter(|frame| heard(frame)).for_each(|frame| a.hear_swarm(frame));
        from_a.iter().for_each(|frame| b.hear_swarm(frame));
    }
}

/// UAV 1 and its neighbour 2, in flight and in touch.
fn pair(a: Flight, b: Flight) -> (Flight, Flight) {
    let (mut a, mut b) = (a, b);
    for _ in 0..60 {
        together(&mut a, &mut b, 5, |_| true);
        if a.decisions.last().is_some_and(|d| d.neighbours() == [2]) {
            a.decisions.clear();
            return (a, b);
        }
    }
    panic!("not in touch: {:?}", a.words());
}

fn two() -> (Flight, Flight) {
    pair(uav(1, 100.0, |_| {}), uav(2, 104.0, |_| {}))
}

/// Over `TICKS` from `setpoints` on it flew on: no setpoint and no decision is missing.
fn flew_on(a: &Flight, setpoints: usize) {
    // An answer to each position, and one more with each decision between two.
    let answers = TICKS as usize..=TICKS as usize + STEPS;
    assert!(answers.contains(&(a.vehicle.setpoints.len() - setpoints)), "{:?}", a.words());
    // The neighbour's message that completes a step may come in the next tick.
    assert!((STEPS - 1..=STEPS + 1).contains(&a.decisions.len()), "{} decisions", a.decisions.len());
    assert_eq!(a.node.counters().missed_decisions, 0);
    assert_eq!(a.node.verdict().reason(), None);
}

fn rejected(a: &Flight, reason: &str) -> u64 {
    a.node.counters().rejected.get(reason).copied().unwrap_or(0)
}

#[test]
fn neighbour_vanishes() {
    let (mut a, mut b) = two();
    let before = a.vehicle.setpoints.len();
    together(&mut a, &mut b, TICKS, |_| false);
    flew_on(&a, before);
    // Its last beacon counts for two steps more.
    assert!(a.decisions[3..].iter().all(|d| d.neighbours().is_empty() && d.features == 0), "{:?}", a.decisions);
}

#[test]
fn neighbour_teleports() {
    let (mut a, mut b) = two();
    let before = a.vehicle.setpoints.len();
    b.vehicle.place.east_mm += 120_000.0;
    together(&mut a, &mut b, TICKS, |_| true);
    flew_on(&a, before);
    // Once not believed, then confirmed where it is: out of range.
    assert_eq!(rejected(&a, "suspicious"), 1, "{:?}", a.node.counters());
    assert!(a.decisions[3..].iter().all(|d| d.neighbours().is_empty()));
    // One that never is twice in one place is never believed.
    let (mut a, mut b) = two();
    let before = a.vehicle.setpoints.len();
    for jump in 0..10 {
        let to_and_fro = if jump % 2 == 0 { 1.0 } else { -1.0 };
        b.vehicle.place.north_mm += to_and_fro * 90_000.0;
        together(&mut a, &mut b, TICKS / 10, |_| true);
    }
    flew_on(&a, before);
    assert!(rejected(&a, "suspicious") >= 4, "{:?}", a.node.counters());
}

/// UAV 1 of [`two`] after it has flown on over `TICKS`, while it also heard `twin`.
fn beside_a_twin(mut twin: Flight) -> Flight {
    let (mut a, mut b) = two();
    twin.until(60, |f| f.node.stage() == Stage::Flying);
    let before = a.vehicle.setpoints.len();
    for _ in 0..TICKS {
        for frame in twin.tick() {
            a.hear_swarm(&frame);
        }
        together(&mut a, &mut b, 1, |_| true);
    }
    flew_on(&a, before);
    a
}

#[test]
fn id_collision() {
    // Another says that it is 2, from somewhere else.
    let a = beside_a_twin(uav(2, 92.0, |_| {}));
    assert!(a.decisions.iter().all(|d| d.neighbours().len() <= 1), "one id, one neighbour");
    // Another says that it is 1, as this UAV does.
    let a = beside_a_twin(uav(1, 104.0, |_| {}));
    assert!(rejected(&a, "id_collision") + rejected(&a, "own_id") > 10, "{:?}", a.node.counters());
    // In the end they are out of each other's range.
    assert!(a.decisions[..5].iter().all(|d| d.neighbours() == [2]), "the real neighbour counts");
    assert!(a.decisions.iter().all(|d| d.neighbours().len() <= 1), "and nobody else");
}

#[test]
fn foreign_actor_hash() {
    let bytes = include_bytes!("../../../firmware-core/tests/data/sample-gat.actor");
    let foreign = Actor::load(bytes).unwrap();
    let (mut a, mut b) = pair(uav(1, 100.0, |_| {}), uav(2, 104.0, |s| s.actor = foreign));
    let (before, refused) = (a.vehicle.setpoints.len(), rejected(&a, "foreign_actor"));
    together(&mut a, &mut b, TICKS, |_| true);
    flew_on(&a, before);
    assert_eq!(rejected(&a, "foreign_actor") - refused, STEPS as u64);
    // It is seen, as long as it is in range, and not listened to.
    assert!(a.decisions[..5].iter().all(|d| d.neighbours() == [2]), "{:?}", a.decisions);
    assert!(a.decisions.iter().all(|d| d.features == 0), "{:?}", a.decisions);
}

#[test]
fn swarm_link_cut() {
    // Nothing comes and nothing goes: each flies on alone.
    let (mut a, _) = two();
    let before = a.vehicle.setpoints.len();
    a.ticks(TICKS);
    flew_on(&a, before);
    // Who is told to hold then does so in time, and flies on when others are heard again.
    let holds = |s: &mut Settings<'static>| s.limits.swarm_loss = SwarmLoss::Hold;
    let (mut a, mut c) = pair(uav(1, 100.0, holds), uav(2, 104.0, |_| {}));
    c.until(3, |f| f.told.last().is_some_and(|t| t.0 == f.vehicle.boot_ms));
    together(&mut a, &mut c, 10, |_| true);
    let limits = gate_limits(Limits::default(), &mission());
    let deadline = Reason::SwarmLost.deadline_ms(&limits).div_ceil(200);
    let lost = (0..=deadline + 10).find(|_| {
        together(&mut a, &mut c, 1, |_| false);
        a.node.verdict().reason() == Some(Reason::SwarmLost)
    });
    assert!(lost.is_some_and(|ticks| ticks <= deadline), "{lost:?} ticks, {deadline} are allowed");
    assert_eq!(a.node.verdict().name(), "hold");
    together(&mut a, &mut c, 15, |_| true);
    assert_eq!(a.node.verdict().reason(), None, "{:?}", a.words());
}

#[test]
fn in_takeoff_neighbours_change_nothing() {
    let bring_up = |speak: bool| {
        let mut a = uav(1, 100.0, |_| {});
        let mut others = [uav(2, 104.0, |_| {}), uav(2, 92.0, |_| {}), uav(3, 108.0, |_| {})];
        others.iter_mut().for_each(|other| assert!(other.until(60, |f| f.node.stage() == Stage::Flying)));
        let mut ticks = 0;
        while a.node.stage() != Stage::Flying {
            a.tick();
            ticks += 1;
            assert!(ticks < 500, "{:?}", a.words());
            for other in &mut others {
                other.vehicle.place.east_mm += if ticks % 20 == 0 { 50_000.0 } else { 0.0 };
                other.tick().iter().filter(|_| speak).for_each(|frame| a.hear_swarm(frame));
            }
        }
        (ticks, a.vehicle.commands)
    };
    assert_eq!(bring_up(true), bring_up(false));
}

#[test]
fn beacons_and_features_are_counted_each_by_themselves() {
    let mut a = uav(1, 100.0, |_| {});
    a.node.set_sequence(u16::MAX - 5);
    assert!(a.until(90, |f| f.decisions.len() > 15), "{:?}", a.words());
    for kind in [1, 2] {
        // V2_EXTENSION's own fields come first: type and target.
        let payloads = a.told.iter().map(|(_, frame)| &frame.payload()[5..]).filter(|p| p[1] == kind);
        let sequences: Vec<u16> = payloads.map(|p| u16::from_le_bytes([p[4], p[5]])).collect();
        let expected: Vec<u16> = (0..sequences.len() as u16).map(|i| (u16::MAX - 5).wrapping_add(i)).collect();
        assert!(sequences.len() > 14 && sequences == expected, "{sequences:?}");
    }
}
