//! What a remembering UAV knows, and what it passes on.

use super::ground::Ground;
use super::place::{Claim, Column, Poi};
use super::{SEEN_U, distance, pair, poi, squared};
use crate::world::World;
use firmware_core::geometry::{OBSERVATION_RANGE_U, SPEED_CAP_U};

/// A step that never was.
const NEVER: u32 = u32::MAX;
/// A UAV that should be this near, u, and is not heard, is elsewhere.
const WOULD_BE_HEARD_U: f64 = 16.0;

/// Where a UAV was and wanted to be at a step.
#[derive(Clone, Copy, Debug)]
struct Report {
    step: u32,
    at: (f64, f64),
    target: (f64, f64),
}

/// What one UAV knows.
#[derive(Clone, Debug)]
pub(super) struct Mind {
    id: usize,
    target: (f64, f64),
    /// Step at which each PoI was last seen by anyone, as far as it heard.
    seen_at: Vec<u32>,
    /// Cells that somebody has seen.
    cells: Vec<bool>,
    /// Summed nearness of the known PoIs, by cell.
    near: Vec<f64>,
    counted: Vec<bool>,
    /// The UAVs' last known places and targets, with their steps.
    others: Vec<Report>,
    places: Vec<(f64, f64)>,
}

impl Mind {
    fn new(id: usize, world: &World, ground: &Ground) -> Self {
        let (n, p, cells) = (world.scenario().uavs, world.scenario().pois, ground.cells() * ground.cells());
        let at = pair(world.position(id));
        Self {
            id,
            target: at,
            seen_at: vec![NEVER; p],
            cells: vec![false; cells],
            near: vec![0.0; cells],
            counted: vec![false; p],
            others: vec![Report { step: NEVER, at, target: at }; n],
            places: (0..p).map(|p| poi(world, p)).collect(),
        }
    }

    fn look(&mut self, world: &World, ground: &Ground) {
        let (x, y) = world.position(self.id);
        let now = world.steps_done();
        for p in world.pois_within(x, y, OBSERVATION_RANGE_U as f32) {
            self.seen_at[p] = now;
        }
        let at = pair((x, y));
        for a in ground.span(at.0, SEEN_U) {
            for b in ground.span(at.1, SEEN_U) {
                if squared(ground.centre((a, b)), at) <= SEEN_U * SEEN_U {
                    self.cells[a * ground.cells() + b] = true;
                }
            }
        }
        self.others[self.id] = Report { step: now, at, target: self.target };
    }

    /// Takes in what another UAV knew after looking.
    fn hear(&mut self, other: &Self) {
        for (own, &heard) in self.seen_at.iter_mut().zip(&other.seen_at) {
            if newer(heard, *own) {
                *own = heard;
            }
        }
        self.cells.iter_mut().zip(&other.cells).for_each(|(own, heard)| *own |= heard);
        for (k, (own, heard)) in self.others.iter_mut().zip(&other.others).enumerate() {
            if k != self.id && newer(heard.step, own.step) {
                *own = *heard;
            }
        }
    }

    fn count(&mut self, ground: &Ground) {
        for p in 0..self.counted.len() {
            if self.seen_at[p] != NEVER && !std::mem::replace(&mut self.counted[p], true) {
                for (c, near) in self.near.iter_mut().enumerate() {
                    *near += ground.nearness(p, (c / ground.cells(), c % ground.cells()));
                }
            }
        }
    }

    /// The known PoIs and the others' claims at step `now`.
    pub(super) fn recall(&self, now: u32, pois: &mut Vec<Poi>, claims: &mut Vec<Claim>) {
        /// What an old PoI is still worth.
        const OLD: f64 = 0.5;
        /// Steps after which a PoI out of sight has come 63 % nearer to that.
        const FADES: f64 = 20.0;
        pois.clear();
        for (p, &seen) in self.seen_at.iter().enumerate().filter(|(_, s)| **s != NEVER) {
            let age = f64::from(now - seen);
            let weight = if age > 2.0 { OLD + (1.0 - OLD) * libm::exp(-(age - 2.0) / FADES) } else { 1.0 };
            pois.push(Poi { at: self.places[p], index: p, weight });
        }
        claims.clear();
        for (id, &Report { step, at, target }) in self.others.iter().enumerate() {
            if id != self.id && step != NEVER {
                claims.push(Claim { id, at, target, age: f64::from(now - step), junior: false });
            }
        }
    }

    /// Forgets UAVs that should be near by now and are not heard.
    fn forget(&mut self, now: u32, own: (f64, f64)) {
        for (id, other) in self.others.iter_mut().enumerate() {
            let Report { step, at, target } = *other;
            if id == self.id || step == NEVER || step == now {
                continue;
            }
            let (flown, far) = (f64::from(now - step) * f64::from(SPEED_CAP_U), distance(at, target));
            let k = if far <= flown { 1.0 } else { flown / far };
            let place = (at.0 + k * (target.0 - at.0), at.1 + k * (target.1 - at.1));
            if squared(place, own) < WOULD_BE_HEARD_U * WOULD_BE_HEARD_U {
                other.step = NEVER;
            }
        }
    }

    pub(super) fn target(&self) -> (f64, f64) {
        self.target
    }

    pub(super) fn set_target(&mut self, target: (f64, f64)) {
        self.target = target;
    }

    /// Fills in a column of cells.
    pub(super) fn show(&self, ground: &Ground, column: Column<'_>) {
        let cells = column.a * ground.cells() + column.rows.start..column.a * ground.cells() + column.rows.end;
        column.near.copy_from_slice(&self.near[cells.clone()]);
        column.seen.copy_from_slice(&self.cells[cells]);
    }
}

fn newer(heard: u32, own: u32) -> bool {
    heard != NEVER && (own == NEVER || heard > own)
}

/// What every UAV knows.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    minds: Vec<Mind>,
    told: Vec<Mind>,
}

impl Memory {
    /// Looks around and exchanges, one hop.
    pub(super) fn sense(&mut self, world: &World, ground: &Ground) {
        if self.minds.is_empty() {
            self.minds = (0..world.scenario().uavs).map(|i| Mind::new(i, world, ground)).collect();
        }
        self.minds.iter_mut().for_each(|m| m.look(world, ground));
        self.told.clone_from(&self.minds);
        let now = world.steps_done();
        for (i, mind) in self.minds.iter_mut().enumerate() {
            for &j in world.neighbours(i) {
                mind.hear(&self.told[usize::from(j)]);
            }
            mind.count(ground);
            mind.forget(now, pair(world.position(i)));
        }
    }

    pub(super) fn mind(&self, i: usize) -> &Mind {
        &self.minds[i]
    }

    pub(super) fn mind_mut(&mut self, i: usize) -> &mut Mind {
        &mut self.minds[i]
    }
}
