//! The account of a flight: coverage, and the comparison with the trainer.

use super::trainer::{self, Reviewer, TrainerFlight, covered_share, is_same};
use super::{Simulation, WorldFlight, policy_seed};
use crate::node::Decision;
use covey_env::World;
use firmware_core::action::Action;
use firmware_core::geometry::State;
use serde_json::Value;

/// Share of PoIs covered from positions in u.
pub(super) fn true_share(world: &World, positions: &Value) -> Option<f64> {
    let places: Option<Vec<(f32, f32)>> = positions
        .as_array()?
        .iter()
        .map(|place| Some((place[0].as_f64()? as f32, place[1].as_f64()? as f32)))
        .collect();
    share_at(world, &places?)
}

/// Share of PoIs covered from these places; outside the map counts as its edge.
fn share_at(world: &World, places: &[(f32, f32)]) -> Option<f64> {
    let side = world.scenario().side_u;
    let inside: Vec<_> = places.iter().map(|&(x, y)| (x.clamp(0.0, side), y.clamp(0.0, side))).collect();
    let pois: Vec<_> = world.poi_x().iter().copied().zip(world.poi_y().iter().copied()).collect();
    let mut scene = world.clone();
    scene.set_positions(&inside, &pois).ok()?;
    Some(covered_share(&scene))
}

/// Compares with the trainer.
pub(super) fn account(sim: &Simulation<'_>, index: u64, world: &World, flight: &mut WorldFlight) {
    let policy_seed = policy_seed(sim.seed, index);
    let trained = trainer::fly(world.clone(), sim.actor, policy_seed, sim.mode);
    for row in flight.states.iter().skip(1) {
        let known: Vec<(f32, f32)> = row.iter().flatten().map(|state| state.position.to_u()).collect();
        // With a UAV unknown there is no state to score; the fleet's truth has them all.
        let share = if known.len() == row.len() { share_at(world, &known) } else { None };
        flight.coverage.push(share.unwrap_or_else(|| flight.coverage.last().copied().unwrap_or(0.0)));
    }
    if sim.ideal {
        compare_flights(&trained, flight);
    } else {
        review(Reviewer::new(world.clone(), sim.actor, policy_seed, sim.mode), flight);
    }
    flight.trainer = trained.metrics;
    flight.trainer_coverage = trained.coverage;
}

fn compare_flights(trained: &TrainerFlight, flight: &mut WorldFlight) {
    for (step, row) in flight.decisions.iter().enumerate() {
        for (id, decision) in row.iter().enumerate() {
            let Some(decision) = decision else { continue };
            flight.compared += 1;
            let same = is_same(decision, trained.observations[step][id], trained.actions[step][id]);
            flight.equal += u64::from(same);
            if !same && flight.first_difference.is_none() {
                let (observation, action) = (trained.observations[step][id], trained.actions[step][id]);
                flight.first_difference = Some(difference(id, decision, observation, action));
            }
        }
    }
}

/// A decision that is not the trainer's, in words.
fn difference(id: usize, decision: &Decision, observation: u64, action: Action) -> String {
    let seen = if decision.observation == observation { "the same" } else { "another" };
    let ((x, y), (vx, vy)) = (decision.state.position.to_u(), decision.state.velocity.to_u());
    format!(
        "step {}, UAV {id} at ({x}, {y}) u with ({vx}, {vy}) u/step: action {} on {seen} observation, the trainer's is {}; \
         neighbours {:?}, {} of them with a feature",
        decision.step,
        decision.action,
        action.index(),
        decision.neighbours(),
        decision.features,
    )
}

fn review(mut reviewer: Reviewer<'_>, flight: &mut WorldFlight) {
    for (step, row) in flight.decisions.iter().enumerate() {
        let states: Option<Vec<State>> = flight.states[step].iter().copied().collect();
        let Some(expected) = states.and_then(|states| reviewer.review(step as u32, &states)) else { continue };
        for (id, (decision, (observation, action))) in (0u16..).zip(row.iter().zip(expected)) {
            let Some(decision) = decision else { continue };
            flight.compared += 1;
            let same = is_same(decision, observation, action);
            flight.equal += u64::from(same);
            if !same && flight.first_difference.is_none() {
                flight.first_difference = Some(difference(usize::from(id), decision, observation, action));
            }
        }
    }
}
