//! The planner with memory.

use super::belief::Beliefs;
use super::inputs::{PlannerInputs, Weights};
use super::known::{Claim, KnownPoi};
use super::lookahead::fly_to;
use super::prior_map::PriorMap;
use super::target_selector::TargetSelector;
use crate::plane::widened;
use crate::policy::Policy;
use crate::scenario::PoiDistribution;
use crate::world::World;
use firmware_core::action::Action;

const CLUSTERED: Weights = Weights {
    reach_u: 10.0,
    sure_u: 8.84,
    prior: 0.58,
    near_known: 0.3,
    near_known_scale: 1.5,
    inertia: 0.0,
    yielding_claim: 1.0,
    hysteresis: 0.07,
};
/// Where PoIs are uniform, known ones say nothing about the rest.
const UNIFORM: Weights = Weights { prior: 3.0, near_known: 0.0, ..CLUSTERED };
/// Longest planning horizon, steps.
const HORIZON: f64 = 54.0;
/// Time constant with which the estimates about unseen cells decay during an episode, steps.
pub(super) const ESTIMATE_DECAY_STEPS: f64 = 60.0;

/// A planner that remembers PoIs, seen cells and the other UAVs' last positions and targets, and passes all of it on,
/// one hop a step. It re-plans only in steps in which its pseudo-random priority is the highest among its neighbours',
/// so that UAVs in touch do not choose the same target at once. It knows more than the trained actor.
#[derive(Clone, Debug, Default)]
pub struct RememberingPlanner {
    map: Option<PriorMap>,
    beliefs: Beliefs,
    claims: Vec<Claim>,
    pois: Vec<KnownPoi>,
    selector: TargetSelector,
}

impl RememberingPlanner {
    /// A planner for any world.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn replan(&mut self, world: &World, map: &PriorMap, i: usize) {
        let now = world.steps_done();
        let left = f64::from(world.scenario().steps.saturating_sub(now));
        let belief = self.beliefs.of(i);
        belief.list_known(now, &mut self.pois, &mut self.claims);
        let inputs = PlannerInputs {
            id: i,
            at: widened(world.position(i)),
            velocity: widened(world.velocity(i)),
            horizon: HORIZON.min(left),
            pois: &self.pois,
            claims: &self.claims,
            unknown: 1.0 - self.pois.len() as f64 / world.scenario().pois as f64,
            estimate_factor: (-f64::from(now) / ESTIMATE_DECAY_STEPS).exp(),
            present_target: Some(belief.target()),
        };
        let weights = weights(world.scenario().distribution);
        let target = self.selector.select(&inputs, &weights, map, |column| belief.fill_column(map, column));
        if let Some(target) = target {
            self.beliefs.of_mut(i).set_target(target);
        }
    }
}

impl Policy for RememberingPlanner {
    fn begin(&mut self, world: &World) {
        self.map = Some(PriorMap::new(world));
        self.beliefs = Beliefs::default();
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        let map = self.map.take().unwrap_or_else(|| PriorMap::new(world));
        self.beliefs.update(world, &map);
        let now = world.steps_done();
        for (i, action) in actions.iter_mut().enumerate() {
            let own = (priority(i, now), i);
            let has_priority_over = |&j: &u16| (priority(usize::from(j), now), usize::from(j)) < own;
            if now == 0 || world.neighbours(i).iter().all(has_priority_over) {
                self.replan(world, &map, i);
            }
            *action = fly_to(widened(world.position(i)), widened(world.velocity(i)), self.beliefs.of(i).target());
        }
        self.map = Some(map);
    }
}

/// The parameters for worlds of a distribution.
pub(super) const fn weights(distribution: PoiDistribution) -> Weights {
    match distribution {
        PoiDistribution::Clustered => CLUSTERED,
        PoiDistribution::Uniform => UNIFORM,
    }
}

/// A UAV's pseudo-random priority of a step, which every UAV can compute for every other.
pub(super) fn priority(id: usize, step: u32) -> u64 {
    // The finaliser of SplitMix64.
    let mut z = (id as u64 ^ (u64::from(step) << 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
