//! Learning is real: a small swarm on a small map covers more after a few seconds.

use firmware_core::actor::Aggregation;
use host_trainer::settings::Settings;
use host_trainer::train::{RoundMetrics, Trainer, Workers};

/// Rows of a whole run.
fn train(settings: &Settings) -> Vec<RoundMetrics> {
    let mut trainer = Trainer::new(settings.clone()).expect("a scenario");
    let workers = Workers::new(2).expect("threads");
    let mut rows = Vec::new();
    while !trainer.done() {
        rows.push(trainer.round(&workers).expect("the CPU does not fail"));
    }
    rows
}

fn mean(rows: &[RoundMetrics], f: fn(&RoundMetrics) -> f64) -> f64 {
    rows.iter().map(f).sum::<f64>() / rows.len() as f64
}

fn settings(graph: Aggregation) -> Settings {
    Settings {
        graph,
        uavs: 4,
        pois: 40,
        side: 70.0,
        steps: 30,
        rollout_steps: 15,
        hidden: 32,
        feature: 16,
        head: 32,
        num_envs: 32,
        episodes: 32 * 16,
        minibatch: 480,
        learning_rate: 3e-3,
        // From reward alone, on worlds of one kind.
        cloning_weight: 0.0,
        uavs_max: 0,
        other_distribution_share: 0.0,
        ..Settings::default()
    }
}

/// Means over the first two rounds and over the last four.
fn from_to(rows: &[RoundMetrics], f: fn(&RoundMetrics) -> f64) -> [f64; 2] {
    [mean(&rows[..2], f), mean(&rows[rows.len() - 4..], f)]
}

fn check(graph: Aggregation) {
    let rows = train(&settings(graph));
    let coverage = from_to(&rows, |r| r.coverage);
    let reward = from_to(&rows, |r| r.reward);
    let entropy = from_to(&rows, |r| r.entropy);
    let explained = from_to(&rows, |r| r.explained_variance);
    println!("coverage {coverage:.3?}, reward {reward:.1?}, entropy {entropy:.2?}, explained {explained:.2?}");
    assert!(coverage[1] > coverage[0] + 0.2, "coverage went from {coverage:?}");
    assert!(reward[1] > reward[0] + 100.0, "reward went from {reward:?}");
    assert!(entropy[1] < entropy[0] - 0.4, "the policy did not make up its mind: {entropy:?}");
    assert!(explained[1] > 0.5, "the critic explains {explained:?} of the returns");
}

#[test]
fn a_swarm_without_a_graph_learns_to_cover() {
    check(Aggregation::None);
}

#[test]
fn a_swarm_with_gcn_learns_to_cover() {
    check(Aggregation::Gcn);
}

#[test]
fn a_swarm_with_gat_learns_to_cover() {
    check(Aggregation::Gat);
}

#[test]
fn a_swarm_with_gatv2_learns_to_cover() {
    check(Aggregation::GatV2);
}

#[test]
fn a_swarm_with_sage_learns_to_cover() {
    check(Aggregation::Sage);
}

/// The same worlds get no easier by themselves.
#[test]
fn without_steps_of_the_optimiser_nothing_is_learnt() {
    let idle = Settings { learning_rate: 1e-12, epochs: 1, ..settings(Aggregation::Gcn) };
    let [start, end] = from_to(&train(&idle), |r| r.coverage);
    assert!((start - end).abs() < 0.08, "coverage went from {start} to {end}");
}
