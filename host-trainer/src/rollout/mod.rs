//! Collecting experience: worlds that run side by side, what their UAVs observe, the buffer of
//! a rollout, and the advantages computed from it (paper, algorithm 1, lines of the rollout).
//!
//! | file | what |
//! |---|---|
//! | `vec_env` | some worlds side by side, as CleanRL's `envs` |
//! | `observer` | observations in training, over a perfect radio or a lossy one |
//! | `buffer` | the tensors of a rollout |
//! | `worker` | one [`VecEnv`] with its [`RolloutBuffer`] |
//! | `categorical` | the policy's distribution: softmax and sampling |
//! | `gae` | generalised advantage estimation |
//! | `value_norm` | normalisation of returns |
//! | `workers` | the threads that the rollout workers run on |

mod buffer;
mod categorical;
mod gae;
mod observer;
mod value_norm;
mod vec_env;
mod worker;
mod workers;

pub(crate) use buffer::RolloutBuffer;
pub(crate) use categorical::{PADDED_ACTIONS, distribution, padded_row, sample, sum};
pub use value_norm::ValueNorm;
pub(crate) use value_norm::mean_and_deviation;
pub(crate) use vec_env::VecEnv;
pub(crate) use worker::RolloutWorker;
pub use workers::Workers;
