//! The weights of a GAT (paper, equation 6).

use super::edges::Edges;
use super::vectors::{add_scaled, dot, softmax};
use crate::kernel::padded;
use crate::matrix::Rows;
use crate::parameter_layout::ParameterLayout;
use firmware_core::observation::MAX_NEIGHBOURS;

/// Slope of the leaky ReLU below zero.
pub(super) const LEAKY_SLOPE: f32 = 0.2;

/// Attention's parameters, ready to score features: `aᵀ[W h_i ‖ W h_j]` is
/// `h_i·(W a₁) + h_j·(W a₂)`.
#[derive(Clone, Debug, Default)]
pub struct Attention {
    /// `W a₁`, padded to whole vectors.
    receiver: Vec<f32>,
    /// `W a₂`, padded likewise.
    sender: Vec<f32>,
}

impl Attention {
    /// Takes the actor's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        let w = layout.block(values, "graph");
        for (half, name) in [(&mut self.receiver, "attention receiver"), (&mut self.sender, "attention sender")] {
            let a = layout.block(values, name);
            half.clear();
            half.extend(w.chunks_exact(a.len()).map(|row| row.iter().zip(a).map(|(w, a)| w * a).sum::<f32>()));
            half.resize(padded(a.len()), 0.0);
        }
    }
}

/// Gradients by `W a₁` and `W a₂`: sums over samples.
#[derive(Clone, Debug)]
pub struct AttentionGradient {
    halves: [Vec<f32>; 2],
}

impl AttentionGradient {
    /// Zero, for features of this width.
    pub fn new(width: usize) -> Self {
        Self { halves: [const { Vec::new() }; 2].map(|_: Vec<f32>| vec![0.0; padded(width)]) }
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.halves.iter_mut().for_each(|h| h.fill(0.0));
    }

    /// Adds the gradient by W and writes those by a₁ and a₂ to a flat vector that has the
    /// rest of W's gradient already.
    pub fn store(&self, layout: &ParameterLayout, values: &[f32], out: &mut [f32]) {
        let w = layout.block(values, "graph");
        for (half, name) in self.halves.iter().zip(["attention receiver", "attention sender"]) {
            let a = layout.block(values, name);
            let by_w = layout.block_mut(out, "graph");
            for (row, g) in by_w.chunks_exact_mut(a.len()).zip(half) {
                row.iter_mut().zip(a).for_each(|(s, a)| *s += g * a);
            }
            let by_a = layout.block_mut(out, name);
            by_a.fill(0.0);
            for (row, g) in w.chunks_exact(a.len()).zip(half) {
                by_a.iter_mut().zip(row).for_each(|(s, w)| *s += g * w);
            }
        }
    }
}

/// The scores of a micro-batch and, after the backward pass, the gradients by them.
#[derive(Clone, Debug, Default)]
pub struct AttentionScores {
    /// Slope of the leaky ReLU at the score of each edge.
    slopes: Vec<f32>,
    /// `h·(W a₁)` and `h·(W a₂)` of each row; after the backward pass the gradients by
    /// them.
    halves: [Vec<f32>; 2],
}

impl AttentionScores {
    /// Sets the weights of all edges to those of equation (6): a softmax over each UAV's edges.
    #[inline(always)]
    pub fn weigh(&mut self, edges: &mut Edges, a: &Attention, feature: &Rows) {
        for (scores, half) in self.halves.iter_mut().zip([&a.receiver, &a.sender]) {
            scores.resize(feature.rows(), 0.0);
            // A loop: what `extend` calls is compiled apart, without AVX2.
            for (score, h) in scores.iter_mut().zip(feature.values().chunks_exact(feature.stride())) {
                *score = dot(h, half);
            }
        }
        self.slopes.clear();
        self.slopes.resize(edges.to.len(), 1.0);
        let mut first = 0;
        for (i, &end) in edges.ends.iter().enumerate() {
            let range = first..end as usize;
            let (weights, slopes) = (&mut edges.weights[range.clone()], &mut self.slopes[range.clone()]);
            for ((w, slope), &j) in weights.iter_mut().zip(slopes).zip(&edges.to[range]) {
                let score = self.halves[0][i] + self.halves[1][j as usize];
                *slope = if score < 0.0 { LEAKY_SLOPE } else { 1.0 };
                *w = score * *slope;
            }
            softmax(weights);
            first = end as usize;
        }
    }

    /// The gradients through the weights: adds those by the features to `by_feature`, and those
    /// by attention's parameters to `gradient`.
    #[inline(always)]
    pub fn backward(
        &mut self,
        edges: &Edges,
        by_combined: &Rows,
        feature: &Rows,
        (a, gradient): (&Attention, &mut AttentionGradient),
        by_feature: &mut Rows,
    ) {
        let (stride, h) = (feature.stride(), feature.values());
        self.halves.iter_mut().for_each(|s| s.fill(0.0));
        let [by_receiver, by_sender] = &mut self.halves;
        for (i, (range, g)) in edges.by_uav().zip(by_combined.values().chunks_exact(stride)).enumerate() {
            // Gradient by the softmax's inputs: α_j (g·h_j − Σ_k α_k g·h_k).
            let mut by_weight = [0.0; MAX_NEIGHBOURS + 1];
            let mut mean = 0.0;
            for (b, e) in by_weight.iter_mut().zip(range.clone()) {
                *b = dot(g, &h[edges.to[e] as usize * stride..][..stride]);
                mean += edges.weights[e] * *b;
            }
            for (b, e) in by_weight.iter().zip(range) {
                let by_score = edges.weights[e] * (b - mean) * self.slopes[e];
                by_receiver[i] += by_score;
                by_sender[edges.to[e] as usize] += by_score;
            }
        }
        let by_h = by_feature.values_mut();
        for ((by_scores, half), by_half) in self.halves.iter().zip([&a.receiver, &a.sender]).zip(&mut gradient.halves) {
            let rows = by_h.chunks_exact_mut(stride).zip(h.chunks_exact(stride));
            for (&g, (by_h, h)) in by_scores.iter().zip(rows) {
                add_scaled(by_h, g, half);
                add_scaled(by_half, g, h);
            }
        }
    }
}
