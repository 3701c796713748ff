//! The networks written by hand against the same in burn, whose autodiff computes the gradients:
//! full size, neighbourhoods of all sizes, with and without a graph.

use covey_burn::{BurnEngine, Kind};
use covey_env::baselines::Centroid;
use covey_env::{Neighbourhood, Observer, PoiDistribution, Policy, Scenario, World};
use covey_net::{
    ActorCritic, ActorGradient, ActorNet, ActorPass, CriticGradient, CriticNet, CriticPass, Engine, GraphBatch, Inputs,
    Outputs, ParameterLayout, Rows, initialise,
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
    let (mut observations, mut neighbours) = (Vec::new(), Vec::new());
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
        neighbours.extend(l);
    }
    let degrees: Vec<u8> = neighbours.iter().map(|l| l.count).collect();
    assert!((0..6).all(|d| degrees.contains(&d)), "neighbourhoods of all sizes: {degrees:?}");
    (observations, neighbours)
}

/// The numbers of all rows; then `weights` stand there.
fn exchange(rows: &mut Rows, weights: &[f32]) -> Vec<f32> {
    let (stride, width) = (rows.stride(), rows.width());
    let mut out = Vec::new();
    for (row, w) in rows.values_mut().chunks_exact_mut(stride).zip(weights.chunks_exact(width)) {
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
    outputs: ActorCritic<Vec<f32>>,
    gradients: ActorCritic<Vec<f32>>,
}

fn by_hand(
    layouts: &ActorCritic<ParameterLayout>,
    aggregation: Aggregation,
    parameters: ActorCritic<&[f32]>,
    inputs: &Inputs,
) -> Found {
    let (mut actor, mut critic) = (ActorNet::new(&layouts.actor, aggregation), CriticNet::new(&layouts.critic));
    actor.load(parameters.actor);
    critic.load(parameters.critic);
    let (mut actor_pass, mut actor_sum) = (ActorPass::new(&layouts.actor), ActorGradient::new(&layouts.actor));
    let (mut critic_pass, mut critic_sum) = (CriticPass::new(&layouts.critic), CriticGradient::new(&layouts.critic));
    actor_pass.forward(&actor, inputs);
    critic_pass.forward(&critic, inputs);
    let outputs = ActorCritic {
        actor: exchange(actor_pass.logits_mut(), &weights(ACTIONS)),
        critic: exchange(critic_pass.values_mut(), &weights(1)),
    };
    actor_pass.backward(&actor, inputs, &mut actor_sum);
    critic_pass.backward(&critic, inputs, &mut critic_sum);
    let mut gradients = layouts.as_ref().map(|l| vec![f32::NAN; l.len()]);
    actor_sum.store(parameters.actor, &mut gradients.actor);
    critic_sum.store(&mut gradients.critic);
    Found { outputs, gradients }
}

/// The same in burn, with the world-steps loaded in another order and among others, as in a minibatch.
fn in_burn(
    layouts: &ActorCritic<ParameterLayout>,
    aggregation: Aggregation,
    parameters: ActorCritic<&[f32]>,
    batch: GraphBatch<'_>,
) -> Found {
    let mut engine = BurnEngine::open(Kind::Flex, layouts.clone(), aggregation).expect("a CPU");
    engine.load_parameters(parameters);
    let step = |k: usize| GraphBatch {
        uavs: UAVS,
        observations: &batch.observations[k * UAVS..(k + 1) * UAVS],
        neighbours: &batch.neighbours[k * UAVS..(k + 1) * UAVS],
    };
    let rollout: Vec<GraphBatch<'_>> = (0..WORLDS).rev().flat_map(|k| [step(k), step(0)]).collect();
    engine.load_rollout(&rollout);
    let order: Vec<u32> = (0..WORLDS as u32).map(|k| 2 * (WORLDS as u32 - 1 - k)).collect();
    let (mut out, mut gradients) = (Outputs::default(), ActorCritic::default());
    let mut outputs = ActorCritic::default();
    let mut weigh = |out: &mut Outputs| {
        outputs = ActorCritic {
            actor: exchange(&mut out.logits, &weights(ACTIONS)),
            critic: exchange(&mut out.values, &weights(1)),
        };
    };
    engine.gradient(&order, &mut out, &mut weigh, &mut gradients).expect("a gradient");

    // Without autodiff, and in two parts, it computes the same.
    let halves = [(0..WORLDS / 3), (WORLDS / 3..WORLDS)].map(|r| GraphBatch {
        uavs: UAVS,
        observations: &batch.observations[r.start * UAVS..r.end * UAVS],
        neighbours: &batch.neighbours[r.start * UAVS..r.end * UAVS],
    });
    engine.forward(&halves, &mut out).expect("outputs");
    for (rows, wanted) in [(&out.logits, &outputs.actor), (&out.values, &outputs.critic)] {
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
    let (observations, neighbours) = situations();
    let layouts = ActorCritic {
        actor: ParameterLayout::actor(DIMENSIONS, aggregation),
        critic: ParameterLayout::critic(DIMENSIONS),
    };
    let values = layouts.as_ref().map(parameters);
    let parameters = ActorCritic { actor: &values.actor[..], critic: &values.critic[..] };
    let mut inputs = Inputs::new(LEN);
    inputs.clear(UAVS);
    inputs.push(&observations, &neighbours);
    let got = by_hand(&layouts, aggregation, parameters, &inputs);
    let batch = GraphBatch { uavs: UAVS, observations: &observations, neighbours: &neighbours };
    let wanted = in_burn(&layouts, aggregation, parameters, batch);
    assert_alike(
        aggregation.name(),
        &layouts.actor,
        [&got.outputs.actor, &got.gradients.actor],
        [&wanted.outputs.actor, &wanted.gradients.actor],
    );
    assert_alike(
        "critic",
        &layouts.critic,
        [&got.outputs.critic, &got.gradients.critic],
        [&wanted.outputs.critic, &wanted.gradients.critic],
    );
}

/// Outputs and gradients of a network, the latter block by block.
fn assert_alike(name: &str, layout: &ParameterLayout, got: [&[f32]; 2], wanted: [&[f32]; 2]) {
    assert_near(name, got[0], wanted[0], 1e-5);
    for block in layout.blocks() {
        let [got, wanted] = [got[1], wanted[1]].map(|gradient| layout.block(gradient, block.name));
        assert_near(&format!("{name}: {}", block.name), got, wanted, 1e-4);
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
fn with_gatv2_the_gradients_are_autodiffs() {
    check(Aggregation::GatV2);
}

#[test]
fn with_sage_the_gradients_are_autodiffs() {
    check(Aggregation::Sage);
}

#[test]
fn with_gat_the_gradients_are_autodiffs() {
    check(Aggregation::Gat);
}
