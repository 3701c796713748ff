//! The networks as tensor operations: the actor of the paper's equations (5) to (7) and the
//! central critic.

use burn::tensor::activation::{leaky_relu, relu, softmax};
use burn::tensor::module::linear;
use burn::tensor::{Int, Tensor};
use covey_net::{ParameterBlock, ParameterLayout};
use firmware_core::actor::Aggregation;

/// Slope of the attention's leaky ReLU below zero.
const LEAKY_SLOPE: f64 = 0.2;

/// Observations and communication graphs of B world-steps of N UAVs each.
pub struct Batch {
    /// World-steps.
    pub world_steps: usize,
    /// UAVs in each.
    pub uavs: usize,
    /// Observations as the board builds them over 127, `[B·N, inputs]`.
    pub observations: Tensor<2>,
    /// 1 for a UAV itself and its neighbours, else 0, `[B, N, N]`.
    pub neighbours: Tensor<3>,
}

/// A network's parameters, cut from its flat vector.
pub struct Parameters<'l> {
    layout: &'l ParameterLayout,
    flat: Tensor<1>,
}

impl<'l> Parameters<'l> {
    /// Of a network of this layout.
    pub fn new(layout: &'l ParameterLayout, flat: &Tensor<1>) -> Self {
        Self { layout, flat: flat.clone() }
    }

    /// The weights of this name, `[inputs, outputs]`.
    fn weights(&self, name: &str) -> Tensor<2> {
        let p = self.block(name);
        self.flat.clone().narrow(0, p.start, p.len()).reshape([p.inputs, p.outputs])
    }

    /// The bias of this name, `[outputs]`.
    fn bias(&self, name: &str) -> Tensor<1> {
        let p = self.block(name);
        self.flat.clone().narrow(0, p.start, p.len())
    }

    fn block(&self, name: &str) -> &ParameterBlock {
        self.layout.blocks().iter().find(|p| p.name == name).unwrap_or_else(|| panic!("no block {name}"))
    }

    /// `x·W + b`.
    fn dense(&self, x: Tensor<2>, weights: &str, bias: &str) -> Tensor<2> {
        linear(x, self.weights(weights), Some(self.bias(bias)))
    }

    /// Features, `[B·N, feature]`.
    fn encode(&self, observations: &Tensor<2>) -> Tensor<2> {
        let hidden = relu(self.dense(observations.clone(), "encoder1", "encoder1 bias"));
        relu(self.dense(hidden, "encoder2", "encoder2 bias"))
    }
}

/// Logits, `[B·N, 17]`.
pub fn logits(p: &Parameters<'_>, aggregation: Aggregation, batch: &Batch) -> Tensor<2> {
    let feature = p.encode(&batch.observations);
    let own = p.dense(feature.clone(), "head own", "head bias");
    let graph = |combined| p.dense(combined, "graph", "graph bias");
    let combined = match aggregation {
        Aggregation::None => None,
        Aggregation::Gcn => Some(graph(combine(degree_weights(&batch.neighbours), feature))),
        Aggregation::Sage => Some(graph(combine(mean_weights(&batch.neighbours), feature))),
        Aggregation::Gat => Some(graph(combine(attention(p, &feature, batch), feature))),
        Aggregation::GatV2 => {
            let receiver = p.dense(feature.clone(), "receiver", "receiver bias");
            let sender = p.dense(feature, "sender", "sender bias");
            Some(combine(attention_v2(p, receiver, &sender, batch), sender))
        }
    };
    let head = match combined {
        None => own,
        Some(combined) => own + relu(combined).matmul(p.weights("head aggregate")),
    };
    p.dense(relu(head), "output", "output bias")
}

/// Features, `[B·N, feature]`, summed by these weights, `[B, N, N]`.
fn combine(weights: Tensor<3>, feature: Tensor<2>) -> Tensor<2> {
    let ([b, n, _], [rows, width]) = (weights.dims(), feature.dims());
    weights.matmul(feature.reshape([b, n, width])).reshape([rows, width])
}

/// GCN weights of equation (5): `1/√(d_i d_j)` on edges, `[B, N, N]`; a degree counts the UAV itself.
fn degree_weights(neighbours: &Tensor<3>) -> Tensor<3> {
    let [b, n, _] = neighbours.dims();
    let root = neighbours.clone().sum_dim(2).sqrt().recip();
    neighbours.clone() * root.clone() * root.reshape([b, 1, n])
}

