//! The planner with the memory that UAVs have on board.

use super::inputs::{PlannerInputs, Weights};
use super::kernel_table::KernelTable;
use super::known::{Claim, KnownPoi, poi_position};
use super::lookahead::fly_to;
use super::prior_map::PriorMap;
use super::remembering::{ESTIMATE_DECAY_STEPS, priority, weights};
use super::target_selector::TargetSelector;
use crate::plane::widened;
use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::geometry::{OBSERVATION_RANGE_U, Vec2};
use firmware_core::memory::{Knowledge, Memory, flight_steps};

/// Longest planning horizon, steps.
const HORIZON: f64 = 32.0;
/// Weight that the weight of a PoI out of sight decays to …
const OLD: f64 = 0.1;
/// … with this time constant, steps.
const DECAY_STEPS: f64 = 20.0;

/// A planner whose UAVs know what the memory that flies on board ([`Memory`]) knows, and tell each other in a step no more than
/// fits a budget of bytes.
///
/// In a step a UAV looks, tells, hears, and re-plans in one of two rounds: in the first those whose priority is the highest
/// among their neighbours', who tell their targets at once, in the second those who have it among those that still wait.
#[derive(Clone, Debug)]
pub struct RelayingPlanner {
    /// Bytes of knowledge that a UAV may send in a step.
    budget: usize,
    map: Option<(PriorMap, KernelTable)>,
    memories: Vec<Memory>,
    /// What each UAV sends in this step.
    told: Vec<Knowledge>,
    /// Where each UAV is going, ticks.
    targets: Vec<Option<Vec2>>,
    /// Which UAVs have not planned in this step.
    waiting: Vec<bool>,
    pois: Vec<KnownPoi>,
    claims: Vec<Claim>,
    selector: TargetSelector,
}

impl RelayingPlanner {
    /// A planner for any world, whose UAVs send at most `budget` bytes of knowledge in a step (up to
    /// [`MAX_KNOWLEDGE`](firmware_core::memory::MAX_KNOWLEDGE)).
    #[must_use]
    pub fn new(budget: usize) -> Self {
        Self {
            budget,
            map: None,
            memories: Vec::new(),
            told: Vec::new(),
            targets: Vec::new(),
            waiting: Vec::new(),
            pois: Vec::new(),
            claims: Vec::new(),
            selector: TargetSelector::default(),
        }
    }

    /// In every UAV: it looks, tells its neighbours what its memory chooses, and takes in what they tell.
    fn exchange(&mut self, world: &World) {
        let now = world.steps_done();
        for (i, (memory, told)) in self.memories.iter_mut().zip(&mut self.told).enumerate() {
            let (x, y) = world.position(i);
            let seen = world.pois_within(x, y, OBSERVATION_RANGE_U as f32);
            let position = |p: usize| Vec2::from_u(world.poi_x()[p], world.poi_y()[p]);
            memory.begin(now, ticks(world, i), seen.map(position));
            memory.tell(self.budget, told);
        }
        for (i, memory) in self.memories.iter_mut().enumerate() {
            let mut neighbours: Vec<u16> = world.neighbours(i).to_vec();
            neighbours.sort_unstable();
            for j in neighbours {
                let (k, at) = (usize::from(j), ticks(world, j.into()));
                memory.hear(j, at, &self.told[k]);
                let target = self.targets[k].unwrap_or(at);
                memory.hear_target(j, target, flight_steps(target - at));
            }
            memory.settle();
        }
    }

