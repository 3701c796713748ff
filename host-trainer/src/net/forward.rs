//! Forward passes in burn (paper, equations 5 to 7; figure 4).

use burn::tensor::activation::{leaky_relu, relu, softmax};
use burn::tensor::module::linear;
use burn::tensor::{Device, Tensor, TensorData};
use covey_env::Links;
use firmware_core::actor::Aggregation;
use firmware_core::observation::LEN;

/// Slope of the attention's leaky ReLU below zero.
const LEAKY_SLOPE: f64 = 0.2;

/// Observations and links of B world-steps of N UAVs each.
pub struct Batch {
    /// World-steps.
    pub world_steps: usize,
    /// UAVs in each.
    pub uavs: usize,
    /// Observations as the board builds them over 127, `[B·N, 140]`.
    pub observations: Tensor<2>,
    /// `[B, N, N]`: GCN weights `1/√(d_i d_j)`, or for GAT 0 on links and −10⁹ elsewhere.
    graph: Option<Tensor<3>>,
}

impl Batch {
    /// A batch from `links.len()/uavs` world-steps; `observations` holds 140 numbers for
    /// every entry of `links`.
    #[must_use]
    pub fn new(
        observations: Vec<f32>,
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
        let observations = Tensor::from_data(TensorData::new(observations, [links.len(), LEN]), device);
        Self { world_steps, uavs, observations, graph }
    }
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

/// Logits `[B·N, 17]` of a batch.
#[must_use]
pub fn actor_logits(actor: &ActorTensors<'_>, batch: &Batch) -> Tensor<2> {
    let t = actor.t;
    let h = encode(batch.observations.clone(), t);
    let mut hidden = dense(h.clone(), &t[4], &t[5]);
    if let Some(graph) = &batch.graph {
        let [n, width] = h.dims();
        let z = h.matmul(t[8].clone());
        let z3 = z.clone().reshape([batch.world_steps, batch.uavs, width]);
        let weights = match actor.aggregation {
            Aggregation::Gat => attention(graph, z, &t[11], &t[12], batch),
            _ => graph.clone(),
        };
        let y = relu(weights.matmul(z3).reshape([n, width]) + t[9].clone());
        hidden = hidden + y.matmul(t[10].clone());
    }
    dense(relu(hidden), &t[6], &t[7])
}

/// Attention weights of equation (6), `[B, N, N]`; `graph` masks what is not linked.
fn attention(graph: &Tensor<3>, z: Tensor<2>, receiver: &Tensor<2>, sender: &Tensor<2>, batch: &Batch) -> Tensor<3> {
    let (b, n) = (batch.world_steps, batch.uavs);
    let s = z.clone().matmul(receiver.clone()).reshape([b, n, 1]);
    let t = z.matmul(sender.clone()).reshape([b, 1, n]);
    softmax(leaky_relu(s + t, LEAKY_SLOPE) + graph.clone(), 2)
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
