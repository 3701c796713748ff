//! The reference: what the trainer's evaluation does in the same world.

use super::coverage::covered_share;
use crate::node::{Decision, observation_hash};
use covey_env::{ActorPolicy, EpisodeMetrics, Snapshot, World};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Mode};
use firmware_core::geometry::State;

/// The trainer's flight of a world.
#[derive(Clone, Debug)]
pub(super) struct ReferenceFlight {
    /// Actions of all UAVs, step by step.
    pub(super) actions: Vec<Vec<Action>>,
    /// Hashes of their observations, step by step.
    pub(super) observations: Vec<Vec<u64>>,
    /// Share of PoIs covered after each step.
    pub(super) coverage: Vec<f64>,
    /// Its metrics.
    pub(super) metrics: EpisodeMetrics,
}

/// Flies a world, which stands at its spawn state, to its end.
pub(super) fn fly_reference(mut world: World, actor: Actor<'_>, policy_seed: u64, mode: Mode) -> ReferenceFlight {
    let mut policy = ActorPolicy::new(actor, policy_seed, mode);
    let (mut actions, mut observations, mut coverage) = (Vec::new(), Vec::new(), Vec::new());
    while !world.done() {
        let step = world.steps_done();
        policy.observe(&world);
        let chosen: Vec<Action> =
            (0..world.scenario().uavs).map(|i| policy.choose(&policy.logits(i), i, step)).collect();
        observations.push(policy.observations().iter().map(observation_hash).collect());
        world.step(&chosen);
        actions.push(chosen);
        coverage.push(covered_share(&world));
    }
    ReferenceFlight { actions, observations, coverage, metrics: world.metrics() }
}

/// Evaluates the trainer's policy in situations that were measured in flight.
pub(super) struct ReferenceEvaluation<'a> {
    world: World,
    policy: ActorPolicy<'a>,
}

impl<'a> ReferenceEvaluation<'a> {
    /// For flights of `world`.
    pub(super) fn new(world: World, actor: Actor<'a>, policy_seed: u64, mode: Mode) -> Self {
        Self { world, policy: ActorPolicy::new(actor, policy_seed, mode) }
    }

    /// Observation hash and action of each UAV where the UAVs are in these `states` at `step`; `None`
    /// when one is off the map, which cannot be in training.
    pub(super) fn evaluate(&mut self, step: u32, states: &[State]) -> Option<Vec<(u64, Action)>> {
        let snapshot = situation(&self.world, step, states)?;
        self.world.restore(&snapshot).ok()?;
        self.policy.observe(&self.world);
        let one = |i| {
            let action = self.policy.choose(&self.policy.logits(i), i, step);
            (observation_hash(&self.policy.observations()[i]), action)
        };
        Some((0..states.len()).map(one).collect())
    }
}

/// A snapshot of the world with its UAVs in these states, made by way of its serialised form.
fn situation(world: &World, step: u32, states: &[State]) -> Option<Snapshot> {
    let mut form = serde_json::to_value(world.snapshot()).ok()?;
    form["steps_done"] = step.into();
    form["uavs"] = states
        .iter()
        .map(|state| {
            let ((x, y), (vx, vy)) = (state.position.to_u(), state.velocity.to_u());
            serde_json::json!({"position": [x, y], "velocity": [vx, vy]})
        })
        .collect();
    serde_json::from_value(form).ok()
}

/// Whether a decision is this action on this observation.
pub(super) fn is_same(decision: &Decision, observation: u64, action: Action) -> bool {
    decision.observation == observation && decision.action == action.index()
}
