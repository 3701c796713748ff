//! The simulated world: UAVs with the action table's dynamics, PoIs, the communication graph, reward and metrics.
//!
//! [`World`] is the state and its step; [`World::reset`] spawns a world by seed and index, [`Snapshot`] saves and
//! restores one in the middle of an episode, [`EpisodeMetrics`] sums an episode up.

mod accessors;
mod grid;
mod groups;
mod metrics;
mod placement;
mod reward;
mod score;
mod snapshot;
mod spawn;
mod state;

pub use metrics::EpisodeMetrics;
pub use placement::PlacementError;
pub(crate) use reward::{near_border, step_energy, uav_reward};
pub use snapshot::Snapshot;
pub use state::World;
