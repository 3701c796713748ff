//! What the trainer's own evaluation does in the same world.

use crate::node::{Decision, observation_hash};
use covey_env::{ActorPolicy, EpisodeMetrics, Snapshot, World};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Mode};
use firmware_core::geometry::State;

/// The trainer's flight of a world.
#[derive(Clone, Debug)]
pub struct TrainerFlight {
    /// Actions of all UAVs, step by step.
    pub actions: Vec<Vec<Action>>,
    /// Hashes of their observations, step by step.
    pub observations: Vec<Vec<u64>>,
    /// Share of PoIs covered after each step.
    pub coverage: Vec<f64>,
    /// Its metrics.
    pub metrics: EpisodeMetrics,
}

/// Flies a world, which stands at its spawn state, to its end.
pub fn fly(mut world: World, actor: Actor<'_>, policy_seed: u64, mode: Mode) -> TrainerFlight {
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
    TrainerFlight { actions, observations, coverage, metrics: world.metrics() }
}

/// Share of PoIs that any UAV covers.
pub fn covered_share(world: &World) -> f64 {
    world.covered() as f64 / world.scenario().pois as f64
}

/// Decides as the trainer would in situations that were measured in flight.
pub struct Reviewer<'a> {
    world: World,
    policy: ActorPolicy<'a>,
}

impl<'a> Reviewer<'a> {
    /// For flights of `world`.
    pub fn new(world: World, actor: Actor<'a>, policy_seed: u64, mode: Mode) -> Self {
        Self { world, policy: ActorPolicy::new(actor, policy_seed, mode) }
    }

    /// The trainer's observations (hashed) and actions where all UAVs stood at `step`; `None`
    /// when one was off the map, where the trainer knows no situation.
    pub fn review(&mut self, step: u32, states: &[State]) -> Option<Vec<(u64, Action)>> {
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

/// The world's snapshot with other UAVs in it. Its fields are private, its form is not.
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
pub fn is_same(decision: &Decision, observation: u64, action: Action) -> bool {
    decision.observation == observation && decision.action == action.index()
}
