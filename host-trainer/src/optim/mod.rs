//! Learning from rollouts: the PPO loss and its gradient, minibatches, Adam, and the running
//! average of the actor that is exported.
//!
//! | file | what |
//! |---|---|
//! | `ppo_loss` | the loss of a sample and its gradient by logits and value |
//! | `minibatch` | the rollouts of all workers as one training set, shuffled and cut |
//! | `adam` | the optimiser |
//! | `learner` | actor and critic with their parameters and optimisers |
//! | `ema` | exponential moving average of the parameters |

mod adam;
mod ema;
mod learner;
mod minibatch;
mod ppo_loss;

pub use adam::Adam;
pub(crate) use ema::update_ema;
pub(crate) use learner::Learner;
pub(crate) use minibatch::{Minibatches, RolloutBatch, WorldStep, count_samples};
pub(crate) use ppo_loss::{LossSums, PpoLoss, Sample};
