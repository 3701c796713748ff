//! Baselines and oracles against the scenario's reference figures, on fewer worlds.
//! The full check is the example `reference`.

use covey_env::baselines::{Centroid, Follower, Greedy, Hover, Planner, Random, RelayingPlanner, RememberingPlanner};
use covey_env::oracles::{FlyToSites, evaluate_parked};
use covey_env::{Evaluation, PoiDistribution, Scenario, evaluate, policy_seed};
use firmware_core::memory::MAX_KNOWLEDGE;

const WORLDS: u64 = 40;
const SEED: u64 = 777;

fn scenario(distribution: PoiDistribution) -> Scenario {
    Scenario { distribution, ..Scenario::default() }
}

/// Means within 0.02 of the figure, besides what chance does with so few worlds.
fn assert_coverage(evaluation: &Evaluation, figure: f64) {
    let (mean, error) = (evaluation.mean().coverage, evaluation.standard_error().coverage);
    assert!((mean - figure).abs() < 0.02 + 2.0 * error, "coverage {mean:.3} ± {error:.3}, reference {figure}");
}

fn assert_reward(evaluation: &Evaluation, figure: f64) {
    let (mean, error) = (evaluation.mean().reward, evaluation.standard_error().reward);
    assert!((mean - figure).abs() < 0.05 * figure + 2.0 * error, "reward {mean:.0} ± {error:.0}, reference {figure}");
}

fn assert_energy(evaluation: &Evaluation, figure: f64) {
    let mean = evaluation.mean().energy;
    assert!((mean - figure).abs() < 0.02, "energy {mean:.3}, reference {figure}");
}

#[test]
fn random_and_hover() {
    for (distribution, random, hover) in
        [(PoiDistribution::Clustered, 0.15, 0.19), (PoiDistribution::Uniform, 0.136, 0.144)]
    {
        let s = scenario(distribution);
        let r = evaluate(&s, SEED, WORLDS, |i| Random::new(1, i)).unwrap();
        assert_coverage(&r, random);
        assert_energy(&r, 0.91);
        let h = evaluate(&s, SEED, WORLDS, |_| Hover).unwrap();
        assert_coverage(&h, hover);
        assert_energy(&h, 0.5);
        assert_eq!(h.mean().coverage, h.mean().coverage_last);
    }
}

#[test]
fn greedy() {
    let e = evaluate(&scenario(PoiDistribution::Clustered), SEED, WORLDS, |_| Greedy::new()).unwrap();
    assert_coverage(&e, 0.365);
    assert_energy(&e, 0.61);
    assert_reward(&e, 391.0);
    assert_coverage(&evaluate(&scenario(PoiDistribution::Uniform), SEED, WORLDS, |_| Greedy::new()).unwrap(), 0.286);
}

#[test]
fn centroid() {
    let e = evaluate(&scenario(PoiDistribution::Clustered), SEED, WORLDS, |i| Centroid::new(1, i)).unwrap();
    assert_coverage(&e, 0.56);
    assert_energy(&e, 0.69);
    assert_reward(&e, 510.0);
    assert_coverage(
        &evaluate(&scenario(PoiDistribution::Uniform), SEED, WORLDS, |i| Centroid::new(1, i)).unwrap(),
        0.349,
    );
}

#[test]
fn follower() {
    for (distribution, coverage, reward) in
        [(PoiDistribution::Clustered, 0.592, 536.0), (PoiDistribution::Uniform, 0.373, 341.0)]
    {
        let e = evaluate(&scenario(distribution), SEED, WORLDS, |i| Follower::new(policy_seed(SEED, i))).unwrap();
        assert_coverage(&e, coverage);
        assert_reward(&e, reward);
    }
}

#[test]
fn planners() {
    for (distribution, alone, remembering) in
        [(PoiDistribution::Clustered, 0.60, 0.665), (PoiDistribution::Uniform, 0.405, 0.451)]
    {
        let e = evaluate(&scenario(distribution), SEED, WORLDS, |_| Planner::new()).unwrap();
        assert_coverage(&e, alone);
        if distribution == PoiDistribution::Clustered {
            assert_reward(&e, 563.0);
        }
        let e = evaluate(&scenario(distribution), SEED, WORLDS / 4, |_| RememberingPlanner::new()).unwrap();
        assert_coverage(&e, remembering);
    }
}

#[test]
fn relayed_knowledge_is_worth_its_bytes() {
    let relaying = |distribution, bytes| {
        evaluate(&scenario(distribution), SEED, WORLDS / 4, |_| RelayingPlanner::new(bytes)).unwrap()
    };
    for (distribution, coverage, reward) in
        [(PoiDistribution::Clustered, 0.672, 685.0), (PoiDistribution::Uniform, 0.456, 476.0)]
    {
        let full = relaying(distribution, MAX_KNOWLEDGE);
        assert_coverage(&full, coverage);
        assert_reward(&full, reward);
    }
    // In the same worlds; with a budget of 0 UAVs tell where they are and go, no more.
    let means = [0, MAX_KNOWLEDGE].map(|bytes| relaying(PoiDistribution::Clustered, bytes).mean());
    assert!(means[0].coverage < means[1].coverage - 0.01, "{means:?}");
}

#[test]
fn oracles() {
    let parked = evaluate_parked(&scenario(PoiDistribution::Clustered), SEED, WORLDS).unwrap();
    assert_coverage(&parked, 0.856);
    assert_coverage(&evaluate_parked(&scenario(PoiDistribution::Uniform), SEED, WORLDS).unwrap(), 0.605);
    let flown = evaluate(&scenario(PoiDistribution::Clustered), SEED, WORLDS, |_| FlyToSites::new()).unwrap();
    assert_coverage(&flown, 0.736);
    assert_energy(&flown, 0.63);
    assert_reward(&flown, 742.0);
    for (parked, flown) in parked.worlds.iter().zip(&flown.worlds) {
        assert!(flown.coverage <= parked.coverage, "who has to fly there covers no more");
    }
}
