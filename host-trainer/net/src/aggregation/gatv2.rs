//! The sum of a GATv2 (Brody et al. 2022): `Σ_j α_ij·r_j` with `α` the softmax of
//! `aᵀ LeakyReLU(l_i + r_j)`, where `l = W_l h` is the receiver's and `r = W_r h` the sender's.

use super::attention::LEAKY_SLOPE;
use super::edges::Edges;
use super::vectors::{dot, softmax, total};
use crate::input::Inputs;
use crate::kernel::{LANES, Vectorised, padded, vectorised};
use crate::matrix::Rows;
use crate::parameter_layout::ParameterLayout;
use firmware_core::observation::MAX_NEIGHBOURS;

/// `a`, padded to whole vectors.
#[derive(Clone, Debug, Default)]
pub struct Score(Vec<f32>);

impl Score {
    /// Takes the actor's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        let a = layout.block(values, "attention");
        self.0.clear();
        self.0.extend(a);
        self.0.resize(padded(a.len()), 0.0);
    }
}

/// Gradient by `a`: a sum over samples.
#[derive(Clone, Debug)]
pub struct ScoreGradient(Vec<f32>);

impl ScoreGradient {
    /// Zero, for features of this width.
    pub fn new(width: usize) -> Self {
        Self(vec![0.0; padded(width)])
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.0.fill(0.0);
    }

    /// Writes it to its place in the flat gradient of the network.
    pub fn store(&self, layout: &ParameterLayout, out: &mut [f32]) {
        let place = layout.block_mut(out, "attention");
        place.copy_from_slice(&self.0[..place.len()]);
    }
}

/// The edges of a micro-batch with their weights, kept from the forward to the backward pass.
#[derive(Clone, Debug, Default)]
pub struct ScoredAggregate {
    edges: Edges,
}

impl ScoredAggregate {
    /// `combined[i] = ReLU(Σ_j α_ij · sender[j])` over each UAV itself and its neighbours.
    pub fn forward(&mut self, inputs: &Inputs, a: &Score, [receiver, sender]: [&Rows; 2], combined: &mut Rows) {
        combined.resize(sender.rows());
        vectorised(Forward { edges: &mut self.edges, inputs, a, receiver, sender, combined });
        combined.rectify();
    }

    /// Writes the gradients by `receiver` and `sender`, from that by the sum before its ReLU, and
    /// adds that by `a`.
    pub fn backward(
        &self,
        by_combined: &Rows,
        (a, by_a): (&Score, &mut ScoreGradient),
        [receiver, sender]: [&Rows; 2],
        [by_receiver, by_sender]: [&mut Rows; 2],
    ) {
        by_receiver.resize(sender.rows());
        by_sender.resize(sender.rows());
        let edges = &self.edges;
        vectorised(Backward { edges, by_combined, a, by_a, receiver, sender, by_receiver, by_sender });
        by_receiver.fill_masks();
        by_sender.fill_masks();
    }
}

struct Forward<'a> {
    edges: &'a mut Edges,
    inputs: &'a Inputs,
    a: &'a Score,
    receiver: &'a Rows,
    sender: &'a Rows,
    combined: &'a mut Rows,
}

impl Vectorised for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { edges, inputs, a: Score(a), receiver, sender, combined } = self;
        let (stride, r) = (sender.stride(), sender.values());
        edges.list(inputs);
        let mut first = 0;
        for (&end, l) in edges.ends.iter().zip(receiver.values().chunks_exact(stride)) {
            let range = first..end as usize;
            let weights = &mut edges.weights[range.clone()];
            for (w, &j) in weights.iter_mut().zip(&edges.to[range]) {
                *w = score(a, l, &r[j as usize * stride..][..stride]);
            }
            softmax(weights);
            first = end as usize;
        }
        edges.combine(sender, combined);
    }
}

struct Backward<'a> {
    edges: &'a Edges,
    by_combined: &'a Rows,
    a: &'a Score,
    by_a: &'a mut ScoreGradient,
    receiver: &'a Rows,
    sender: &'a Rows,
    by_receiver: &'a mut Rows,
    by_sender: &'a mut Rows,
}

impl Vectorised for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { edges, by_combined, a: Score(a), by_a, receiver, sender, by_receiver, by_sender } = self;
        let (stride, r) = (sender.stride(), sender.values());
        edges.combine_backward(by_combined, by_sender);
        let by_r = by_sender.values_mut();
        let rows = by_combined.values().chunks_exact(stride).zip(receiver.values().chunks_exact(stride));
        for ((range, (g, l)), by_l) in edges.by_uav().zip(rows).zip(by_receiver.values_mut().chunks_exact_mut(stride)) {
            // Gradient by the scores: α_j (g·r_j − Σ_k α_k g·r_k).
            let mut by_weight = [0.0; MAX_NEIGHBOURS + 1];
            let mut mean = 0.0;
            for (b, e) in by_weight.iter_mut().zip(range.clone()) {
                *b = dot(g, &r[edges.to[e] as usize * stride..][..stride]);
                mean += edges.weights[e] * *b;
            }
            by_l.fill(0.0);
            for (b, e) in by_weight.iter().zip(range) {
                let (by_score, at) = (edges.weights[e] * (b - mean), edges.to[e] as usize * stride);
                let by_sum = &mut by_r[at..][..stride];
                score_backward(by_score, a, &mut by_a.0, [l, &r[at..][..stride]], by_l, by_sum);
            }
        }
    }
}

/// `aᵀ LeakyReLU(l + r)`, in whole vectors.
#[inline(always)]
fn score(a: &[f32], l: &[f32], r: &[f32]) -> f32 {
    let mut sums = [0.0f32; LANES];
    for ((a, l), r) in a.chunks_exact(LANES).zip(l.chunks_exact(LANES)).zip(r.chunks_exact(LANES)) {
        for (sum, ((a, l), r)) in sums.iter_mut().zip(a.iter().zip(l).zip(r)) {
            let x = l + r;
            *sum = a.mul_add(if x < 0.0 { LEAKY_SLOPE * x } else { x }, *sum);
        }
    }
    total(sums)
}

/// Adds the gradients of a score by `a`, `l` and `r` to theirs.
#[inline(always)]
fn score_backward(by_score: f32, a: &[f32], by_a: &mut [f32], [l, r]: [&[f32]; 2], by_l: &mut [f32], by_r: &mut [f32]) {
    let ends = l.chunks_exact(LANES).zip(r.chunks_exact(LANES));
    let by_ends = by_l.chunks_exact_mut(LANES).zip(by_r.chunks_exact_mut(LANES));
    let parts = a.chunks_exact(LANES).zip(by_a.chunks_exact_mut(LANES));
    for (((l, r), (by_l, by_r)), (a, by_a)) in ends.zip(by_ends).zip(parts) {
        for k in 0..LANES {
            let x = l[k] + r[k];
            let slope = if x < 0.0 { LEAKY_SLOPE } else { 1.0 };
            by_a[k] = by_score.mul_add(slope * x, by_a[k]);
            let by_x = by_score * slope * a[k];
            by_l[k] += by_x;
            by_r[k] += by_x;
        }
    }
}
