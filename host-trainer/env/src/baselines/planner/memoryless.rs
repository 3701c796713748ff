//! The planner without memory.

use super::inputs::{PlannerInputs, Weights};
use super::known::{Claim, KnownPoi, SEEN_U, poi_position};
use super::local_map::CellColumn;
use super::lookahead::fly_to;
use super::prior_map::PriorMap;
use super::target_selector::TargetSelector;
use crate::plane::{squared_distance, widened};
use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::geometry::OBSERVATION_RANGE_U;

const WEIGHTS: Weights = Weights {
    reach_u: 9.84,
    sure_u: 8.71,
    prior: 1.31,
    near_known: 0.1,
    near_known_scale: 3.0,
    inertia: 0.3,
    yielding_claim: 0.235,
    hysteresis: 0.0,
};
/// Planning horizon, steps.
const HORIZON: f64 = 8.0;

/// A planner that uses only what the UAV and its neighbours see now, and takes the others to stay where they are: the
/// same information as the trained actor's.
#[derive(Clone, Debug, Default)]
pub struct Planner {
    map: Option<PriorMap>,
    pois: Vec<KnownPoi>,
    claims: Vec<Claim>,
    /// Whether each PoI is in `pois` already.
    listed: Vec<bool>,
    selector: TargetSelector,
}

impl Planner {
    /// A planner for any world.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Where UAV `i` flies, u.
    fn target(&mut self, world: &World, map: &PriorMap, i: usize) -> (f64, f64) {
        let (at, velocity) = (widened(world.position(i)), widened(world.velocity(i)));
        self.claims.clear();
        for &j in world.neighbours(i) {
            let j = usize::from(j);
            let position = widened(world.position(j));
            // Of two UAVs the one with the higher id yields.
            self.claims.push(Claim { id: j, flight: 0.0, target: position, age: 0.0, yields: i < j });
        }
        // In the order of ids, so that sums do not depend on how the world lists neighbours.
        self.claims.sort_unstable_by_key(|c| c.id);
        self.pois.clear();
        self.listed.resize(world.scenario().pois, false);
        let observers = || std::iter::once(at).chain(self.claims.iter().map(|c| c.target));
        for (x, y) in observers() {
            for p in world.pois_within(x as f32, y as f32, OBSERVATION_RANGE_U as f32) {
                if !std::mem::replace(&mut self.listed[p], true) {
                    self.pois.push(KnownPoi { at: poi_position(world, p), index: Some(p), weight: 1.0 });
                }
            }
        }
        self.pois.iter().filter_map(|p| p.index).for_each(|p| self.listed[p] = false);
        let inputs = PlannerInputs {
            id: i,
            at,
            velocity,
            horizon: HORIZON,
            pois: &self.pois,
            claims: &self.claims,
            unknown: 1.0 - self.pois.len() as f64 / world.scenario().pois as f64,
            estimate_factor: 1.0,
            present_target: None,
        };
        let fill_column = |column: CellColumn<'_>| {
            column.density.fill(0.0);
            for p in self.pois.iter().filter_map(|p| p.index) {
                map.add_kernel(p, column.a, column.rows.clone(), column.density);
            }
            for (explored, b) in column.explored.iter_mut().zip(column.rows) {
                let centre = map.centre((column.a, b));
                *explored = observers().any(|o| squared_distance(o, centre) <= SEEN_U * SEEN_U);
            }
        };
        self.selector
            .select(&inputs, &WEIGHTS, map, fill_column)
            .unwrap_or((at.0 + 3.0 * velocity.0, at.1 + 3.0 * velocity.1))
    }
}

impl Policy for Planner {
    fn begin(&mut self, world: &World) {
        self.map = Some(PriorMap::new(world));
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        let map = self.map.take().unwrap_or_else(|| PriorMap::new(world));
        for (i, action) in actions.iter_mut().enumerate() {
            let target = self.target(world, &map, i);
            *action = fly_to(widened(world.position(i)), widened(world.velocity(i)), target);
        }
        self.map = Some(map);
    }
}
