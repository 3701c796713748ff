//! What the paper flies, and the names of its algorithms.

use firmware_core::actor::Aggregation;

/// The paper's three algorithms, which its statements are about.
pub const ALGORITHMS: [Aggregation; 3] = [Aggregation::None, Aggregation::Gcn, Aggregation::Gat];

/// Numbers of UAVs with which the paper flies its trained policies.
pub const SIZES: [u16; 6] = [5, 10, 15, 20, 25, 30];

/// Worlds that the paper flies with each number of UAVs.
pub const WORLDS: u32 = 100;

/// The algorithm's name in tables and pictures.
#[must_use]
pub const fn title(graph: Aggregation) -> &'static str {
    match graph {
        Aggregation::None => "plain PPO",
        Aggregation::Gcn => "GCN",
        Aggregation::Gat => "GAT",
        Aggregation::GatV2 => "GATv2",
        Aggregation::Sage => "GraphSAGE",
    }
}
