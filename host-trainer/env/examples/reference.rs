//! Baselines and oracles on held-out worlds: the figures every policy is compared with.
//!
//! `cargo run --release -p covey-env --example reference [WORLDS [SEED]]`

use covey_env::baselines::{Centroid, Follower, Greedy, Hover, Planner, Random, RelayingPlanner, RememberingPlanner};
use covey_env::oracles::cover::best_sites;
use covey_env::oracles::{FlyToSites, evaluate_parked};
use covey_env::{EpisodeMetrics, Evaluation, PoiDistribution, Scenario, ScenarioError, World, evaluate, policy_seed};
use firmware_core::memory::MAX_KNOWLEDGE;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let worlds = args.next().map_or(Ok(200), |a| a.parse())?;
    let seed = args.next().map_or(Ok(777), |a| a.parse())?;
    print!("{:22}", "");
    EpisodeMetrics::NAMES.iter().for_each(|name| print!("{name:>17}"));
    println!();
    for distribution in [PoiDistribution::Clustered, PoiDistribution::Uniform] {
        let scenario = Scenario { distribution, ..Scenario::default() };
        show(distribution, "random", || evaluate(&scenario, seed, worlds, |i| Random::new(seed, i)))?;
        show(distribution, "hover", || evaluate(&scenario, seed, worlds, |_| Hover))?;
        show(distribution, "greedy", || evaluate(&scenario, seed, worlds, |_| Greedy::new()))?;
        show(distribution, "centroid", || evaluate(&scenario, seed, worlds, |i| Centroid::new(seed, i)))?;
        show(distribution, "follower", || evaluate(&scenario, seed, worlds, |i| Follower::new(policy_seed(seed, i))))?;
        show(distribution, "planner", || evaluate(&scenario, seed, worlds, |_| Planner::new()))?;
        show(distribution, "remembering", || evaluate(&scenario, seed, worlds, |_| RememberingPlanner::new()))?;
        show(distribution, "relaying", || evaluate(&scenario, seed, worlds, |_| RelayingPlanner::new(MAX_KNOWLEDGE)))?;
        show(distribution, "oracle", || evaluate(&scenario, seed, worlds, |_| FlyToSites::new()))?;
        show(distribution, "parked", || evaluate_parked(&scenario, seed, worlds))?;
        prove(&scenario, seed, worlds)?;
    }
    Ok(())
}

fn show(
    distribution: PoiDistribution,
    name: &str,
    run: impl Fn() -> Result<Evaluation, ScenarioError>,
) -> Result<(), ScenarioError> {
    let start = std::time::Instant::now();
    let evaluation = run()?;
    print!("{:22}", format!("{distribution:?} {name}"));
    let (mean, error) = (evaluation.mean().values(), evaluation.standard_error().values());
    mean.iter().zip(error).for_each(|(m, e)| print!("{:>17}", format!("{m:.3} ±{e:.3}")));
    println!("{:8.2} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// How many maximum covers are proven optimal, and what that costs.
fn prove(scenario: &Scenario, seed: u64, worlds: u64) -> Result<(), ScenarioError> {
    let start = std::time::Instant::now();
    let mut world = World::new(scenario)?;
    let (mut proven, mut gap, mut nodes) = (0, 0, 0);
    for index in 0..worlds {
        world.reset(seed, index);
        let cover = best_sites(&world);
        proven += u64::from(cover.proven);
        gap += cover.upper_bound - cover.covered;
        nodes += cover.nodes;
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "maximum cover: {proven} of {worlds} proven, {gap} PoIs of gap, {nodes} nodes, {seconds:.2} s on one thread"
    );
    Ok(())
}
