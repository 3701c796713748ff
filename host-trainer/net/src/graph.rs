//! Combining the features of a neighbourhood, before the graph layer's weights: with
//! weights `1/√(d_i d_j)` (paper, equation 5) or attention (equation 6).

use crate::inputs::Inputs;
use crate::kernel::{LANES, Vectorised, vectorised};
use crate::math::exp;
use crate::matrix::Rows;
use crate::parameter_layout::ParameterLayout;
use covey_env::Neighbourhood;
use firmware_core::observation::MAX_NEIGHBOURS;

/// Slope of the attention's leaky ReLU below zero.
const LEAKY_SLOPE: f32 = 0.2;

/// What attention scores features by: `aᵀ[W h_i ‖ W h_j]` is `h_i·(W a₁) + h_j·(W a₂)`.
#[derive(Clone, Debug, Default)]
pub struct Attention {
    /// `W a₁`, padded to whole vectors.
    receiver: Vec<f32>,
    /// `W a₂`.
    sender: Vec<f32>,
}

impl Attention {
    /// From the actor's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        let w = layout.piece(values, "graph");
        for (half, name) in [(&mut self.receiver, "attention receiver"), (&mut self.sender, "attention sender")] {
            let a = layout.piece(values, name);
            half.clear();
            half.extend(w.chunks_exact(a.len()).map(|row| row.iter().zip(a).map(|(w, a)| w * a).sum::<f32>()));
            half.resize(crate::kernel::padded(a.len()), 0.0);
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
        Self { halves: [const { Vec::new() }; 2].map(|_: Vec<f32>| vec![0.0; crate::kernel::padded(width)]) }
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.halves.iter_mut().for_each(|h| h.fill(0.0));
    }

    /// Adds the gradient by W and writes those by a₁ and a₂ to a flat vector that has the
    /// rest of W's gradient already.
    pub fn store(&self, layout: &ParameterLayout, values: &[f32], out: &mut [f32]) {
        let w = layout.piece(values, "graph");
        for (half, name) in self.halves.iter().zip(["attention receiver", "attention sender"]) {
            let a = layout.piece(values, name);
            let by_w = layout.piece_mut(out, "graph");
            for (row, g) in by_w.chunks_exact_mut(a.len()).zip(half) {
                row.iter_mut().zip(a).for_each(|(s, a)| *s += g * a);
            }
            let by_a = layout.piece_mut(out, name);
            by_a.fill(0.0);
            for (row, g) in w.chunks_exact(a.len()).zip(half) {
                by_a.iter_mut().zip(row).for_each(|(s, w)| *s += g * w);
            }
        }
    }
}

/// The edges of a pass and their weights: of each UAV first itself, then its neighbours.
#[derive(Clone, Debug, Default)]
pub struct Edges {
    /// Where the edges of each UAV end.
    ends: Vec<u32>,
    /// Row at the far end.
    to: Vec<u32>,
    /// Weight.
    weights: Vec<f32>,
    /// With attention: slope of the leaky ReLU at the edge's score.
    slopes: Vec<f32>,
    /// With attention: `h·(W a₁)` and `h·(W a₂)` of each row; on the way back their gradients.
    scores: [Vec<f32>; 2],
}

impl Edges {
    /// `combined[i] = Σ_j weight_ij · feature[j]`; with attention if there is one.
    pub fn forward(&mut self, inputs: &Inputs, attention: Option<&Attention>, feature: &Rows, combined: &mut Rows) {
        combined.resize(feature.rows());
        vectorised(Forward { edges: self, inputs, attention, feature, combined });
        // Hardly any are zero.
        combined.mark_all();
    }

    /// Writes to `by_feature` what `by_combined` gives it, and adds to `sum` with attention.
    pub fn backward(
        &mut self,
        by_combined: &Rows,
        feature: &Rows,
        attention: Option<(&Attention, &mut AttentionGradient)>,
        by_feature: &mut Rows,
    ) {
        by_feature.resize(feature.rows());
        vectorised(Backward { edges: self, by_combined, feature, attention, by_feature });
    }

    /// Lists the edges.
    #[inline(always)]
    fn list(&mut self, links: &[Neighbourhood], uavs: usize) {
        self.ends.clear();
        self.to.clear();
        for (i, link) in links.iter().enumerate() {
            self.to.push(i as u32);
            let base = (i - i % uavs) as u32;
            self.to.extend(link.as_slice().iter().map(|&j| base + u32::from(j)));
            self.ends.push(self.to.len() as u32);
        }
        self.weights.clear();
        self.weights.resize(self.to.len(), 1.0);
    }

    /// Weights `1/√(d_i d_j)`; a degree counts the UAV itself.
    #[inline(always)]
    fn weigh_by_degree(&mut self, links: &[Neighbourhood]) {
        let root: [f32; MAX_NEIGHBOURS + 1] = std::array::from_fn(|n| (n as f32 + 1.0).sqrt().recip());
        let mut first = 0;
        for (link, &end) in links.iter().zip(&self.ends) {
            let own = root[usize::from(link.count)];
            for e in first..end as usize {
                self.weights[e] = own * root[usize::from(links[self.to[e] as usize].count)];
            }
            first = end as usize;
        }
    }