    /// Chooses the target of UAV `i` anew, from what its memory holds.
    fn replan(&mut self, world: &World, (map, kernels): &(PriorMap, KernelTable), i: usize) {
        let now = world.steps_done();
        let left = f64::from(world.scenario().steps.saturating_sub(now));
        let memory = &self.memories[i];
        let (x, y) = world.position(i);
        let (at, own) = (widened((x, y)), ticks(world, i));
        self.pois.clear();
        // Those in view where they are, the others where the memory has them.
        let seen = world.pois_within(x, y, OBSERVATION_RANGE_U as f32);
        self.pois.extend(seen.map(|p| KnownPoi { at: poi_position(world, p), index: Some(p), weight: 1.0 }));
        for p in memory.pois().iter().filter(|p| p.age > 0) {
            let age = f64::from(p.age);
            let weight = if age > 2.0 { OLD + (1.0 - OLD) * libm::exp(-(age - 2.0) / DECAY_STEPS) } else { 1.0 };
            self.pois.push(KnownPoi { at: widened(p.at.middle().to_u()), index: None, weight });
        }
        self.claims.clear();
        for r in memory.reports() {
            let target = widened(r.target.middle().to_u());
            self.claims.push(Claim {
                id: r.id.into(),
                flight: f64::from(r.steps_left()),
                target,
                age: r.age.into(),
                yields: false,
            });
        }
        let inputs = PlannerInputs {
            id: i,
            at,
            velocity: widened(world.velocity(i)),
            horizon: HORIZON.min(left),
            pois: &self.pois,
            claims: &self.claims,
            unknown: (1.0 - self.pois.len() as f64 / world.scenario().pois as f64).max(0.0),
            estimate_factor: (-f64::from(now) / ESTIMATE_DECAY_STEPS).exp(),
            present_target: Some(widened(self.targets[i].unwrap_or(own).to_u())),
        };
        let weights = Weights { hysteresis: 0.0, ..weights(world.scenario().distribution) };
        let pois = &self.pois;
        let target = self.selector.select(&inputs, &weights, map, |column| {
            column.density.fill(0.0);
            for p in pois {
                kernels.add(p.at, column.a, column.rows.clone(), column.density);
            }
            for (explored, b) in column.explored.iter_mut().zip(column.rows) {
                let (x, y) = map.centre((column.a, b));
                *explored = memory.is_explored(Vec2::from_u(x as f32, y as f32));
            }
        });
        if let Some((x, y)) = target {
            self.targets[i] = Some(Vec2::from_u(x as f32, y as f32));
        }
    }

    /// A round of planning: those plan who have priority over all neighbours that still wait, and tell their
    /// targets. In the last one those plan, too, who have no target yet.
    fn plan_round(&mut self, world: &World, map: &(PriorMap, KernelTable), last: bool) {
        let now = world.steps_done();
        let goes = |&i: &usize, waiting: &[bool], targets: &[Option<Vec2>]| {
            let yields = |&j: &u16| {
                !waiting[usize::from(j)] || (priority(j.into(), now), usize::from(j)) < (priority(i, now), i)
            };
            waiting[i] && (last && targets[i].is_none() || world.neighbours(i).iter().all(yields))
        };
        let going: Vec<usize> = (0..self.memories.len()).filter(|i| goes(i, &self.waiting, &self.targets)).collect();
        for &i in &going {
            self.replan(world, map, i);
            self.waiting[i] = false;
        }
        for &i in &going {
            let Some(target) = self.targets[i] else { continue };
            for &j in world.neighbours(i) {
                self.memories[usize::from(j)].hear_target(i as u16, target, flight_steps(target - ticks(world, i)));
            }
        }
    }
}

impl Policy for RelayingPlanner {
    fn begin(&mut self, world: &World) {
        let uavs = world.scenario().uavs;
        self.map = Some(maps(world));
        let half_side = world.scenario().half_side_ticks();
        // World::new bounds the number of UAVs.
        self.memories = (0..uavs).map(|i| Memory::new(i as u16, half_side)).collect();
        self.told = vec![Knowledge::new(); uavs];
        self.targets = vec![None; uavs];
        self.waiting = vec![true; uavs];
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        let map = self.map.take().unwrap_or_else(|| maps(world));
        self.exchange(world);
        self.waiting.fill(true);
        self.plan_round(world, &map, false);
        self.plan_round(world, &map, true);
        for (i, action) in actions.iter_mut().enumerate() {
            let (at, velocity) = (widened(world.position(i)), widened(world.velocity(i)));
            let target = self.targets[i].map_or(at, |t| widened(t.to_u()));
            *action = fly_to(at, velocity, target);
        }
        self.map = Some(map);
    }
}

/// The prior of a world, and kernels on its cells.
fn maps(world: &World) -> (PriorMap, KernelTable) {
    let map = PriorMap::new(world);
    let kernels = KernelTable::new(&map);
    (map, kernels)
}

/// Position of a UAV, ticks.
fn ticks(world: &World, i: usize) -> Vec2 {
    let (x, y) = world.position(i);
    Vec2::from_u(x, y)
}
