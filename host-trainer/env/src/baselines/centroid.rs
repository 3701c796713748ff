//! The centroid heuristic: attraction to the centroid of the PoIs that no neighbour covers, repulsion from neighbours.

use crate::plane::{distance, squared_distance};
use crate::policy::Policy;
use crate::random::{between, stream};
use crate::steering::fly_toward;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, COVERAGE_RANGE_U, OBSERVATION_RANGE_U};
use rand_chacha::ChaCha8Rng;

/// Gain of the repulsion from neighbours.
const REPULSION: f32 = 0.5;
/// A waypoint is reached within this distance, u.
const REACHED_U: f32 = 4.0;
/// Waypoints keep this fraction of the side from the edge.
const WAYPOINT_MARGIN: f64 = 0.2;

/// Flies to the centroid of the PoIs in view that no neighbour covers, and away from neighbours; without such PoIs to
/// random waypoints.
///
/// Decentralised: a UAV uses the PoIs within 13 u and the positions of the UAVs within 18 u, nothing else.
#[derive(Clone, Debug)]
pub struct Centroid {
    rng: ChaCha8Rng,
    /// Where each UAV searches next, u.
    waypoints: Vec<(f32, f32)>,
}

impl Centroid {
    /// A policy for world `index`, which draws waypoints of its own from `seed`.
    #[must_use]
    pub fn new(seed: u64, index: u64) -> Self {
        Self { rng: stream("covey centroid", seed, index), waypoints: Vec::new() }
    }

    fn waypoint(&mut self, side_u: f32) -> (f32, f32) {
        let side = f64::from(side_u);
        let mut axis = || between(&mut self.rng, WAYPOINT_MARGIN * side, (1.0 - WAYPOINT_MARGIN) * side) as f32;
        (axis(), axis())
    }
}

impl Policy for Centroid {
    fn begin(&mut self, world: &World) {
        self.waypoints.clear();
        for _ in 0..world.scenario().uavs {
            let w = self.waypoint(world.scenario().side_u);
            self.waypoints.push(w);
        }
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        for (i, action) in actions.iter_mut().enumerate() {
            let (x, y) = world.position(i);
            let attraction = attraction_of_free_pois(world, i).unwrap_or_else(|| {
                if distance(self.waypoints[i], (x, y)) < REACHED_U {
                    self.waypoints[i] = self.waypoint(world.scenario().side_u);
                }
                let (wx, wy) = self.waypoints[i];
                (wx - x, wy - y)
            });
            let repulsion = repulsion_of_neighbours(world, i);
            *action = fly_toward((attraction.0 + repulsion.0, attraction.1 + repulsion.1), world.velocity(i));
        }
    }
}

/// Mean offset (u) of the PoIs in view that no neighbour covers; `None` without any.
fn attraction_of_free_pois(world: &World, i: usize) -> Option<(f32, f32)> {
    const RANGE2: f32 = (COVERAGE_RANGE_U * COVERAGE_RANGE_U) as f32;
    let (x, y) = world.position(i);
    let (mut sum, mut count) = ((0.0, 0.0), 0.0);
    for p in world.pois_within(x, y, OBSERVATION_RANGE_U as f32) {
        let (px, py) = (world.poi_x()[p], world.poi_y()[p]);
        let covered =
            world.neighbours(i).iter().any(|&j| squared_distance(world.position(usize::from(j)), (px, py)) <= RANGE2);
        if !covered {
            sum = (sum.0 + px - x, sum.1 + py - y);
            count += 1.0;
        }
    }
    (count > 0.0).then(|| (sum.0 / count, sum.1 / count))
}

/// Sum over neighbours at distance d of `REPULSION · (18 − d)` along the direction away from each, u.
fn repulsion_of_neighbours(world: &World, i: usize) -> (f32, f32) {
    let (x, y) = world.position(i);
    let mut sum = (0.0, 0.0);
    for &j in world.neighbours(i) {
        let (jx, jy) = world.position(usize::from(j));
        let d = distance((x, y), (jx, jy));
        // On the same spot there is no direction away.
        if d > 0.0 {
            let k = REPULSION * (COMMUNICATION_RANGE_U as f32 - d) / d;
            sum = (sum.0 + k * (x - jx), sum.1 + k * (y - jy));
        }
    }
    sum
}
