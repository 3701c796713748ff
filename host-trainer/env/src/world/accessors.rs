//! What can be read off a world.

use super::metrics::EpisodeMetrics;
use super::state::World;
use crate::scenario::Scenario;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, OBSERVATION_RANGE_U, Vec2};

impl World {
    /// The scenario that the world was made for.
    #[must_use]
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Steps made in this episode.
    #[must_use]
    pub fn steps_done(&self) -> u32 {
        self.steps_done
    }

    /// Whether the episode has run its length. It ends by truncation: the state is not a terminal one.
    #[must_use]
    pub fn done(&self) -> bool {
        self.steps_done >= self.scenario.steps
    }

    /// East positions of the UAVs, u.
    #[must_use]
    pub fn x(&self) -> &[f32] {
        &self.x
    }

    /// North positions of the UAVs, u.
    #[must_use]
    pub fn y(&self) -> &[f32] {
        &self.y
    }

    /// East velocities of the UAVs, u/step.
    #[must_use]
    pub fn vx(&self) -> &[f32] {
        &self.vx
    }

    /// North velocities of the UAVs, u/step.
    #[must_use]
    pub fn vy(&self) -> &[f32] {
        &self.vy
    }

    /// Position of UAV `i`, (east, north) in u.
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn position(&self, i: usize) -> (f32, f32) {
        (self.x[i], self.y[i])
    }

    /// Velocity of UAV `i`, (east, north) in u/step.
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn velocity(&self, i: usize) -> (f32, f32) {
        (self.vx[i], self.vy[i])
    }

    /// East positions of the PoIs, u.
    #[must_use]
    pub fn poi_x(&self) -> &[f32] {
        &self.poi_x
    }

    /// North positions of the PoIs, u.
    #[must_use]
    pub fn poi_y(&self) -> &[f32] {
        &self.poi_y
    }

    /// Indices of the PoIs within `range_u` (u) of the position (`x`, `y`), in an order that depends on the positions
    /// alone.
    pub fn pois_within(&self, x: f32, y: f32, range_u: f32) -> impl Iterator<Item = usize> + '_ {
        self.poi_cells.around(x, y, range_u).flatten().filter_map(move |slot| {
            let (dx, dy) = (self.slot_x[slot] - x, self.slot_y[slot] - y);
            (dx * dx + dy * dy <= range_u * range_u).then(|| self.poi_cells.points()[slot] as usize)
        })
    }

    /// Indices of the UAVs within `range_u` (u) of the position (`x`, `y`), in an order that depends on the positions
    /// alone.
    pub fn uavs_within(&self, x: f32, y: f32, range_u: f32) -> impl Iterator<Item = usize> + '_ {
        self.uav_cells.around(x, y, range_u).flatten().map(|slot| self.uav_cells.points()[slot] as usize).filter(
            move |&i| {
                let (dx, dy) = (self.x[i] - x, self.y[i] - y);
                dx * dx + dy * dy <= range_u * range_u
            },
        )
    }

    /// Positions in ticks of the PoIs in observation range of UAV `i`, and possibly of some others near by.
    #[inline]
    pub(crate) fn poi_ticks_near(&self, i: usize) -> impl Iterator<Item = Vec2> + '_ {
        let runs = self.poi_cells.around(self.x[i], self.y[i], OBSERVATION_RANGE_U as f32);
        runs.flat_map(|run| &self.poi_ticks[run]).copied()
    }

    /// Indices of the UAVs in communication range of UAV `i`, itself included, and possibly of some others near by.
    #[inline]
    pub(crate) fn uavs_near(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        let runs = self.uav_cells.around(self.x[i], self.y[i], COMMUNICATION_RANGE_U as f32);
        runs.flat_map(|run| &self.uav_cells.points()[run]).map(|&j| j as usize)
    }

    /// Number of PoIs that each UAV and exactly one other of its group cover: what the UAV's presence takes from the
    /// others' individual coverage.
    #[must_use]
    pub fn overlaps(&self) -> &[u32] {
        &self.score.overlap
    }

    /// Reward of each UAV in the last step; before the first step, the reward of the spawn state.
    #[must_use]
    pub fn rewards(&self) -> &[f32] {
        &self.score.reward
    }

    /// Number of PoIs that each UAV covers and no other member of its group does.
    #[must_use]
    pub fn individual(&self) -> &[u32] {
        &self.score.individual
    }

    /// Number of PoIs that each UAV's group covers.
    #[must_use]
    pub fn group(&self) -> &[u32] {
        &self.score.group
    }

    /// Number of UAVs in each UAV's group, itself included.
    #[must_use]
    pub fn group_size(&self) -> &[u32] {
        &self.score.group_size
    }

    /// Number of UAVs in communication range of each UAV, without itself.
    #[must_use]
    pub fn degree(&self) -> &[u32] {
        &self.degree
    }

    /// Indices of the UAVs in communication range of UAV `i`, in an order that depends on the positions alone.
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn neighbours(&self, i: usize) -> &[u16] {
        &self.adjacency[self.adjacency_starts[i] as usize..self.adjacency_starts[i + 1] as usize]
    }

    /// Whether each UAV is within 5 u of the edge, where it pays the border cost.
    #[must_use]
    pub fn near_border(&self) -> &[bool] {
        &self.score.near_border
    }

    /// Energy that each UAV spent in the last step, 0.5 (hovering) to 1 (full speed).
    #[must_use]
    pub fn energy(&self) -> &[f32] {
        &self.score.energy
    }

    /// Number of PoIs that any UAV covers.
    #[must_use]
    pub fn covered(&self) -> usize {
        self.score.covered
    }

    /// Whether any UAV covers PoI `p`.
    ///
    /// # Panics
    /// When there is no PoI `p`.
    #[must_use]
    pub fn poi_is_covered(&self, p: usize) -> bool {
        self.score.is_covered(p)
    }

    /// Metrics of the steps made so far; all zero before the first.
    #[must_use]
    pub fn metrics(&self) -> EpisodeMetrics {
        self.totals.metrics(&self.score)
    }
}
