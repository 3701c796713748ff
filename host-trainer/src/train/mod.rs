//! MAPPO: shared actor, central critic, clipped objective (paper, algorithm 1).

mod adam;
mod advantage;
mod engine;
mod link;
mod networks;
mod ppo;
mod shard;
mod softmax;
mod trainer;
mod update;
mod workers;

pub use adam::Adam;
pub use advantage::{ValueNorm, advantages};
pub use softmax::sample;
pub use trainer::{Row, Stage, State, Trainer, dimensions};
pub use workers::Workers;
