//! Follows the velocity change that the observation itself recommends.

use crate::observe::{Neighbourhood, Observer};
use crate::policy::Policy;
use crate::steering::nearest_action;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::geometry::SPEED_CAP_U;
use firmware_core::observation::{LEN, Observation, TARGET_VELOCITY_CHANGE};

/// The action nearest to the velocity change that the compact observation recommends (its features from
/// [`TARGET_VELOCITY_CHANGE`] on), for a UAV that flies at `velocity`, u/step. It is [`Follower`]'s choice, and the
/// expert of behaviour cloning.
#[must_use]
pub fn recommended_action(observation: &Observation, velocity: (f32, f32)) -> Action {
    let wanted = |k: usize| f32::from(observation[TARGET_VELOCITY_CHANGE + k]) * (2 * SPEED_CAP_U) as f32 / 127.0;
    nearest_action((velocity.0 + wanted(0), velocity.1 + wanted(1)), velocity)
}

/// Takes the action nearest to the velocity change that the observation recommends.
///
/// Decentralised and without memory: it uses nothing but two features of the observation that the trained actor sees.
/// Tie-breakers are kept for the whole episode.
#[derive(Clone, Debug)]
pub struct Follower {
    observer: Observer,
    observations: Vec<Observation>,
    neighbourhoods: Vec<Neighbourhood>,
}

impl Follower {
    /// A policy that draws its tie-breakers from `policy_seed`.
    #[must_use]
    pub fn new(policy_seed: u64) -> Self {
        Self { observer: Observer::new(policy_seed, u32::MAX), observations: Vec::new(), neighbourhoods: Vec::new() }
    }
}

impl Policy for Follower {
    fn begin(&mut self, world: &World) {
        self.observations = vec![[0; LEN]; world.scenario().uavs];
        self.neighbourhoods = vec![Neighbourhood::default(); world.scenario().uavs];
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.observer.observe(world, &mut self.observations, &mut self.neighbourhoods);
        for (i, (action, observation)) in actions.iter_mut().zip(&self.observations).enumerate() {
            *action = recommended_action(observation, world.velocity(i));
        }
    }
}
