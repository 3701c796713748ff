//! What can be read off a world.

use crate::metrics::EpisodeMetrics;
use crate::scenario::Scenario;
use crate::world::World;

impl World {
    /// The scenario.
    #[must_use]
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Steps made in this episode.
    #[must_use]
    pub fn steps_done(&self) -> u32 {
        self.steps_done
    }

    /// Whether the episode has run its length. It ends by truncation: the state is
    /// not terminal.
    #[must_use]
    pub fn done(&self) -> bool {
        self.steps_done >= self.scenario.steps
    }

    /// East positions, u.
    #[must_use]
    pub fn x(&self) -> &[f32] {
        &self.x
    }

    /// North positions, u.
    #[must_use]
    pub fn y(&self) -> &[f32] {
        &self.y
    }

    /// East velocities, u/step.
    #[must_use]
    pub fn vx(&self) -> &[f32] {
        &self.vx
    }

    /// North velocities, u/step.
    #[must_use]
    pub fn vy(&self) -> &[f32] {
        &self.vy
    }

    /// Position of UAV `i`, u.
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn position(&self, i: usize) -> (f32, f32) {
        (self.x[i], self.y[i])
    }

    /// Velocity of UAV `i`, u/step.
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

    /// PoIs within `range_u` of a place, in no particular order (but always the same).
    pub fn pois_within(&self, x: f32, y: f32, range_u: f32) -> impl Iterator<Item = usize> + '_ {
        self.poi_cells.around(x, y, range_u).flatten().filter_map(move |slot| {
            let (dx, dy) = (self.slot_x[slot] - x, self.slot_y[slot] - y);
            (dx * dx + dy * dy <= range_u * range_u).then(|| self.poi_cells.points()[slot] as usize)
        })
    }

    /// UAVs within `range_u` of a place, in no particular order (but always the same).
    pub fn uavs_within(&self, x: f32, y: f32, range_u: f32) -> impl Iterator<Item = usize> + '_ {
        self.uav_cells.around(x, y, range_u).flatten().map(|slot| self.uav_cells.points()[slot] as usize).filter(
            move |&i| {
                let (dx, dy) = (self.x[i] - x, self.y[i] - y);
                dx * dx + dy * dy <= range_u * range_u
            },
        )
    }

    /// PoIs that each UAV and exactly one other of its group cover: what a UAV's presence
    /// takes from the others' individual coverage.
    #[must_use]
    pub fn overlaps(&self) -> &[u32] {
        &self.score.overlap
    }

    /// Rewards of the last step. Before the first, what the spawn state would pay.
    #[must_use]
    pub fn rewards(&self) -> &[f32] {
        &self.score.reward
    }

    /// PoIs that the UAV alone covers in its group.
    #[must_use]
    pub fn individual(&self) -> &[u32] {
        &self.score.individual
    }

    /// PoIs that the UAV's group covers.
    #[must_use]
    pub fn group(&self) -> &[u32] {
        &self.score.group
    }

    /// UAVs in the UAV's group, itself included.
    #[must_use]
    pub fn group_size(&self) -> &[u32] {
        &self.score.group_size
    }

    /// UAVs in communication range, without itself.
    #[must_use]
    pub fn degree(&self) -> &[u32] {
        &self.degree
    }

    /// UAVs in communication range of UAV `i`, in no particular order (but always the
    /// same).
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn neighbours(&self, i: usize) -> &[u16] {
        &self.linked[self.linked_from[i] as usize..self.linked_from[i + 1] as usize]
    }

    /// Whether the UAV is within 5 u of the edge.
    #[must_use]
    pub fn near_border(&self) -> &[bool] {
        &self.score.near_border
    }

    /// Energy of the step, 0.5 (hovering) to 1 (full speed).
    #[must_use]
    pub fn energy(&self) -> &[f32] {
        &self.score.energy
    }

    /// PoIs covered by any UAV.
    #[must_use]
    pub fn covered(&self) -> usize {
        self.score.covered
    }

    /// Whether PoI `p` is covered by any UAV.
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
