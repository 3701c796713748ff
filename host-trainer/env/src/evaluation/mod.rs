//! Evaluation of policies on held-out worlds, and recorded episodes.

mod evaluate;
mod result;
mod rollout;
mod trace;

pub use evaluate::{evaluate, evaluate_with, policy_seed};
pub use result::Evaluation;
pub(crate) use rollout::rollout;
pub use trace::{Frame, Trace};
