//! MAPPO: shared actor, central critic, clipped objective (paper, algorithm 1).
//!
//! For those who know CleanRL's `ppo.py`: [`Trainer::round`] is its main loop, of an episode in
//! every world; `train/update.rs` its epochs and minibatches; `optim/ppo_loss.rs` the loss;
//! `rollout/worker.rs` the rollout and `rollout/gae.rs` the advantages. `num_envs`,
//! `rollout_steps` and the others are [settings](crate::settings::Settings) of the same names.
//!
//! | file | what |
//! |---|---|
//! | `trainer` | a run in memory, and one round of it |
//! | `update` | the epochs over a rollout |
//! | `state` | what a checkpoint keeps |
//! | `round_metrics` | what a round gives |
//! | `architecture` | widths and parameter layouts of the networks |
//! | `stages` | parts of the work alone, for `bench` |

mod architecture;
mod round_metrics;
mod stages;
mod state;
mod trainer;
mod update;

pub use crate::rollout::Workers;
pub use architecture::dimensions;
pub use round_metrics::RoundMetrics;
pub use stages::Stage;
pub use state::State;
pub use trainer::Trainer;
