//! What a state is worth: coverage, groups, energy and reward.

use crate::grid::CellGrid;
use crate::groups::Groups;
use firmware_core::geometry::{COVERAGE_RANGE_U, SPEED_CAP_U};

/// Within this distance of the edge a UAV pays, u (the limit is inside).
const BORDER_U: f32 = 5.0;
/// Reward for covering nothing that no group member covers.
const NOTHING: f32 = -1.0;
/// What being near the edge costs.
const BORDER_COST: f32 = 1.0;
/// Share of the group's other PoIs in a UAV's reward.
const GROUP_SHARE: f32 = 0.1;

/// Scores of the present state, one entry a UAV unless said otherwise.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    pub(crate) reward: Vec<f32>,
    pub(crate) individual: Vec<u32>,
    /// PoIs that each UAV and exactly one other of its group cover.
    pub(crate) overlap: Vec<u32>,
    pub(crate) group: Vec<u32>,
    pub(crate) group_size: Vec<u32>,
    pub(crate) near_border: Vec<bool>,
    pub(crate) energy: Vec<f32>,
    /// PoIs covered by any UAV.
    pub(crate) covered: usize,
    /// Steps each PoI was covered in this episode.
    pub(crate) steps_covered: Vec<u32>,
    /// Number of the last group that covered each PoI; numbers never repeat.
    last_group: Vec<u64>,
    /// Which member did first, [`SHARED`] if more than two did.
    owner: Vec<u32>,
    /// Which member did second, [`SHARED`] if none.
    second: Vec<u32>,
    /// Next number for a group.
    next_group: u64,
    /// First number of the present state.
    first_group: u64,
}

const SHARED: u32 = u32::MAX;

/// Positions (and PoIs) a score is made of.
pub(crate) struct Scene<'a> {
    pub(crate) side_u: f32,
    pub(crate) x: &'a [f32],
    pub(crate) y: &'a [f32],
    /// PoIs by slot of `pois`.
    pub(crate) poi_x: &'a [f32],
    pub(crate) poi_y: &'a [f32],
    pub(crate) pois: &'a CellGrid,
    pub(crate) groups: &'a Groups,
}

impl Score {
    pub(crate) fn new(uavs: usize, pois: usize) -> Self {
        Self {
            reward: vec![0.0; uavs],
            individual: vec![0; uavs],
            overlap: vec![0; uavs],
            group: vec![0; uavs],
            group_size: vec![1; uavs],
            near_border: vec![false; uavs],
            energy: vec![0.0; uavs],
            covered: 0,
            steps_covered: vec![0; pois],
            last_group: vec![0; pois],
            owner: vec![SHARED; pois],
            second: vec![SHARED; pois],
            next_group: 1,
            first_group: 1,
        }
    }

    /// A new episode.
    pub(crate) fn clear(&mut self) {
        self.steps_covered.fill(0);
        self.first_group = self.next_group;
    }

    /// Energy of one step at this speed: half to hover, the rest in proportion.
    pub(crate) fn energy_of(vx: f32, vy: f32) -> f32 {
        0.5 + 0.5 / SPEED_CAP_U as f32 * libm::sqrtf(vx * vx + vy * vy)
    }

    /// Counts who covers what. Groups are visited one after another, so for each PoI
    /// the last group that covered it and its one owner there are all that is kept.
    pub(crate) fn count(&mut self, scene: &Scene<'_>) {
        self.first_group = self.next_group;
        self.covered = 0;
        self.individual.fill(0);
        self.overlap.fill(0);
        for members in scene.groups.iter() {
            let group = self.next_group;
            self.next_group += 1;
            let mut covered = 0;
            for &i in members {
                covered += self.count_uav(scene, i, group);
            }
            for &i in members {
                self.group[i as usize] = covered;
                self.group_size[i as usize] = members.len() as u32;
            }
        }
    }

    /// PoIs that `i` is the first of its group to cover.
    fn count_uav(&mut self, scene: &Scene<'_>, i: u32, group: u64) -> u32 {
        const RANGE2: f32 = (COVERAGE_RANGE_U * COVERAGE_RANGE_U) as f32;
        let (x, y) = (scene.x[i as usize], scene.y[i as usize]);
        let mut first = 0;
        for run in scene.pois.around(x, y, COVERAGE_RANGE_U as f32) {
            let points = scene.poi_x[run.clone()].iter().zip(&scene.poi_y[run.clone()]);
            for ((&px, &py), &p) in points.zip(&scene.pois.points()[run]) {
                let (dx, dy) = (px - x, py - y);
                if dx * dx + dy * dy > RANGE2 {
                    continue;
                }
                let p = p as usize;
                let last = self.last_group[p];
                if last != group {
                    if last < self.first_group {
                        self.covered += 1;
                        self.steps_covered[p] += 1;
                    }
                    self.last_group[p] = group;
                    (self.owner[p], self.second[p]) = (i, SHARED);
                    self.individual[i as usize] += 1;
                    first += 1;
                } else if self.owner[p] != SHARED {
                    let (owner, second) = (self.owner[p] as usize, self.second[p]);
                    if second == SHARED {
                        self.individual[owner] -= 1;
                        self.overlap[owner] += 1;
                        self.overlap[i as usize] += 1;
                        self.second[p] = i;
                    } else {
                        self.overlap[owner] -= 1;
                        self.overlap[second as usize] -= 1;
                        self.owner[p] = SHARED;
                    }
                }
            }
        }
        first
    }

    /// Rewards from the counts, positions and energies.
    pub(crate) fn pay(&mut self, scene: &Scene<'_>) {
        for i in 0..self.reward.len() {
            let near = near_border(scene.side_u, scene.x[i], scene.y[i]);
            let (individual, group, size) = (self.individual[i], self.group[i], self.group_size[i]);
            self.near_border[i] = near;
            self.reward[i] = reward(individual, group, size, near, self.energy[i]);
        }
    }

    /// Whether PoI `p` is covered in the present state.
    pub(crate) fn is_covered(&self, p: usize) -> bool {
        self.last_group[p] >= self.first_group
    }
}

/// Whether (x, y) is within 5 u of the edge.
pub(crate) fn near_border(side_u: f32, x: f32, y: f32) -> bool {
    let clear = |v: f32| v > BORDER_U && v < side_u - BORDER_U;
    !(clear(x) && clear(y))
}

/// Reward of a UAV that alone covers `individual` PoIs of the `group` that its group of
/// `size` covers (the paper's equations for the reward, its group term averaged over
/// the other members).
pub(crate) fn reward(individual: u32, group: u32, size: u32, near_border: bool, energy: f32) -> f32 {
    let own = if individual == 0 { NOTHING } else { individual as f32 };
    let shared = if size > 1 { GROUP_SHARE * (group - individual) as f32 / (size - 1) as f32 } else { 0.0 };
    let border = if near_border { BORDER_COST } else { 0.0 };
    (own + shared - border) / energy
}
