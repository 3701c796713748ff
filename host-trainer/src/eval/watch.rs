//! Telling how far a measurement is.

use super::config::EvalConfig;
use covey_env::{Policy, World};
use firmware_core::action::Action;

/// Is told, from any thread, of agent-steps that were flown since it was called last.
pub type Watch<'w> = &'w (dyn Fn(u64) + Sync);

/// Nobody wants to know.
pub const UNWATCHED: Watch<'static> = &|_| {};

impl EvalConfig {
    /// Agent-steps of all its worlds.
    #[must_use]
    pub fn agent_steps(&self) -> u64 {
        u64::from(self.worlds) * u64::from(self.scenario.steps) * self.scenario.uavs as u64
    }
}

/// A policy that tells of each step that it flies.
pub(super) struct Watched<'w, P> {
    pub(super) policy: P,
    pub(super) watch: Watch<'w>,
}

impl<P: Policy> Policy for Watched<'_, P> {
    fn begin(&mut self, world: &World) {
        self.policy.begin(world);
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.policy.act(world, actions);
        (self.watch)(actions.len() as u64);
    }
}
