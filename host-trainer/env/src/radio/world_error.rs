//! What is refused about worlds over a radio channel.

use super::error::RadioError;
use crate::scenario::ScenarioError;

/// Why there is no such evaluation or training over a radio channel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RadioWorldError {
    /// The scenario is not valid.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The radio channel is not valid.
    #[error(transparent)]
    Radio(#[from] RadioError),
}