    /// Weights of equation (6).
    #[inline(always)]
    fn weigh_by_attention(&mut self, a: &Attention, feature: &Rows) {
        for (scores, half) in self.scores.iter_mut().zip([&a.receiver, &a.sender]) {
            scores.resize(feature.rows(), 0.0);
            // A loop: what `extend` calls is compiled apart, without AVX2.
            for (score, h) in scores.iter_mut().zip(feature.values().chunks_exact(feature.step())) {
                *score = dot(h, half);
            }
        }
        self.slopes.clear();
        self.slopes.resize(self.to.len(), 1.0);
        let mut first = 0;
        for (i, &end) in self.ends.iter().enumerate() {
            let range = first..end as usize;
            let (weights, slopes) = (&mut self.weights[range.clone()], &mut self.slopes[range.clone()]);
            let mut top = f32::NEG_INFINITY;
            for ((w, slope), &j) in weights.iter_mut().zip(slopes).zip(&self.to[range]) {
                let score = self.scores[0][i] + self.scores[1][j as usize];
                *slope = if score < 0.0 { LEAKY_SLOPE } else { 1.0 };
                *w = score * *slope;
                top = top.max(*w);
            }
            let mut sum = 0.0;
            for w in weights.iter_mut() {
                *w = exp(*w - top);
                sum += *w;
            }
            weights.iter_mut().for_each(|w| *w /= sum);
            first = end as usize;
        }
    }
}

struct Forward<'a> {
    edges: &'a mut Edges,
    inputs: &'a Inputs,
    attention: Option<&'a Attention>,
    feature: &'a Rows,
    combined: &'a mut Rows,
}

impl Vectorised for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { edges, inputs, attention, feature, combined } = self;
        edges.list(inputs.links(), inputs.uavs());
        match attention {
            None => edges.weigh_by_degree(inputs.links()),
            Some(a) => edges.weigh_by_attention(a, feature),
        }
        let step = feature.step();
        let (h, mut first) = (feature.values(), 0);
        for (&end, out) in edges.ends.iter().zip(combined.values_mut().chunks_exact_mut(step)) {
            out.fill(0.0);
            for e in first..end as usize {
                add_scaled(out, edges.weights[e], &h[edges.to[e] as usize * step..][..step]);
            }
            first = end as usize;
        }
    }
}

struct Backward<'a> {
    edges: &'a mut Edges,
    by_combined: &'a Rows,
    feature: &'a Rows,
    attention: Option<(&'a Attention, &'a mut AttentionGradient)>,
    by_feature: &'a mut Rows,
}

impl Vectorised for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { edges, by_combined, feature, attention, by_feature } = self;
        let (step, h) = (feature.step(), feature.values());
        let by_h = by_feature.values_mut();
        by_h.fill(0.0);
        let mut first = 0;
        for (&end, g) in edges.ends.iter().zip(by_combined.values().chunks_exact(step)) {
            for e in first..end as usize {
                add_scaled(&mut by_h[edges.to[e] as usize * step..][..step], edges.weights[e], g);
            }
            first = end as usize;
        }
        let Some((a, sum)) = attention else { return };
        edges.scores.iter_mut().for_each(|s| s.fill(0.0));
        let [by_receiver, by_sender] = &mut edges.scores;
        let mut first = 0;
        for (i, (&end, g)) in edges.ends.iter().zip(by_combined.values().chunks_exact(step)).enumerate() {
            // Gradient by the softmax's inputs: α_j (g·h_j − Σ_k α_k g·h_k).
            let mut by_weight = [0.0; MAX_NEIGHBOURS + 1];
            let range = first..end as usize;
            let mut mean = 0.0;
            for (b, e) in by_weight.iter_mut().zip(range.clone()) {
                *b = dot(g, &h[edges.to[e] as usize * step..][..step]);
                mean += edges.weights[e] * *b;
            }
            for (b, e) in by_weight.iter().zip(range) {
                let by_score = edges.weights[e] * (b - mean) * edges.slopes[e];
                by_receiver[i] += by_score;
                by_sender[edges.to[e] as usize] += by_score;
            }
            first = end as usize;
        }
        for ((by_scores, half), by_half) in edges.scores.iter().zip([&a.receiver, &a.sender]).zip(&mut sum.halves) {
            let rows = by_h.chunks_exact_mut(step).zip(h.chunks_exact(step));
            for (&g, (by_h, h)) in by_scores.iter().zip(rows) {
                add_scaled(by_h, g, half);
                add_scaled(by_half, g, h);
            }
        }
    }
}

/// `sum += scale · x`, in whole vectors.
#[inline(always)]
fn add_scaled(sum: &mut [f32], scale: f32, x: &[f32]) {
    for (sum, x) in sum.chunks_exact_mut(LANES).zip(x.chunks_exact(LANES)) {
        sum.iter_mut().zip(x).for_each(|(s, x)| *s = scale.mul_add(*x, *s));
    }
}

/// `a·b`, in whole vectors.
#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0f32; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(s, (a, b))| *s = a.mul_add(*b, *s));
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
