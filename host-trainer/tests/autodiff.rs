//! The networks by hand against the same in burn, whose autodiff computes the gradients:
//! full size, ragged links, with and without a graph.

use burn::tensor::activation::{leaky_relu, relu, softmax};
use burn::tensor::module::linear;
use burn::tensor::{Device, Tensor, TensorData};
use covey_env::baselines::Centroid;
use covey_env::{Law, Links, Observer, Policy, Scenario, World};
use covey_net::{
    ActorGradient, ActorNet, ActorPass, CriticGradient, CriticNet, CriticPass, Inputs, Layout, Rows, initialise,
};
use firmware_core::action::{ACTIONS, Action};
use firmware_core::actor::{Aggregation, Dimensions};
use firmware_core::observation::{LEN, Observation};

/// Slope of the attention's leaky ReLU below zero.
const LEAKY_SLOPE: f64 = 0.2;

/// Observations and links of B world-steps of N UAVs each.
struct Batch {
    /// World-steps.
    world_steps: usize,
    /// UAVs in each.
    uavs: usize,
    /// Observations as the board builds them over 127, `[B·N, 160]`.
    observations: Tensor<2>,
    /// `[B, N, N]`: GCN weights `1/√(d_i d_j)`, or for GAT 0 on links and −10⁹ elsewhere.
    graph: Option<Tensor<3>>,
}

impl Batch {
    fn new(
        observations: &[Observation],
        links: &[Links],
        uavs: usize,
        aggregation: Aggregation,
        device: &Device,
    ) -> Self {
        let world_steps = links.len() / uavs;
        let graph = (aggregation != Aggregation::None).then(|| {
            let weights = graph_weights(links, uavs, aggregation);
            Tensor::from_data(TensorData::new(weights, [world_steps, uavs, uavs]), device)
        });
        let observations = Tensor::from_data(TensorData::new(to_floats(observations), [links.len(), LEN]), device);
        Self { world_steps, uavs, observations, graph }
    }
}

/// Observations as the networks take them.
fn to_floats(observations: &[Observation]) -> Vec<f32> {
    const SCALE: f32 = 1.0 / 127.0;
    observations.as_flattened().iter().map(|&o| f32::from(o) * SCALE).collect()
}

fn graph_weights(links: &[Links], uavs: usize, aggregation: Aggregation) -> Vec<f32> {
    let gat = aggregation == Aggregation::Gat;
    let mut weights = vec![if gat { -1e9 } else { 0.0 }; links.len() * uavs];
    let root = |l: &Links| (f32::from(l.count) + 1.0).sqrt().recip();
    for (world, rows) in links.chunks_exact(uavs).zip(weights.chunks_exact_mut(uavs * uavs)) {
        for (i, (link, row)) in world.iter().zip(rows.chunks_exact_mut(uavs)).enumerate() {
            let weight = |j: usize| if gat { 0.0 } else { root(link) * root(&world[j]) };
            row[i] = weight(i);
            for &j in &link.to[..usize::from(link.count)] {
                row[usize::from(j)] = weight(usize::from(j));
            }
        }
    }
    weights
}

/// `x·w + b` with the bias as `[1, outputs]`.
fn dense(x: Tensor<2>, w: &Tensor<2>, b: &Tensor<2>) -> Tensor<2> {
    linear(x, w.clone(), Some(b.clone().squeeze_dim(0)))
}

/// Features `h`, `[B·N, feature]`.
fn encode(x: Tensor<2>, t: &[Tensor<2>]) -> Tensor<2> {
    relu(dense(relu(dense(x, &t[0], &t[1])), &t[2], &t[3]))
}

/// Logits `[B·N, 17]`.
fn actor_logits(t: &[Tensor<2>], aggregation: Aggregation, batch: &Batch) -> Tensor<2> {
    let feature = encode(batch.observations.clone(), t);
    let own = dense(feature.clone(), &t[4], &t[5]);
    let joined = match &batch.graph {
        Some(graph) => {
            let [n, width] = feature.dims();
            let weights = match aggregation {
                Aggregation::Gat => attention(graph, &feature, t, batch),
                _ => graph.clone(),
            };
            let each = feature.reshape([batch.world_steps, batch.uavs, width]);
            let combined = weights.matmul(each).reshape([n, width]);
            own + relu(dense(combined, &t[8], &t[9])).matmul(t[10].clone())
        }
        None => own,
    };
    dense(relu(joined), &t[6], &t[7])
}

/// Attention weights of equation (6), `[B, N, N]`; `graph` masks what is not linked.
/// `aᵀ[W h_i ‖ W h_j]` is `h_i·(W a₁) + h_j·(W a₂)`.
fn attention(graph: &Tensor<3>, h: &Tensor<2>, t: &[Tensor<2>], batch: &Batch) -> Tensor<3> {
    let (b, n) = (batch.world_steps, batch.uavs);
    let half = |a: &Tensor<2>| h.clone().matmul(t[8].clone().matmul(a.clone()));
    let (receiver, sender) = (half(&t[11]).reshape([b, n, 1]), half(&t[12]).reshape([b, 1, n]));
    softmax(leaky_relu(receiver + sender, LEAKY_SLOPE) + graph.clone(), 2)
}

