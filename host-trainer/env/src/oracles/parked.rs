//! The oracle that starts at its sites.

use super::targets::targets;
use crate::baselines::Hover;
use crate::evaluation::{Evaluation, evaluate_with};
use crate::scenario::{Scenario, ScenarioError};
use crate::world::World;

/// Evaluates UAVs that stand at the best static sites from the start, on worlds 0 to `worlds` − 1 of `seed`: an upper
/// bound on the coverage of any policy, since no state covers more PoIs than the maximum cover.
///
/// # Errors
/// [`ScenarioError`] when the scenario is not valid.
pub fn evaluate_parked(scenario: &Scenario, seed: u64, worlds: u64) -> Result<Evaluation, ScenarioError> {
    evaluate_with(scenario, worlds, |world, index| {
        spawn_parked(world, seed, index);
        Hover
    })
}

/// Puts world `index` of `seed` into its spawn state, but with UAVs that stand at the best static sites.
pub fn spawn_parked(world: &mut World, seed: u64, index: u64) {
    world.reset(seed, index);
    world.respawn(&targets(world));
}
