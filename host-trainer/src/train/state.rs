//! What a run carries from round to round.

use crate::optim::Adam;
use crate::rollout::ValueNorm;
use serde::{Deserialize, Serialize};

/// The state of a run between two rounds, as checkpoints keep it: the order of the fields is
/// their format. Random numbers are drawn from streams named by the seed and the round, so no
/// generator's state is part of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Rounds done.
    pub rounds: u32,
    /// The actor's parameters.
    pub actor: Vec<f32>,
    /// Exponential moving average of the actor's parameters: what is exported.
    pub average: Vec<f32>,
    /// The critic's parameters.
    pub critic: Vec<f32>,
    /// The actor's optimiser.
    pub actor_adam: Adam,
    /// The critic's optimiser.
    pub critic_adam: Adam,
    /// Normalisation of returns.
    pub norm: ValueNorm,
}
