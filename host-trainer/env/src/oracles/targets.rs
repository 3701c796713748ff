//! Which UAV takes which of the best sites.

use super::assignment::assign;
use super::cover::best_sites;
use crate::plane::distance;
use crate::world::World;

/// The site assigned to each UAV, u, or its own position where there are fewer sites than UAVs.
pub(super) fn targets(world: &World) -> Vec<(f32, f32)> {
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
