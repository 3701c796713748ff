//! Forward passes in burn (paper, equations 5 to 7; figure 4).

use burn::tensor::activation::{leaky_relu, relu, softmax};
use burn::tensor::module::linear;
use burn::tensor::{Device, Tensor, TensorData};
use covey_env::Links;
use firmware_core::actor::Aggregation;
use firmware_core::observation::{LEN, Observation};

/// Slope of the attention's leaky ReLU below zero.
const LEAKY_SLOPE: f64 = 0.2;

/// Observations and links of B world-steps of N UAVs each.
pub struct Batch {
    /// World-steps.
    pub world_steps: usize,
    /// UAVs in each.
    pub uavs: usize,
    /// Observations as the board builds them over 127, `[B·N, 160]`.
    pub observations: Tensor<2>,
    /// `[B, N, N]`: GCN weights `1/√(d_i d_j)`, or for GAT 0 on links and −10⁹ elsewhere.
    graph: Option<Tensor<3>>,
}

impl Batch {
    /// A batch of `links.len()/uavs` world-steps: an observation and the neighbours of
    /// every UAV.
    #[must_use]
    pub fn new(
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

/// The actor's parameters as tensors, in layout order.
pub struct ActorTensors<'t> {
    aggregation: Aggregation,
    t: &'t [Tensor<2>],
}

impl<'t> ActorTensors<'t> {
    /// From [`super::Layout::tensors`] of an actor.
    #[must_use]
    pub const fn new(t: &'t [Tensor<2>], aggregation: Aggregation) -> Self {
        Self { aggregation, t }
    }
}

/// `x·w + b` with the bias as `[1, outputs]`.
fn dense(x: Tensor<2>, w: &Tensor<2>, b: &Tensor<2>) -> Tensor<2> {
    linear(x, w.clone(), Some(b.clone().squeeze_dim(0)))
}

/// Features `h`, `[B·N, feature]`.
fn encode(x: Tensor<2>, t: &[Tensor<2>]) -> Tensor<2> {
    relu(dense(relu(dense(x, &t[0], &t[1])), &t[2], &t[3]))
}

/// Everything between observation and logits, `[B·N, …]` each.
pub struct ActorPass {
    /// First hidden layer.
    pub hidden: Tensor<2>,
    /// Feature `h`.
    pub feature: Tensor<2>,
    /// Neighbourhood's features combined, and the graph layer's output; none without
    /// aggregation.
    pub graph: Option<(Tensor<2>, Tensor<2>)>,
    /// Hidden layer of the head.
    pub head: Tensor<2>,
    /// Logits, 17 wide.
    pub logits: Tensor<2>,
}

/// The actor on a batch, in the order in which UAVs compute it: the features are
/// combined first, then multiplied by `W`, which is the same as equations (5) and (7).
#[must_use]
pub fn actor_pass(actor: &ActorTensors<'_>, batch: &Batch) -> ActorPass {
    let t = actor.t;
    let hidden = relu(dense(batch.observations.clone(), &t[0], &t[1]));
    let feature = relu(dense(hidden.clone(), &t[2], &t[3]));
    let own = dense(feature.clone(), &t[4], &t[5]);
    let graph = batch.graph.as_ref().map(|graph| {
        let [n, width] = feature.dims();
        let weights = match actor.aggregation {
            Aggregation::Gat => attention(graph, &feature, t, batch),
            _ => graph.clone(),
        };
        let each = feature.clone().reshape([batch.world_steps, batch.uavs, width]);
        let combined = weights.matmul(each).reshape([n, width]);
        let y = relu(dense(combined.clone(), &t[8], &t[9]));
        (combined, y)
    });
    let joined = match &graph {
        Some((_, y)) => own + y.clone().matmul(t[10].clone()),
        None => own,
    };
    let head = relu(joined);
    let logits = dense(head.clone(), &t[6], &t[7]);
    ActorPass { hidden, feature, graph, head, logits }
}

/// Logits `[B·N, 17]` of a batch.
#[must_use]
pub fn actor_logits(actor: &ActorTensors<'_>, batch: &Batch) -> Tensor<2> {
    actor_pass(actor, batch).logits
}

/// Attention weights of equation (6), `[B, N, N]`; `graph` masks what is not linked.
/// `aᵀ[W h_i ‖ W h_j]` is `h_i·(W a₁) + h_j·(W a₂)`.
fn attention(graph: &Tensor<3>, h: &Tensor<2>, t: &[Tensor<2>], batch: &Batch) -> Tensor<3> {
    let (b, n) = (batch.world_steps, batch.uavs);
    let half = |a: &Tensor<2>| h.clone().matmul(t[8].clone().matmul(a.clone()));
    let (receiver, sender) = (half(&t[11]).reshape([b, n, 1]), half(&t[12]).reshape([b, 1, n]));
    softmax(leaky_relu(receiver + sender, LEAKY_SLOPE) + graph.clone(), 2)
}

/// The critic's parameters as tensors, in layout order.
pub struct CriticTensors<'t>(pub &'t [Tensor<2>]);

/// Normalised values `[B·N, 1]` of a batch.
#[must_use]
pub fn critic_values(critic: &CriticTensors<'_>, batch: &Batch) -> Tensor<2> {
    let t = critic.0;
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
