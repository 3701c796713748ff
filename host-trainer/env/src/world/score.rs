//! The scores of one state: which UAV covers what, and the rewards that follow.

use super::grid::CellGrid;
use super::groups::Groups;
use super::reward::{near_border, uav_reward};
use firmware_core::geometry::COVERAGE_RANGE_U;

/// Scores of the present state, one entry for each UAV unless said otherwise.
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
    /// Number of the last group that covered each PoI. Groups are numbered anew in every state and numbers never
    /// repeat, so a number below `first_group` is of an earlier state.
    last_group: Vec<u64>,
    /// The first member of that group found to cover it; [`SHARED`] once more than two members do.
    owner: Vec<u32>,
    /// The second one; [`SHARED`] while there is none.
    second: Vec<u32>,
    /// Next number for a group.
    next_group: u64,
    /// First number of the present state.
    first_group: u64,
}

/// No single UAV.
const SHARED: u32 = u32::MAX;

/// The state that is scored.
pub(crate) struct ScoreInputs<'a> {
    pub(crate) side_u: f32,
    pub(crate) x: &'a [f32],
    pub(crate) y: &'a [f32],
    /// Positions of the PoIs in the order of the slots of `pois`.
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

    /// Begins a new episode.
    pub(crate) fn clear(&mut self) {
        self.steps_covered.fill(0);
        self.first_group = self.next_group;
    }

    /// Counts which UAVs and groups cover which PoIs. Groups are visited one after another, so for each PoI it is
    /// enough to keep the last group that covered it and up to two members that do.
    pub(crate) fn count_coverage(&mut self, inputs: &ScoreInputs<'_>) {
        self.first_group = self.next_group;
        self.covered = 0;
        self.individual.fill(0);
        self.overlap.fill(0);
        for members in inputs.groups.iter() {
            let group = self.next_group;
            self.next_group += 1;
            let mut covered = 0;
            for &i in members {
                covered += self.count_uav(inputs, i, group);
            }
            for &i in members {
                self.group[i as usize] = covered;
                self.group_size[i as usize] = members.len() as u32;
            }
        }
    }

    /// Counts the PoIs within range of UAV `i`; returns how many it is the first of its group to cover.
    fn count_uav(&mut self, inputs: &ScoreInputs<'_>, i: u32, group: u64) -> u32 {
        const RANGE2: f32 = (COVERAGE_RANGE_U * COVERAGE_RANGE_U) as f32;
        let (x, y) = (inputs.x[i as usize], inputs.y[i as usize]);
        let mut first = 0;
        for run in inputs.pois.around(x, y, COVERAGE_RANGE_U as f32) {
            let points = inputs.poi_x[run.clone()].iter().zip(&inputs.poi_y[run.clone()]);
            for ((&px, &py), &p) in points.zip(&inputs.pois.points()[run]) {
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

    /// Rewards from the counts, positions and energies; call it after [`Self::count_coverage`].
    pub(crate) fn update_rewards(&mut self, inputs: &ScoreInputs<'_>) {
        for i in 0..self.reward.len() {
            let near = near_border(inputs.side_u, inputs.x[i], inputs.y[i]);
            let (individual, group, size) = (self.individual[i], self.group[i], self.group_size[i]);
            self.near_border[i] = near;
            self.reward[i] = uav_reward(individual, group, size, near, self.energy[i]);
        }
    }

    /// Whether PoI `p` is covered in the present state.
    pub(crate) fn is_covered(&self, p: usize) -> bool {
        self.last_group[p] >= self.first_group
    }
}
