//! On which worlds, and how, policies are evaluated.

use crate::settings::Settings;
use covey_env::Scenario;
use firmware_core::actor::Mode;

/// The worlds of an evaluation, and how actions are taken in them.
#[derive(Clone, Debug)]
pub struct EvalConfig {
    /// Sizes of the worlds.
    pub scenario: Scenario,
    /// Seed of the worlds, and of what the policies draw at random.
    pub seed: u64,
    /// How many worlds: numbers 0 to `worlds` − 1 of the seed. Two are needed for standard errors.
    pub worlds: u32,
    /// How actions are taken from logits.
    pub mode: Mode,
}

impl EvalConfig {
    /// The held-out worlds of a run, actions drawn as in training.
    #[must_use]
    pub fn held_out(s: &Settings) -> Self {
        Self { scenario: s.world(), seed: s.eval_seed, worlds: s.eval_worlds, mode: Mode::Sample }
    }
}
