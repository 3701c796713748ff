//! The layers between encoder and head: what a UAV makes of the features of its neighbourhood
//! (paper, equations 5 to 7).

use crate::aggregation::{Aggregate, Attention, AttentionGradient, Score, ScoreGradient, ScoredAggregate, Weighing};
use crate::input::Inputs;
use crate::kernel::Init;
use crate::layers::{BlockGradient, Dense};
use crate::matrix::{Activation, Rows};
use crate::parameter_layout::ParameterLayout;
use firmware_core::actor::Aggregation;

/// The parameters between encoder and head.
#[derive(Clone, Debug)]
pub enum GraphLayer {
    /// Features are combined, then multiplied by `W`, in the order in which UAVs do it: which is
    /// the same as equations (5) and (7).
    Combined {
        /// Weights of the sum.
        weighing: Weighing,
        /// `W`.
        weights: Dense,
    },
    /// GATv2: multiplied by `W_r`, then combined.
    Scored {
        /// `W_l`.
        receiver: Dense,
        /// `W_r`.
        sender: Dense,
        /// `a`.
        score: Score,
    },
}

impl GraphLayer {
    /// For this aggregation, of which the layout must be; zeros until parameters are loaded. None
    /// without aggregation.
    pub fn new(layout: &ParameterLayout, aggregation: Aggregation) -> Option<Self> {
        let weighing = match aggregation {
            Aggregation::None => return None,
            Aggregation::Gcn => Weighing::Degree,
            Aggregation::Sage => Weighing::Alike,
            Aggregation::Gat => Weighing::Attention(Attention::default()),
            Aggregation::GatV2 => {
                let [receiver, sender] = ["receiver", "sender"].map(|name| Dense::new(layout, name));
                return Some(Self::Scored { receiver, sender, score: Score::default() });
            }
        };
        Some(Self::Combined { weighing, weights: Dense::new(layout, "graph") })
    }

    /// Takes the actor's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        match self {
            Self::Combined { weighing, weights } => {
                weights.load(layout, values);
                weighing.load(layout, values);
            }
            Self::Scored { receiver, sender, score } => {
                receiver.load(layout, values);
                sender.load(layout, values);
                score.load(layout, values);
            }
        }
    }
}

/// The activations between encoder and head, a row a UAV, and after the backward pass the
/// gradients by them.
#[derive(Clone, Debug)]
pub struct GraphPass {
    parts: PassParts,
    /// What the head takes.
    pub output: Rows,
    /// Gradient by `output` before its ReLU, to be set before the backward pass.
    pub by_output: Rows,
}

#[derive(Clone, Debug)]
enum PassParts {
    Combined { aggregate: Aggregate, combined: Rows, by_combined: Rows },
    Scored { aggregate: ScoredAggregate, ends: [Rows; 2], by_ends: [Rows; 2] },
}

impl GraphPass {
    /// For actors of this layout; none without aggregation.
    pub fn new(layout: &ParameterLayout) -> Option<Self> {
        if !layout.has("head aggregate") {
            return None;
        }
        let rows = || Rows::new(layout.shape("head aggregate").0);
        let parts = if layout.has("graph") {
            PassParts::Combined { aggregate: Aggregate::default(), combined: rows(), by_combined: rows() }
        } else {
            let aggregate = ScoredAggregate::default();
            PassParts::Scored { aggregate, ends: [rows(), rows()], by_ends: [rows(), rows()] }
        };
        Some(Self { parts, output: rows(), by_output: rows() })
    }

    /// Computes `output`.
    ///
    /// # Panics
    /// When the layer is of another aggregation.
    pub fn forward(&mut self, layer: &GraphLayer, inputs: &Inputs, feature: &Rows) {
        match (&mut self.parts, layer) {
            (PassParts::Combined { aggregate, combined, .. }, GraphLayer::Combined { weighing, weights }) => {
                aggregate.forward(inputs, weighing, feature, combined);
                weights.forward(combined, Activation::Relu, &mut self.output);
            }
            (PassParts::Scored { aggregate, ends, .. }, GraphLayer::Scored { receiver, sender, score }) => {
                for (out, layer) in ends.iter_mut().zip([receiver, sender]) {
                    layer.forward(feature, Activation::Identity, out);
                }
                let [receiver, sender] = ends;
                aggregate.forward(inputs, score, [receiver, sender], &mut self.output);
            }
            _ => panic!("a pass of the layer's aggregation"),
        }
    }

