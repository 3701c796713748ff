//! Flying a policy through many worlds.

use super::result::Evaluation;
use super::rollout::rollout;
use crate::policy::Policy;
use crate::scenario::{Scenario, ScenarioError};
use crate::world::World;
use rayon::prelude::*;

/// Seed of the on-board random numbers (tie-breakers, drawn actions) of a policy in held-out world `index` of `seed`.
/// For evaluation alone: training derives its policy seeds with another constant.
#[must_use]
pub const fn policy_seed(seed: u64, index: u64) -> u64 {
    (seed ^ 0x6576_616c).wrapping_add(index.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Evaluates a policy on worlds 0 to `worlds` − 1 of `seed`, in parallel. `factory` makes the policy of each world
/// from its index. The result does not depend on the number of threads.
///
/// # Errors
/// [`ScenarioError`] when the scenario is not valid.
pub fn evaluate<P: Policy>(
    scenario: &Scenario,
    seed: u64,
    worlds: u64,
    factory: impl Fn(u64) -> P + Sync,
) -> Result<Evaluation, ScenarioError> {
    evaluate_with(scenario, worlds, |world, index| {
        world.reset(seed, index);
        factory(index)
    })
}

/// [`evaluate`] from spawn states of the caller's choice: `set_up` puts the given world into the spawn state of an
/// index and makes its policy.
///
/// # Errors
/// [`ScenarioError`] when the scenario is not valid.
pub fn evaluate_with<P: Policy>(
    scenario: &Scenario,
    worlds: u64,
    set_up: impl Fn(&mut World, u64) -> P + Sync,
) -> Result<Evaluation, ScenarioError> {
    let fresh = World::new(scenario)?;
    let worlds = (0..worlds).into_par_iter().map_init(
        || fresh.clone(),
        |world, index| {
            let mut policy = set_up(world, index);
            rollout(world, &mut policy, |_| {});
            world.metrics()
        },
    );
    Ok(Evaluation { worlds: worlds.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baselines::{Centroid, Random};

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let scenario = Scenario { steps: 20, ..Scenario::default() };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let random = evaluate(&scenario, 5, 9, |i| Random::new(1, i)).unwrap();
                let centroid = evaluate(&scenario, 5, 9, |i| Centroid::new(1, i)).unwrap();
                (random, centroid)
            })
        };
        assert_eq!(on(1), on(3));
    }
}
