//! Flies to the place that the observation itself names the best.

use crate::observer::{Neighbourhood, Observer};
use crate::policy::Policy;
use crate::steering::nearest;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::geometry::SPEED_CAP_U;
use firmware_core::observation::{LEN, Observation, TARGET_VELOCITY_CHANGE};

/// The action that comes nearest to the change of velocity which the observation wants.
#[must_use]
pub fn advice(observation: &Observation, velocity: (f32, f32)) -> Action {
    let wanted = |k: usize| f32::from(observation[TARGET_VELOCITY_CHANGE + k]) * (2 * SPEED_CAP_U) as f32 / 127.0;
    nearest((velocity.0 + wanted(0), velocity.1 + wanted(1)), velocity)
}

/// Decentralised and without memory: it uses nothing but two numbers of the observation
/// that the trained actor sees. Who goes first is settled by tie-breakers kept for the
/// whole flight.
#[derive(Clone, Debug)]
pub struct Follower {
    observer: Observer,
    observations: Vec<Observation>,
    links: Vec<Neighbourhood>,
}

impl Follower {
    /// With the tie-breakers of this policy seed.
    #[must_use]
    pub fn new(policy_seed: u64) -> Self {
        Self { observer: Observer::new(policy_seed, u32::MAX), observations: Vec::new(), links: Vec::new() }
    }
}

impl Policy for Follower {
    fn begin(&mut self, world: &World) {
        self.observations = vec![[0; LEN]; world.scenario().uavs];
        self.links = vec![Neighbourhood::default(); world.scenario().uavs];
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.observer.observe(world, &mut self.observations, &mut self.links);
        for (i, (action, observation)) in actions.iter_mut().zip(&self.observations).enumerate() {
            *action = advice(observation, world.velocity(i));
        }
    }
}
