//! The networks by hand against the same in burn, whose autodiff computes the gradients:
//! full size, ragged links, with and without a graph.

use covey_burn::{BurnEngine, Kind};
use covey_env::baselines::Centroid;
use covey_env::{Neighbourhood, Observer, PoiDistribution, Policy, Scenario, World};
use covey_net::{
    ActorGradient, ActorNet, ActorPass, CriticGradient, CriticNet, CriticPass, Engine, GraphBatch, Inputs, Outputs,
    ParameterLayout, Rows, initialise,
};
use firmware_core::action::{ACTIONS, Action};
use firmware_core::actor::{Aggregation, Dimensions};
use firmware_core::observation::{LEN, Observation};

const UAVS: usize = 20;
const WORLDS: usize = 12;
const DIMENSIONS: Dimensions =
    Dimensions { observation: LEN as u16, hidden: 128, feature: 64, head: 64, actions: ACTIONS as u16 };

/// A pseudo-random number in ±1 for each `k`.
fn noise(k: usize) -> f32 {
    let z = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (((z ^ (z >> 29)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0) as f32
}

/// What UAVs see some way into episodes, when they have gathered in groups of all sizes.
fn situations() -> (Vec<Observation>, Vec<Neighbourhood>) {
    let scenario =
        Scenario { uavs: UAVS, pois: 120, side_u: 120.0, steps: 100, distribution: PoiDistribution::Clustered };
    let mut world = World::new(&scenario).expect("a scenario");
    let (mut observations, mut links) = (Vec::new(), Vec::new());
    for k in 0..WORLDS {
        world.reset(5, k as u64);
        let (mut policy, mut actions) = (Centroid::new(1, k as u64), [Action::COAST; UAVS]);
        policy.begin(&world);
        for _ in 0..4 * k {
            policy.act(&world, &mut actions);
            world.step(&actions);
        }
        let (mut o, mut l) = ([[0; LEN]; UAVS], [Neighbourhood::default(); UAVS]);
        Observer::new(9, 1).observe(&world, &mut o, &mut l);
        observations.extend(o);
        links.extend(l);
    }
    let degrees: Vec<u8> = links.iter().map(|l| l.count).collect();
    assert!((0..6).all(|d| degrees.contains(&d)), "links of all kinds: {degrees:?}");
    (observations, links)
}

/// The numbers of all rows; then `weights` stand there.
fn exchange(rows: &mut Rows, weights: &[f32]) -> Vec<f32> {
    let (step, width) = (rows.step(), rows.width());
    let mut out = Vec::new();
    for (row, w) in rows.values_mut().chunks_exact_mut(step).zip(weights.chunks_exact(width)) {
        out.extend_from_slice(&row[..width]);
        row[..width].copy_from_slice(w);
    }
    out
}

/// Parameters to compare at, biases too.
fn parameters(layout: &ParameterLayout) -> Vec<f32> {
    let mut values = initialise(layout, "test", 7);
    values.iter_mut().enumerate().for_each(|(k, v)| *v += 0.02 * noise(k));
    values
}

/// Weights of the outputs.
fn weights(width: usize) -> Vec<f32> {
    (0..WORLDS * UAVS * width).map(|k| noise(1_000_000 + k)).collect()
}

/// Outputs and the gradient of Σ weight·output of actor and critic.
struct Found {
    outputs: [Vec<f32>; 2],
    gradients: [Vec<f32>; 2],
}

fn by_hand(
    layouts: &[ParameterLayout; 2],
    aggregation: Aggregation,
    parameters: [&[f32]; 2],
    inputs: &Inputs,
) -> Found {
    let (mut actor, mut critic) = (ActorNet::new(&layouts[0], aggregation), CriticNet::new(&layouts[1]));
    actor.load(parameters[0]);
    critic.load(parameters[1]);
    let (mut actor_pass, mut actor_sum) = (ActorPass::new(&layouts[0]), ActorGradient::new(&layouts[0]));
    let (mut critic_pass, mut critic_sum) = (CriticPass::new(&layouts[1]), CriticGradient::new(&layouts[1]));
    actor_pass.forward(&actor, inputs);
    critic_pass.forward(&critic, inputs);
    let outputs =
        [exchange(actor_pass.logits_mut(), &weights(ACTIONS)), exchange(critic_pass.values_mut(), &weights(1))];
    actor_pass.backward(&actor, inputs, &mut actor_sum);
    critic_pass.backward(&critic, inputs, &mut critic_sum);
    let mut gradients = layouts.each_ref().map(|l| vec![f32::NAN; l.len()]);
    actor_sum.store(parameters[0], &mut gradients[0]);
    critic_sum.store(&mut gradients[1]);
    Found { outputs, gradients }
}

/// The same in burn, with the world-steps held in another order and among others, as in a minibatch.
fn in_burn(
    layouts: &[ParameterLayout; 2],
    aggregation: Aggregation,
    parameters: [&[f32]; 2],
    seen: GraphBatch<'_>,
) -> Found {
    let mut engine = BurnEngine::open(Kind::Flex, layouts.clone(), aggregation).expect("a CPU");
    engine.load(parameters);
    let step = |k: usize| GraphBatch {
        uavs: UAVS,
        observations: &seen.observations[k * UAVS..(k + 1) * UAVS],
        links: &seen.links[k * UAVS..(k + 1) * UAVS],
    };
    let held: Vec<GraphBatch<'_>> = (0..WORLDS).rev().flat_map(|k| [step(k), step(0)]).collect();
    engine.hold(&held);
    let order: Vec<u32> = (0..WORLDS as u32).map(|k| 2 * (WORLDS as u32 - 1 - k)).collect();
    let (mut out, mut gradients) = (Outputs::default(), [Vec::new(), Vec::new()]);
    let mut outputs = [Vec::new(), Vec::new()];
    let mut weigh = |out: &mut Outputs| {
        outputs = [exchange(&mut out.logits, &weights(ACTIONS)), exchange(&mut out.values, &weights(1))];
    };
    engine.gradient(&order, &mut out, &mut weigh, &mut gradients).expect("a gradient");

    // Without autodiff, and in two parts, it computes the same.
    let halves = [(0..WORLDS / 3), (WORLDS / 3..WORLDS)].map(|r| GraphBatch {
        uavs: UAVS,
        observations: &seen.observations[r.start * UAVS..r.end * UAVS],
        links: &seen.links[r.start * UAVS..r.end * UAVS],
    });
    engine.forward(&halves, &mut out).expect("outputs");
    for (rows, wanted) in [&out.logits, &out.values].into_iter().zip(&outputs) {
        let got: Vec<f32> = (0..rows.rows()).flat_map(|r| rows.row(r)).copied().collect();
        assert_near("forward", &got, wanted, 1e-6);
    }
    Found { outputs, gradients }
}

/// Differences are small beside the greatest number.
fn assert_near(what: &str, got: &[f32], wanted: &[f32], tolerance: f32) {
    assert_eq!(got.len(), wanted.len(), "{what}");
    let scale = wanted.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    assert!(scale > 0.0, "{what}: nothing there");
    for (k, (got, want)) in got.iter().zip(wanted).enumerate() {
        assert!((got - want).abs() < tolerance * scale, "{what} {k}: {got}, not {want}");
    }
}

fn check(aggregation: Aggregation) {
    let (observations, links) = situations();
    let layouts = [ParameterLayout::actor(DIMENSIONS, aggregation), ParameterLayout::critic(DIMENSIONS)];
    let values = layouts.each_ref().map(parameters);
    let parameters = [&values[0][..], &values[1][..]];
    let mut inputs = Inputs::new(LEN);
    inputs.clear(UAVS);
    inputs.push(&observations, &links);
    let got = by_hand(&layouts, aggregation, parameters, &inputs);
    let seen = GraphBatch { uavs: UAVS, observations: &observations, links: &links };
    let wanted = in_burn(&layouts, aggregation, parameters, seen);
    for (k, layout) in layouts.iter().enumerate() {
        let name = [aggregation.name(), "critic"][k];
        assert_near(name, &got.outputs[k], &wanted.outputs[k], 1e-5);
        for p in layout.pieces() {
            let place = p.start..p.start + p.len();
            let what = format!("{name}: {}", p.name);
            assert_near(&what, &got.gradients[k][place.clone()], &wanted.gradients[k][place], 1e-4);
        }
    }
}

#[test]
fn without_a_graph_the_gradients_are_autodiffs() {
    check(Aggregation::None);
}

#[test]
fn with_gcn_the_gradients_are_autodiffs() {
    check(Aggregation::Gcn);
}

#[test]
fn with_gat_the_gradients_are_autodiffs() {
    check(Aggregation::Gat);
}
