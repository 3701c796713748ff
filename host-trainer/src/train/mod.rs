//! MAPPO: shared actor, central critic, clipped objective (paper, algorithm 1).

mod adam;
mod advantage;
mod ppo;
mod shard;
mod trainer;
mod update;
mod workers;

pub use adam::Adam;
pub use advantage::{ValueNorm, advantages};
pub use ppo::log_softmax;
pub use shard::{floats, pick};
pub use trainer::{Row, Stage, State, Trainer};
pub use workers::Workers;
