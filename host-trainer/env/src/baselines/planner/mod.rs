//! Planners written by hand: what a good engineer's controller makes of the same
//! information. They are bars for trained policies and can teach them.
//!
//! A UAV values every place around it by the steps of coverage that it would still win
//! there: for each PoI that it knows, the time left after the flight less the time that
//! another UAV's claim already secures; and the same for cells that nobody has seen, by
//! the PoIs to be expected there. It flies to the best place, refined to 1 u.
//!
//! Both are decentralised: a UAV knows what it sees within 13 u and what UAVs within 18 u
//! tell it, one hop a step.

mod ground;
mod memory;
mod place;
mod steer;

use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::geometry::OBSERVATION_RANGE_U;
use ground::Ground;
use memory::Memory;
use place::{Brief, Chooser, Claim, Column, Weights};
use steer::steer;

/// A cell counts as seen when its centre is within this distance of a UAV, u.
const SEEN_U: f64 = 12.5;

const MEMORYLESS: Weights = Weights {
    reach_u: 9.84,
    sure_u: 8.71,
    prior: 1.31,
    near_known: 0.1,
    near_known_scale: 3.0,
    inertia: 0.3,
    junior_claim: 0.235,
    hysteresis: 0.0,
};
/// Steps that the memoryless planner looks ahead.
const HORIZON: f64 = 8.0;

/// Uses only what the UAV and its neighbours see now; takes the others to stay where
/// they are. The same information as the trained actor's.
#[derive(Clone, Debug, Default)]
pub struct Planner {
    ground: Option<Ground>,
    pois: Vec<place::Poi>,
    claims: Vec<Claim>,
    met: Vec<bool>,
    chooser: Chooser,
}

impl Planner {
    /// For any world.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Where UAV `i` wants to be, u.
    fn target(&mut self, world: &World, ground: &Ground, i: usize) -> (f64, f64) {
        let (at, velocity) = (pair(world.position(i)), pair(world.velocity(i)));
        self.claims.clear();
        for &j in world.neighbours(i) {
            let j = usize::from(j);
            let place = pair(world.position(j));
            self.claims.push(Claim {
                id: j,
                at: place,
                target: place,
                age: 0.0,
                // The lowest id goes first.
                junior: i < j,
            });
        }
        // In the order of ids, so that sums do not depend on how the world lists them.
        self.claims.sort_unstable_by_key(|c| c.id);
        self.pois.clear();
        self.met.resize(world.scenario().pois, false);
        let eyes = || std::iter::once(at).chain(self.claims.iter().map(|c| c.at));
        for (x, y) in eyes() {
            for p in world.pois_within(x as f32, y as f32, OBSERVATION_RANGE_U as f32) {
                if !std::mem::replace(&mut self.met[p], true) {
                    self.pois.push(place::Poi { at: poi(world, p), index: p, weight: 1.0 });
                }
            }
        }
        self.pois.iter().for_each(|p| self.met[p.index] = false);
        let brief = Brief {
            id: i,
            at,
            velocity,
            horizon: HORIZON,
            pois: &self.pois,
            claims: &self.claims,
            unknown: 1.0 - self.pois.len() as f64 / world.scenario().pois as f64,
            fade: 1.0,
            kept: None,
        };
        let look = |column: Column<'_>| {
            column.near.fill(0.0);
            for p in &self.pois {
                ground.add_nearness(p.index, column.a, column.rows.clone(), column.near);
            }
            for (seen, b) in column.seen.iter_mut().zip(column.rows) {
                let centre = ground.centre((column.a, b));
                *seen = eyes().any(|e| squared(e, centre) <= SEEN_U * SEEN_U);
            }
        };
        self.chooser
            .choose(&brief, &MEMORYLESS, ground, look)
            .unwrap_or((at.0 + 3.0 * velocity.0, at.1 + 3.0 * velocity.1))
    }
}