/// Normalised values `[B·N, 1]`.
fn critic_values(t: &[Tensor<2>], batch: &Batch) -> Tensor<2> {
    let e = encode(batch.observations.clone(), t);
    let [n, width] = e.dims();
    let (b, uavs) = (batch.world_steps, batch.uavs);
    let mean: Tensor<2> = e.clone().reshape([b, uavs, width]).mean_dim(1).reshape([b, width]);
    let shared = dense(mean, &t[5], &t[6]);
    let m = shared.dims()[1];
    let own = e.matmul(t[4].clone()).reshape([b, uavs, m]);
    let hidden = relu(own + shared.reshape([b, 1, m])).reshape([n, m]);
    dense(hidden, &t[7], &t[8])
}

// --- Comparison -----------------------------------------------------------------------

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
fn situations() -> (Vec<Observation>, Vec<Links>) {
    let scenario = Scenario { uavs: UAVS, pois: 120, side_u: 120.0, steps: 100, law: Law::Clustered };
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
        let (mut o, mut l) = ([[0; LEN]; UAVS], [Links::default(); UAVS]);
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

/// Outputs and the gradient of Σ weight·output, by hand and in burn.
fn check(
    name: &str,
    layout: &Layout,
    width: usize,
    by_hand: impl Fn(&[f32], &Inputs, &[f32]) -> (Vec<f32>, Vec<f32>),
    in_burn: impl Fn(&[Tensor<2>], &Batch) -> Tensor<2>,
    aggregation: Aggregation,
) {
    let (observations, links) = situations();
    let mut values = initialise(layout, "test", 7);
    values.iter_mut().enumerate().for_each(|(k, v)| *v += 0.02 * noise(k));
    let weights: Vec<f32> = (0..links.len() * width).map(|k| noise(1_000_000 + k)).collect();

    let device = Device::flex().autodiff();
    let leaves: Vec<Tensor<2>> = layout
        .pieces()
        .iter()
        .map(|p| {
            let numbers = values[p.start..p.start + p.len()].to_vec();
            Tensor::from_data(TensorData::new(numbers, [p.inputs, p.outputs]), &device).require_grad()
        })
        .collect();
    let batch = Batch::new(&observations, &links, UAVS, aggregation, &device);
    let output = in_burn(&leaves, &batch);
    let wanted: Vec<f32> = output.clone().inner().into_data().try_into_vec().expect("floats");
    let factors = Tensor::<2>::from_data(TensorData::new(weights.clone(), output.dims()), &Device::flex()).autodiff();
    let mut gradients = (output * factors).sum().backward();

    let mut inputs = Inputs::new(LEN);
    inputs.clear(UAVS);
    inputs.push(&observations, &links);
    let (got, gradient) = by_hand(&values, &inputs, &weights);
    let scale = wanted.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    for (k, (got, want)) in got.iter().zip(&wanted).enumerate() {
        assert!((got - want).abs() < 1e-5 * scale, "{name}: output {k}: {got}, not {want}");
    }
    for (piece, leaf) in layout.pieces().iter().zip(&leaves) {
        let want: Vec<f32> =
            leaf.grad_remove(&mut gradients).expect("a gradient").into_data().try_into_vec().expect("floats");
        let steepest = want.iter().fold(0.0f32, |m, v| m.max(v.abs()));
        assert!(steepest > 0.0, "{name}: nothing depends on {}", piece.name);
        for (k, (got, want)) in gradient[piece.start..].iter().zip(&want).enumerate() {
            let error = (got - want).abs();
            assert!(error < 1e-4 * steepest, "{name}: {} {k}: {got}, not {want}", piece.name);
        }
    }
}

#[test]
fn the_actors_gradient_is_autodiffs() {
    for aggregation in Aggregation::ALL {
        let layout = Layout::actor(DIMENSIONS, aggregation);
        let by_hand = |values: &[f32], inputs: &Inputs, weights: &[f32]| {
            let mut net = ActorNet::new(&layout, aggregation);
            net.load(values);
            let (mut pass, mut sum) = (ActorPass::new(&layout), ActorGradient::new(&layout));
            pass.forward(&net, inputs);
            let out = exchange(pass.logits_mut(), weights);
            pass.backward(&net, inputs, &mut sum);
            let mut gradient = vec![f32::NAN; layout.len()];
            sum.store(values, &mut gradient);
            (out, gradient)
        };
        let in_burn = |t: &[Tensor<2>], batch: &Batch| actor_logits(t, aggregation, batch);
        check(aggregation.name(), &layout, ACTIONS, by_hand, in_burn, aggregation);
    }
}

#[test]
fn the_critics_gradient_is_autodiffs() {
    let layout = Layout::critic(DIMENSIONS);
    let by_hand = |values: &[f32], inputs: &Inputs, weights: &[f32]| {
        let mut net = CriticNet::new(&layout);
        net.load(values);
        let (mut pass, mut sum) = (CriticPass::new(&layout), CriticGradient::new(&layout));
        pass.forward(&net, inputs);
        let out = exchange(pass.values_mut(), weights);
        pass.backward(&net, inputs, &mut sum);
        let mut gradient = vec![f32::NAN; layout.len()];
        sum.store(&mut gradient);
        (out, gradient)
    };
    check("critic", &layout, 1, by_hand, critic_values, Aggregation::Gcn);
}