    /// Writes the gradient by the features to `by_feature` and adds that by the parameters to
    /// `sum`, after [`Self::forward`], when `by_output` is set.
    ///
    /// # Panics
    /// When layer or sum are of another aggregation.
    pub fn backward(&mut self, layer: &GraphLayer, feature: &Rows, sum: &mut GraphGradient, by_feature: &mut Rows) {
        let by_output = &self.by_output;
        match (&mut self.parts, layer, sum) {
            (
                PassParts::Combined { aggregate, combined, by_combined },
                GraphLayer::Combined { weighing, weights },
                GraphGradient::Combined { weights: by_weights, bias, attention },
            ) => {
                by_weights.add_weights(combined, by_output);
                bias.add_bias(by_output);
                weights.backward(by_output, Activation::Identity, by_combined);
                aggregate.backward(by_combined, feature, weighing.attention().zip(attention.as_mut()), by_feature);
            }
            (
                PassParts::Scored { aggregate, ends: [l, r], by_ends: [by_l, by_r] },
                GraphLayer::Scored { receiver, sender, score },
                GraphGradient::Scored {
                    ends: [[by_receiver, receiver_bias], [by_sender, sender_bias]],
                    score: by_score,
                },
            ) => {
                aggregate.backward(by_output, (score, by_score), [l, r], [by_l, by_r]);
                for (weights, bias, by_end) in [(by_receiver, receiver_bias, &*by_l), (by_sender, sender_bias, &*by_r)]
                {
                    weights.add_weights(feature, by_end);
                    bias.add_bias(by_end);
                }
                receiver.weights().backward(by_l, Init::Zero, Activation::Identity, by_feature);
                sender.weights().backward(by_r, Init::Accumulate, Activation::Identity, by_feature);
            }
            _ => panic!("a pass of the layer's aggregation"),
        }
    }

    /// The combined features of each neighbourhood, a row a UAV; none with GATv2, whose output
    /// they are.
    pub const fn combined(&self) -> Option<&Rows> {
        match &self.parts {
            PassParts::Combined { combined, .. } => Some(combined),
            PassParts::Scored { .. } => None,
        }
    }

    /// GATv2: `W_l h` and `W_r h`, a row a UAV.
    pub const fn ends(&self) -> Option<&[Rows; 2]> {
        match &self.parts {
            PassParts::Combined { .. } => None,
            PassParts::Scored { ends, .. } => Some(ends),
        }
    }

    /// Multiply-adds in products, those with a zero left out: of a forward and of a backward
    /// pass. `feature` are the features that went in.
    pub fn multiply_adds(&self, feature: &Rows) -> [u64; 2] {
        let width = feature.width() as u64;
        match &self.parts {
            PassParts::Combined { combined, .. } => {
                let products = combined.nonzeros() * width;
                [products, products + self.output.nonzeros() * width]
            }
            PassParts::Scored { .. } => {
                let products = 2 * feature.nonzeros() * width;
                [products, products + 2 * feature.rows() as u64 * width * width]
            }
        }
    }
}

/// Gradient of the loss by the parameters between encoder and head: a sum over samples.
#[derive(Clone, Debug)]
pub enum GraphGradient {
    /// Of [`GraphLayer::Combined`].
    Combined {
        /// By `W`.
        weights: BlockGradient,
        /// By the bias.
        bias: BlockGradient,
        /// By attention, if there is any.
        attention: Option<AttentionGradient>,
    },
    /// Of [`GraphLayer::Scored`].
    Scored {
        /// By `W_l` and its bias, by `W_r` and its bias.
        ends: [[BlockGradient; 2]; 2],
        /// By `a`.
        score: ScoreGradient,
    },
}

impl GraphGradient {
    /// Zero, for actors of this layout; none without aggregation.
    pub fn new(layout: &ParameterLayout) -> Option<Self> {
        if !layout.has("head aggregate") {
            return None;
        }
        let width = layout.shape("head aggregate").0;
        Some(if layout.has("graph") {
            Self::Combined {
                weights: BlockGradient::of_weights(layout, "graph"),
                bias: BlockGradient::of_bias(layout, "graph"),
                attention: layout.has("attention sender").then(|| AttentionGradient::new(width)),
            }
        } else {
            let end = |name| [BlockGradient::of_weights(layout, name), BlockGradient::of_bias(layout, name)];
            Self::Scored { ends: ["receiver", "sender"].map(end), score: ScoreGradient::new(width) }
        })
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        match self {
            Self::Combined { weights, bias, attention } => {
                weights.clear();
                bias.clear();
                if let Some(a) = attention {
                    a.clear();
                }
            }
            Self::Scored { ends, score } => {
                ends.as_flattened_mut().iter_mut().for_each(BlockGradient::clear);
                score.clear();
            }
        }
    }

    /// Writes it to its places in the flat gradient of the network; `values` are the parameters
    /// that it was computed at.
    pub fn store(&self, layout: &ParameterLayout, values: &[f32], out: &mut [f32]) {
        match self {
            Self::Combined { weights, bias, attention } => {
                weights.store(layout, out);
                bias.store(layout, out);
                if let Some(a) = attention {
                    a.store(layout, values, out);
                }
            }
            Self::Scored { ends, score } => {
                ends.as_flattened().iter().for_each(|g| g.store(layout, out));
                score.store(layout, out);
            }
        }
    }
}
