//! When a UAV decides: as soon as all who are expected were heard, and at the deadlines where somebody is not.

use crate::flight::{Flight, mission, settings};
use firmware_core::geometry::Vec2;
use firmware_core::message::Message;
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::frame::Frame;
use sitl_bridge::node::{Pace, Settings};
use sitl_bridge::swarm_link::neighbour_message;

/// Ticks in a step.
const STEP: u32 = 10;

fn uav(id: u16, x: f32, change: impl FnOnce(&mut Settings<'static>)) -> Flight {
    let mut settings = settings(id, &mission(), true);
    change(&mut settings);
    Flight::with(settings, Firmware::ArduPilot, Vec2::from_u(x, 100.0))
}

fn is_beacon(frame: &Frame) -> bool {
    matches!(neighbour_message(frame), Some(Message::Beacon(_)))
}

/// Passes messages on until nobody says anything more; `lost` says which are not heard.
fn exchange(swarm: &mut [Flight], mut told: Vec<(usize, Frame)>, lost: &impl Fn(usize, usize, &Frame) -> bool) {
    while !told.is_empty() {
        for (from, frame) in std::mem::take(&mut told) {
            for to in (0..swarm.len()).filter(|&to| to != from && !lost(from, to, &frame)) {
                swarm[to].hear_swarm(&frame);
            }
        }
        for (id, flight) in swarm.iter_mut().enumerate() {
            told.extend(flight.idle(0).into_iter().map(|frame| (id, frame)));
        }
    }
}

/// Ticks of the whole swarm, with everything said at once. `lost(from, to, frame)`.
fn fly(swarm: &mut [Flight], ticks: u32, lost: impl Fn(usize, usize, &Frame) -> bool) {
    for _ in 0..ticks {
        let mut told = Vec::new();
        for (id, flight) in swarm.iter_mut().enumerate() {
            told.extend(flight.tick().into_iter().map(|frame| (id, frame)));
        }
        exchange(swarm, told, &lost);
    }
}

/// A swarm in flight whose UAVs have seen each other, at the last tick of a step.
fn swarm(flights: Vec<Flight>) -> Vec<Flight> {
    let mut swarm = flights;
    stay(&mut swarm);
    let all = swarm.len();
    for _ in 0..600 {
        fly(&mut swarm, 1, |_, _, _| false);
        let ready =
            |f: &Flight| f.decisions.len() > 3 && f.decisions.last().is_some_and(|d| d.neighbours().len() + 1 == all);
        let begun = swarm[0].begun.last().map(|step| step.step);
        if swarm.iter().all(ready) && swarm[0].decisions.last().map(|d| d.step) == begun {
            fly(&mut swarm, STEP - 1, |_, _, _| false);
            clear(&mut swarm);
            return swarm;
        }
    }
    panic!("not in touch: {:?}", swarm[0].words());
}

fn clear(swarm: &mut [Flight]) {
    for flight in swarm {
        flight.decisions.clear();
        flight.begun.clear();
        flight.vehicle.setpoints.clear();
    }
}

/// Times of the decisions after their steps' starts, ms.
fn phases(flight: &Flight) -> Vec<u32> {
    flight.decisions.iter().map(|decision| decision.phase_ms).collect()
}

/// They move slowly whatever they are asked, so that they stay in range.
fn stay(swarm: &mut [Flight]) {
    for flight in swarm {
        flight.vehicle.acceleration_mps2 = Some(0.5);
    }
}

fn pair() -> Vec<Flight> {
    swarm(vec![uav(1, 100.0, |_| {}), uav(2, 104.0, |_| {})])
}

#[test]
fn all_decide_at_the_step_s_start_when_all_are_heard() {
    let mut three = swarm(vec![uav(1, 100.0, |_| {}), uav(2, 104.0, |_| {}), uav(3, 108.0, |_| {})]);
    fly(&mut three, 5 * STEP, |_, _, _| false);
    for flight in &three {
        assert_eq!(phases(flight), [0; 5], "{:?}", flight.words());
        assert!(flight.decisions.iter().all(|d| d.neighbours().len() == 2 && d.features == 2 && !d.late));
    }
}

#[test]
fn a_decision_between_two_positions_is_flown_at_once() {
    let mut two = pair();
    fly(&mut two, 5 * STEP, |_, _, _| false);
    for flight in &two {
        let setpoints = &flight.vehicle.setpoints;
        // An answer to each position, and one more with each decision.
        assert_eq!(setpoints.len() as u32, 5 * STEP + 5);
        for decision in &flight.decisions {
            let then = setpoints.iter().filter(|setpoint| setpoint.at_ms == decision.boot_ms).count();
            assert_eq!(then, 2, "with the position and with the decision");
        }
    }
}

#[test]
fn in_the_first_step_it_waits_for_the_deadline() {
    // Alone nobody is known, and afterwards nobody is expected.
    let mut alone = uav(1, 100.0, |_| {});
    assert!(alone.until(90, |f| f.decisions.len() == 3), "{:?}", alone.words());
    assert_eq!(phases(&alone), [400, 0, 0]);
    // Whoever joins does not know who is there; those who were there before decide without it.
    let mut two = vec![uav(1, 100.0, |_| {}), uav(2, 104.0, |s| s.take_off = false)];
    stay(&mut two);
    fly(&mut two, 300, |_, _, _| false);
    assert!(two[0].decisions.len() > 3 && two[1].decisions.is_empty(), "{:?}", two[0].words());
    clear(&mut two);
    two[1].node.start();
    for _ in 0..600 {
        fly(&mut two, 1, |_, _, _| false);
        if two[1].decisions.len() == 3 {
            break;
        }
    }
    assert_eq!(phases(&two[1]), [400, 0, 0]);
    assert_eq!(two[1].decisions[0].neighbours(), [1]);
    assert!(phases(&two[0]).iter().all(|&phase| phase == 0), "{:?}", phases(&two[0]));
}

#[test]
fn a_lost_beacon_is_waited_for_until_the_deadline() {
    let mut two = pair();
    // The first hears nothing of the second for a step: no beacon, no feature.
    fly(&mut two, STEP, |from, _, _| from == 1);
    assert_eq!((phases(&two[0]), phases(&two[1])), (vec![400], vec![400]), "the second waits for the feature");
    fly(&mut two, STEP, |_, _, _| false);
    assert_eq!((phases(&two[0]), phases(&two[1])), (vec![400, 0], vec![400, 0]));
    // One that stays away is expected for two steps.
    clear(&mut two);
    fly(&mut two, 5 * STEP, |from, _, _| from == 1);
    assert_eq!(phases(&two[0]), [400, 400, 0, 0, 0]);
}

#[test]
fn a_lost_feature_is_waited_for_until_the_deadline() {
    let mut two = pair();
    fly(&mut two, STEP, |from, _, frame| from == 1 && !is_beacon(frame));
    assert_eq!((phases(&two[0]), phases(&two[1])), (vec![800], vec![0]));
    assert!(!two[0].decisions[0].late);
    assert_eq!(two[0].decisions[0].neighbours(), [2]);
    // Of one that sends none they are not expected any more, and expected again once one came.
    fly(&mut two, 3 * STEP, |from, _, frame| from == 1 && !is_beacon(frame));
    assert_eq!(phases(&two[0]), [800, 800, 0, 0]);
    fly(&mut two, 2 * STEP, |_, _, _| false);
    fly(&mut two, STEP, |from, _, frame| from == 1 && !is_beacon(frame));
    assert_eq!(phases(&two[0])[6], 800);
}

#[test]
fn one_out_of_range_is_not_waited_for() {
    let mut three = vec![uav(1, 100.0, |_| {}), uav(2, 104.0, |_| {}), uav(3, 160.0, |_| {})];
    three = swarm_of_two(three);
    fly(&mut three, 3 * STEP, |from, _, _| from == 2);
    assert_eq!((phases(&three[0]), phases(&three[1])), (vec![0; 3], vec![0; 3]));
}

/// Three in flight, of whom the first two see each other.
fn swarm_of_two(mut three: Vec<Flight>) -> Vec<Flight> {
    for _ in 0..600 {
        fly(&mut three, 1, |_, _, _| false);
        let (begun, decided) = (three[0].begun.last().map(|s| s.step), three[0].decisions.last().map(|d| d.step));
        if three.iter().all(|f| f.decisions.len() > 3) && begun == decided {
            fly(&mut three, STEP - 1, |_, _, _| false);
            clear(&mut three);
            return three;
        }
    }
    panic!("not in flight: {:?}", three[2].words());
}

#[test]
fn who_decides_at_deadlines_does_so_at_positions() {
    let late = |s: &mut Settings<'static>| s.timing.pace = Pace::Deadlines;
    let mut two = vec![uav(1, 100.0, late), uav(2, 104.0, late)];
    for _ in 0..600 {
        fly(&mut two, 1, |_, _, _| false);
    }
    let (seen, phases) = (two[0].decisions.iter().filter(|d| d.features == 1).count(), phases(&two[0]));
    assert!(seen > 3 && phases.iter().all(|&phase| phase == 800), "{seen} {phases:?}");
}

#[test]
fn in_lock_step_the_answer_waits_for_the_decision() {
    let lock_step = |s: &mut Settings<'static>| s.timing.pace = Pace::LockStep;
    let mut two = swarm(vec![uav(1, 100.0, lock_step), uav(2, 104.0, lock_step)]);
    fly(&mut two, 5 * STEP, |_, _, _| false);
    for flight in &two {
        assert_eq!(phases(flight), [0; 5]);
        assert_eq!(flight.vehicle.setpoints.len() as u32, 5 * STEP, "one answer to each position");
    }
    // What does not come is not waited for: a second, by the host's clock.
    clear(&mut two);
    let mut alone = two.swap_remove(0);
    alone.tick();
    alone.idle(900);
    assert_eq!((alone.begun.len(), alone.vehicle.setpoints.len()), (1, 0));
    alone.idle(100);
    assert_eq!((alone.decisions.len(), alone.vehicle.setpoints.len()), (0, 1));
    assert_eq!(alone.node.stage(), Stage::Flying);
}
