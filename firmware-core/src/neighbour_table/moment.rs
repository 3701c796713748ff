//! Moments on the swarm's common clock.

use serde::{Deserialize, Serialize};

/// A moment on the swarm's common clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Moment {
    /// Number of the step.
    pub step: u32,
    /// Time, ms.
    pub time_ms: u32,
}
