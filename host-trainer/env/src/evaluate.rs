//! Policies measured on many worlds.

use crate::metrics::EpisodeMetrics;
use crate::policy::Policy;
use crate::scenario::{Scenario, ScenarioError};
use crate::world::World;
use firmware_core::action::Action;
use rayon::prelude::*;

/// Seed of the on-board random numbers in held-out world `index` of `seed`.
#[must_use]
pub const fn policy_seed(seed: u64, index: u64) -> u64 {
    (seed ^ 0x6576_616c).wrapping_add(index.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Metrics of a policy, world by world.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Metrics of each world, by its index.
    pub worlds: Vec<EpisodeMetrics>,
}

impl Evaluation {
    /// Mean over worlds of each metric; not a number when there are no worlds.
    #[must_use]
    pub fn mean(&self) -> EpisodeMetrics {
        let n = self.worlds.len() as f64;
        EpisodeMetrics::from_values(self.sums(|v, _| v).map(|s| s / n))
    }

    /// Standard error of each mean: the sample deviation over worlds / √worlds. Not a
    /// number for fewer than two worlds.
    #[must_use]
    pub fn standard_error(&self) -> EpisodeMetrics {
        let n = self.worlds.len() as f64;
        let squares = self.sums(|v, mean| (v - mean) * (v - mean));
        EpisodeMetrics::from_values(squares.map(|s| (s / (n - 1.0) / n).sqrt()))
    }

    /// Sums `f(value, mean)` over worlds, for each metric.
    fn sums(&self, f: impl Fn(f64, f64) -> f64) -> [f64; 7] {
        let n = self.worlds.len() as f64;
        let add = |mut a: [f64; 7], v: [f64; 7]| {
            a.iter_mut().zip(v).for_each(|(a, v)| *a += v);
            a
        };
        let values = || self.worlds.iter().map(EpisodeMetrics::values);
        let mean = values().fold([0.0; 7], add).map(|s| s / n);
        values().map(|v| std::array::from_fn(|k| f(v[k], mean[k]))).fold([0.0; 7], add)
    }
}

/// Flies worlds 0 to `worlds` − 1 of `seed` with the policies that `factory` makes for
/// each index. The result does not depend on the number of threads.
///
/// # Errors
/// When the scenario is not valid.
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

/// [`evaluate`] with worlds of one's own: `set_up` puts the given world into the spawn
/// state of an index and makes its policy.
///
/// # Errors
/// When the scenario is not valid.
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
            fly(world, &mut policy, |_| {});
            world.metrics()
        },
    );
    Ok(Evaluation { worlds: worlds.collect() })
}

/// Flies a world from its spawn state to the end of the episode; `watch` sees every
/// state, the spawn state first.
pub(crate) fn fly<P: Policy + ?Sized>(world: &mut World, policy: &mut P, mut watch: impl FnMut(&World)) {
    let mut actions = vec![Action::COAST; world.scenario().uavs];
    policy.begin(world);
    watch(world);
    while !world.done() {
        policy.act(world, &mut actions);
        world.step(&actions);
        watch(world);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baselines::{Centroid, Random};

    #[test]
    fn mean_and_standard_error() {
        let world = |coverage| EpisodeMetrics { coverage, ..EpisodeMetrics::default() };
        let e = Evaluation { worlds: vec![world(1.0), world(2.0), world(3.0), world(4.0)] };
        assert_eq!(e.mean().coverage, 2.5);
        assert!((e.standard_error().coverage - (5.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
        assert_eq!(e.standard_error().energy, 0.0);
    }

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
