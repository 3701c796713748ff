//! The comparison of a flight with the trainer's evaluation: coverage and decisions.

use super::coverage::share_at;
use super::reference::{ReferenceEvaluation, ReferenceFlight, fly_reference, is_same};
use super::settings::Simulation;
use super::world_flight::WorldFlight;
use crate::node::Decision;
use covey_env::{World, policy_seed};
use firmware_core::action::Action;
use firmware_core::geometry::State;

/// Fills in the flight's coverage and its comparison with the trainer's evaluation of the same world.
pub(super) fn compare(sim: &Simulation<'_>, index: u64, world: &World, flight: &mut WorldFlight) {
    let policy_seed = policy_seed(sim.seed, index);
    let trained = fly_reference(world.clone(), sim.actor, policy_seed, sim.mode);
    for row in flight.states.iter().skip(1) {
        let known: Vec<(f32, f32)> = row.iter().flatten().map(|state| state.position.to_u()).collect();
        // With the state of a UAV unknown the coverage cannot be computed: the last one is kept.
        let share = if known.len() == row.len() { share_at(world, &known) } else { None };
        flight.coverage.push(share.unwrap_or_else(|| flight.coverage.last().copied().unwrap_or(0.0)));
    }
    if sim.ideal {
        compare_flights(&trained, flight);
    } else {
        compare_situations(ReferenceEvaluation::new(world.clone(), sim.actor, policy_seed, sim.mode), flight);
    }
    flight.trainer = trained.metrics;
    flight.trainer_coverage = trained.coverage;
}

fn compare_flights(trained: &ReferenceFlight, flight: &mut WorldFlight) {
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

/// A decision that differs from the trainer's, in words.
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

fn compare_situations(mut evaluation: ReferenceEvaluation<'_>, flight: &mut WorldFlight) {
    for (step, row) in flight.decisions.iter().enumerate() {
        // The states that were observed, which are ahead of those measured.
        let states: Option<Vec<State>> = row.iter().map(|decision| Some((*decision)?.state)).collect();
        let Some(expected) = states.and_then(|states| evaluation.evaluate(step as u32, &states)) else { continue };
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