/// Weights of the mean over a UAV's neighbours, without itself, `[B, N, N]`.
fn mean_weights(neighbours: &Tensor<3>) -> Tensor<3> {
    let [_, n, _] = neighbours.dims();
    let others = neighbours.clone() - Tensor::<2>::eye(n, &neighbours.device()).reshape([1, n, n]);
    let count = others.clone().sum_dim(2).clamp_min(1.0);
    others / count
}

/// Attention weights of Brody et al., `[B, N, N]`: the softmax of
/// `aᵀ LeakyReLU(receiver_i + sender_j)`.
fn attention_v2(p: &Parameters<'_>, receiver: Tensor<2>, sender: &Tensor<2>, batch: &Batch) -> Tensor<3> {
    let ([_, width], b, n) = (sender.dims(), batch.world_steps, batch.uavs);
    let sums = receiver.reshape([b, n, 1, width]) + sender.clone().reshape([b, 1, n, width]);
    let scores = leaky_relu(sums, LEAKY_SLOPE).reshape([b * n * n, width]).matmul(p.weights("attention"));
    softmax(scores.reshape([b, n, n]) + mask(&batch.neighbours), 2)
}

/// The score of what is no edge is 10⁹ below, so its weight is zero.
fn mask(neighbours: &Tensor<3>) -> Tensor<3> {
    (neighbours.clone() - 1.0) * 1e9
}

/// Attention weights of equation (6), `[B, N, N]`. The score `aᵀ[W h_i ‖ W h_j]` is
/// `h_i·(W a₁) + h_j·(W a₂)`.
fn attention(p: &Parameters<'_>, feature: &Tensor<2>, batch: &Batch) -> Tensor<3> {
    let (b, n) = (batch.world_steps, batch.uavs);
    let half = |a| feature.clone().matmul(p.weights("graph").matmul(p.weights(a)));
    let (receiver, sender) =
        (half("attention receiver").reshape([b, n, 1]), half("attention sender").reshape([b, 1, n]));
    softmax(leaky_relu(receiver + sender, LEAKY_SLOPE) + mask(&batch.neighbours), 2)
}

/// Normalised values, `[B·N, 1]`.
pub fn values(p: &Parameters<'_>, batch: &Batch) -> Tensor<2> {
    let feature = p.encode(&batch.observations);
    let [rows, width] = feature.dims();
    let (b, n) = (batch.world_steps, batch.uavs);
    let mean = feature.clone().reshape([b, n, width]).mean_dim(1).reshape([b, width]);
    let shared = p.dense(mean, "head mean", "head bias");
    let [_, head] = shared.dims();
    let own = feature.matmul(p.weights("head own")).reshape([b, n, head]);
    p.dense(relu(own + shared.reshape([b, 1, head])).reshape([rows, head]), "output", "output bias")
}

/// Observations from bytes packed four to a word: `[B·N, words]` to `[B·N, inputs]`.
/// A byte holds an observation plus 128.
pub fn unpack_observations(words: Tensor<2, Int>, inputs: usize) -> Tensor<2> {
    let [rows, count] = words.dims();
    let shifts = Tensor::<1, Int>::from_ints([0, 8, 16, 24], &words.device()).reshape([1, 1, 4]);
    let bytes = words.reshape([rows, count, 1]).bitwise_right_shift(shifts).bitwise_and_scalar(255);
    let observations = bytes.reshape([rows, 4 * count]).narrow(1, 0, inputs);
    (observations.float() - 128.0) / 127.0
}

/// Zeros and ones from bits, 32 to a word: `[B·N, words]` to `[B, N, N]`.
pub fn unpack_neighbours(words: Tensor<2, Int>, uavs: usize) -> Tensor<3> {
    let [rows, count] = words.dims();
    let shifts = Tensor::<1, Int>::arange(0..32, &words.device()).reshape([1, 1, 32]);
    let bits = words.reshape([rows, count, 1]).bitwise_right_shift(shifts).bitwise_and_scalar(1);
    bits.reshape([rows, 32 * count]).narrow(1, 0, uavs).float().reshape([rows / uavs, uavs, uavs])
}
