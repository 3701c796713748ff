//! The two policies that ignore their observations.

use crate::policy::Policy;
use crate::random::{below, stream};
use crate::world::World;
use firmware_core::action::{ACTIONS, Action};
use rand_chacha::ChaCha8Rng;

/// Draws every action with equal probability.
#[derive(Clone, Debug)]
pub struct Random {
    rng: ChaCha8Rng,
}

impl Random {
    /// A policy for world `index`, which draws actions of its own from `seed`.
    #[must_use]
    pub fn new(seed: u64, index: u64) -> Self {
        Self { rng: stream("covey random policy", seed, index) }
    }
}

impl Policy for Random {
    fn act(&mut self, _: &World, actions: &mut [Action]) {
        for a in actions {
            // Always an action, as the draw is below their number.
            *a = Action::new(below(&mut self.rng, ACTIONS as u32) as u8).unwrap_or(Action::COAST);
        }
    }
}

/// Always action 16, no acceleration: UAVs stay where they spawn.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hover;

impl Policy for Hover {
    fn act(&mut self, _: &World, actions: &mut [Action]) {
        actions.fill(Action::COAST);
    }
}
