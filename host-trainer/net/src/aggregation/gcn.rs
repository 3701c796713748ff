//! The weights of a GCN (paper, equation 5).

use super::edges::Edges;
use covey_env::Neighbourhood;
use firmware_core::observation::MAX_NEIGHBOURS;

/// Sets the weights of all edges to `1/√(d_i d_j)`; a degree counts the UAV itself.
#[inline(always)]
pub fn weigh_by_degree(edges: &mut Edges, neighbours: &[Neighbourhood]) {
    let root: [f32; MAX_NEIGHBOURS + 1] = std::array::from_fn(|n| (n as f32 + 1.0).sqrt().recip());
    let mut first = 0;
    for (own, &end) in neighbours.iter().zip(&edges.ends) {
        let own = root[usize::from(own.count)];
        for e in first..end as usize {
            edges.weights[e] = own * root[usize::from(neighbours[edges.to[e] as usize].count)];
        }
        first = end as usize;
    }
}
