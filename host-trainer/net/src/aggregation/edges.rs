//! The edges of the communication graphs of a micro-batch.

use super::vectors::add_scaled;
use crate::input::Inputs;
use crate::matrix::Rows;
use std::ops::Range;

/// The edges of each UAV, first to itself and then to its neighbours, with the weights by which
/// features are summed: a sparse matrix, row by row.
#[derive(Clone, Debug, Default)]
pub struct Edges {
    /// Where the edges of each UAV end.
    pub ends: Vec<u32>,
    /// Row at the far end of each edge.
    pub to: Vec<u32>,
    /// Weight of each edge.
    pub weights: Vec<f32>,
}

impl Edges {
    /// Lists the edges, all with weight 1.
    #[inline(always)]
    pub fn list(&mut self, inputs: &Inputs) {
        let uavs = inputs.uavs();
        self.ends.clear();
        self.to.clear();
        for (i, neighbours) in inputs.neighbours().iter().enumerate() {
            self.to.push(i as u32);
            let base = (i - i % uavs) as u32;
            self.to.extend(neighbours.as_slice().iter().map(|&j| base + u32::from(j)));
            self.ends.push(self.to.len() as u32);
        }
        self.weights.clear();
        self.weights.resize(self.to.len(), 1.0);
    }

    /// The edges of each UAV, as indices into the lists.
    #[inline(always)]
    pub fn by_uav(&self) -> impl Iterator<Item = Range<usize>> {
        let mut first = 0;
        self.ends.iter().map(move |&end| {
            let range = first..end as usize;
            first = end as usize;
            range
        })
    }

    /// `combined[i] = Σ_j weight_ij · feature[j]`.
    #[inline(always)]
    pub fn combine(&self, feature: &Rows, combined: &mut Rows) {
        let stride = feature.stride();
        let h = feature.values();
        for (edges, out) in self.by_uav().zip(combined.values_mut().chunks_exact_mut(stride)) {
            out.fill(0.0);
            for e in edges {
                add_scaled(out, self.weights[e], &h[self.to[e] as usize * stride..][..stride]);
            }
        }
    }

    /// The gradient of [`Self::combine`] by the features, at constant weights.
    #[inline(always)]
    pub fn combine_backward(&self, by_combined: &Rows, by_feature: &mut Rows) {
        let stride = by_combined.stride();
        let by_h = by_feature.values_mut();
        by_h.fill(0.0);
        for (edges, g) in self.by_uav().zip(by_combined.values().chunks_exact(stride)) {
            for e in edges {
                add_scaled(&mut by_h[self.to[e] as usize * stride..][..stride], self.weights[e], g);
            }
        }
    }
}
