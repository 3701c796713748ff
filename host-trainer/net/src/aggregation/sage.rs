//! The weights of `GraphSAGE`'s mean.

use super::edges::Edges;

/// Sets the weights of all edges to `1/n` for a UAV's n neighbours, to itself zero.
#[inline(always)]
pub fn weigh_alike(edges: &mut Edges) {
    let mut first = 0;
    for &end in &edges.ends {
        // Of each UAV the first edge is that to itself.
        let neighbours = end as usize - first - 1;
        let share = (neighbours.max(1) as f32).recip();
        edges.weights[first] = 0.0;
        edges.weights[first + 1..end as usize].fill(share);
        first = end as usize;
    }
}
