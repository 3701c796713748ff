//! Oracles: they know every PoI from the start.

use crate::assignment::assign;
use crate::baselines::Hover;
use crate::cover::best_sites;
use crate::evaluate::{Evaluation, evaluate_with};
use crate::plane::distance;
use crate::policy::Policy;
use crate::scenario::{Scenario, ScenarioError};
use crate::steering::toward;
use crate::world::World;
use firmware_core::action::Action;

/// Flies each UAV straight to one of the best static sites and keeps it there, as near
/// as the action table lets one that looks a single step ahead. UAVs and sites are
/// matched for the least summed distance; UAVs without a site stay where they spawn.
#[derive(Clone, Debug, Default)]
pub struct FlyToSites {
    targets: Vec<(f32, f32)>,
}

impl FlyToSites {
    /// The oracle needs no settings.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Where each UAV flies in this episode, u.
    #[must_use]
    pub fn targets(&self) -> &[(f32, f32)] {
        &self.targets
    }
}

impl Policy for FlyToSites {
    fn begin(&mut self, world: &World) {
        self.targets = targets(world);
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        for (i, (action, target)) in actions.iter_mut().zip(&self.targets).enumerate() {
            let (x, y) = world.position(i);
            *action = toward((target.0 - x, target.1 - y), world.velocity(i));
        }
    }
}

/// The site of each UAV, or its own position where there are fewer sites.
fn targets(world: &World) -> Vec<(f32, f32)> {
    let sites = best_sites(world).sites;
    let uavs = world.scenario().uavs;
    let mut targets: Vec<_> = (0..uavs).map(|i| world.position(i)).collect();
    let spawn = targets.clone();
    let cost = |s: usize, i: usize| f64::from(distance(sites[s], spawn[i]));
    for (site, uav) in assign(sites.len(), uavs, cost).into_iter().enumerate() {
        targets[uav] = sites[site];
    }
    targets
}

/// What UAVs parked at the best static sites from the start would reach: no policy
/// covers more without flying.
///
/// # Errors
/// When the scenario is not valid.
pub fn evaluate_parked(scenario: &Scenario, seed: u64, worlds: u64) -> Result<Evaluation, ScenarioError> {
    evaluate_with(scenario, worlds, |world, index| {
        world.reset(seed, index);
        world.respawn(&targets(world));
        Hover
    })
}