impl Policy for Planner {
    fn begin(&mut self, world: &World) {
        self.ground = Some(Ground::new(world));
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        let ground = self.ground.take().unwrap_or_else(|| Ground::new(world));
        for (i, action) in actions.iter_mut().enumerate() {
            let target = self.target(world, &ground, i);
            *action = steer(pair(world.position(i)), pair(world.velocity(i)), target);
        }
        self.ground = Some(ground);
    }
}

const REMEMBERING: Weights = Weights {
    reach_u: 10.0,
    sure_u: 8.84,
    prior: 0.58,
    near_known: 0.3,
    near_known_scale: 1.5,
    inertia: 0.0,
    junior_claim: 1.0,
    hysteresis: 0.07,
};
/// Where PoIs are uniform, those known tell nothing about the rest.
const REMEMBERING_UNIFORM: Weights = Weights { prior: 3.0, near_known: 0.0, ..REMEMBERING };

/// Remembers PoIs, seen cells and the others' last places and targets, passes all of it
/// on, hop by hop, and re-plans only when its number of the step is the highest among its
/// neighbours', so that linked UAVs do not choose the same place at once. It knows more
/// than the trained actor.
#[derive(Clone, Debug, Default)]
pub struct RememberingPlanner {
    ground: Option<Ground>,
    memory: Memory,
    claims: Vec<Claim>,
    pois: Vec<place::Poi>,
    chooser: Chooser,
}

impl RememberingPlanner {
    /// For any world.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn replan(&mut self, world: &World, ground: &Ground, i: usize) {
        /// Steps that it looks ahead at most.
        const HORIZON: f64 = 54.0;
        /// Steps after which the guess about unseen cells has fallen to 1/e.
        const GUESS_FADES: f64 = 60.0;
        let now = world.steps_done();
        let left = f64::from(world.scenario().steps.saturating_sub(now));
        let mind = self.memory.mind(i);
        mind.recall(now, &mut self.pois, &mut self.claims);
        let brief = Brief {
            id: i,
            at: pair(world.position(i)),
            velocity: pair(world.velocity(i)),
            horizon: HORIZON.min(left),
            pois: &self.pois,
            claims: &self.claims,
            unknown: 1.0 - self.pois.len() as f64 / world.scenario().pois as f64,
            fade: (-f64::from(now) / GUESS_FADES).exp(),
            kept: Some(mind.target()),
        };
        let weights = match world.scenario().distribution {
            crate::PoiDistribution::Clustered => &REMEMBERING,
            crate::PoiDistribution::Uniform => &REMEMBERING_UNIFORM,
        };
        let chosen = self.chooser.choose(&brief, weights, ground, |column| mind.show(ground, column));
        if let Some(target) = chosen {
            self.memory.mind_mut(i).set_target(target);
        }
    }
}

impl Policy for RememberingPlanner {
    fn begin(&mut self, world: &World) {
        self.ground = Some(Ground::new(world));
        self.memory = Memory::default();
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        let ground = self.ground.take().unwrap_or_else(|| Ground::new(world));
        self.memory.sense(world, &ground);
        let now = world.steps_done();
        for (i, action) in actions.iter_mut().enumerate() {
            let own = (turn(i, now), i);
            if now == 0 || world.neighbours(i).iter().all(|&j| (turn(usize::from(j), now), usize::from(j)) < own) {
                self.replan(world, &ground, i);
            }
            *action = steer(pair(world.position(i)), pair(world.velocity(i)), self.memory.mind(i).target());
        }
        self.ground = Some(ground);
    }
}

/// A UAV's number of the step; all know everybody's.
fn turn(id: usize, step: u32) -> u64 {
    // The finaliser of SplitMix64.
    let mut z = (id as u64 ^ (u64::from(step) << 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn pair(p: (f32, f32)) -> (f64, f64) {
    (f64::from(p.0), f64::from(p.1))
}

fn poi(world: &World, p: usize) -> (f64, f64) {
    pair((world.poi_x()[p], world.poi_y()[p]))
}

fn squared(a: (f64, f64), b: (f64, f64)) -> f64 {
    let (x, y) = (a.0 - b.0, a.1 - b.1);
    x * x + y * y
}

fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    squared(a, b).sqrt()
}
