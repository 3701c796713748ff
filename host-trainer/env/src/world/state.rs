//! The state of one world, its reset and its step.

use super::grid::CellGrid;
use super::groups::Groups;
use super::metrics::Totals;
use super::placement::PlacementError;
use super::reward::step_energy;
use super::score::{Score, ScoreInputs};
use super::spawn::spawn;
use crate::scenario::{Scenario, ScenarioError};
use firmware_core::action::Action;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, OBSERVATION_RANGE_U, Vec2};

/// One world: a square map with its UAVs and PoIs, stepped with one action a UAV.
///
/// All slices that it hands out have one entry for each UAV (or for each PoI where the name says so), in the order of
/// their ids. After the first episode neither [`World::reset`] nor [`World::step`] allocates.
#[derive(Clone, Debug)]
pub struct World {
    pub(super) scenario: Scenario,
    pub(super) steps_done: u32,
    pub(super) x: Vec<f32>,
    pub(super) y: Vec<f32>,
    pub(super) vx: Vec<f32>,
    pub(super) vy: Vec<f32>,
    pub(super) poi_x: Vec<f32>,
    pub(super) poi_y: Vec<f32>,
    pub(super) uav_cells: CellGrid,
    pub(super) poi_cells: CellGrid,
    /// Positions of the PoIs in the order of the slots of `poi_cells`.
    pub(super) slot_x: Vec<f32>,
    pub(super) slot_y: Vec<f32>,
    /// The same in ticks, as the observation takes them.
    pub(super) poi_ticks: Vec<Vec2>,
    /// The communication graph as adjacency lists: the neighbours of all UAVs, one UAV after another.
    pub(super) adjacency: Vec<u16>,
    /// Where each UAV's neighbours begin in `adjacency`, and the end.
    pub(super) adjacency_starts: Vec<u32>,
    pub(super) degree: Vec<u32>,
    pub(super) groups: Groups,
    pub(super) score: Score,
    pub(super) totals: Totals,
}

impl World {
    /// World 0 of seed 0, before its first step.
    ///
    /// # Errors
    /// [`ScenarioError`] when the scenario is not valid.
    pub fn new(scenario: &Scenario) -> Result<Self, ScenarioError> {
        scenario.validate()?;
        let (n, p, side) = (scenario.uavs, scenario.pois, scenario.side_u);
        let mut world = Self {
            scenario: scenario.clone(),
            steps_done: 0,
            x: vec![0.0; n],
            y: vec![0.0; n],
            vx: vec![0.0; n],
            vy: vec![0.0; n],
            poi_x: vec![0.0; p],
            poi_y: vec![0.0; p],
            uav_cells: CellGrid::new(side, COMMUNICATION_RANGE_U as f32, n),
            poi_cells: CellGrid::new(side, OBSERVATION_RANGE_U as f32, p),
            slot_x: vec![0.0; p],
            slot_y: vec![0.0; p],
            poi_ticks: vec![Vec2::default(); p],
            adjacency: Vec::new(),
            adjacency_starts: Vec::with_capacity(n + 1),
            degree: vec![0; n],
            groups: Groups::new(n),
            score: Score::new(n, p),
            totals: Totals::default(),
        };
        world.reset(0, 0);
        Ok(world)
    }

    /// Starts a new episode in world `index` of `seed`. Positions are a function of scenario, seed and index alone,
    /// whatever came before and whichever thread asks; UAVs are at rest.
    pub fn reset(&mut self, seed: u64, index: u64) {
        let uav = (&mut self.x[..], &mut self.y[..]);
        let poi = (&mut self.poi_x[..], &mut self.poi_y[..]);
        spawn(&self.scenario, seed, index, uav, poi);
        self.begin();
    }

    /// Starts a new episode with these positions of UAVs and PoIs, (east, north) in u, UAVs at rest.
    ///
    /// # Errors
    /// [`PlacementError`] when their numbers are not the scenario's or a position is not on the map; the world is
    /// then unchanged.
    pub fn set_positions(&mut self, uav: &[(f32, f32)], poi: &[(f32, f32)]) -> Result<(), PlacementError> {
        let Scenario { uavs, pois, side_u, .. } = self.scenario;
        if uav.len() != uavs {
            return Err(PlacementError::Uavs { got: uav.len(), want: uavs });
        }
        if poi.len() != pois {
            return Err(PlacementError::Pois { got: poi.len(), want: pois });
        }
        for (what, points) in [("UAV", uav), ("PoI", poi)] {
            for (index, &(x, y)) in points.iter().enumerate() {
                if !((0.0..=side_u).contains(&x) && (0.0..=side_u).contains(&y)) {
                    return Err(PlacementError::Outside { what, index, x, y, side_u });
                }
            }
        }
        for (i, &(x, y)) in poi.iter().enumerate() {
            (self.poi_x[i], self.poi_y[i]) = (x, y);
        }
        self.respawn(uav);
        Ok(())
    }

    /// Starts a new episode with the same PoIs and the UAVs at rest at these positions on the map.
    pub(crate) fn respawn(&mut self, uav: &[(f32, f32)]) {
        for (i, &(x, y)) in uav.iter().enumerate() {
            (self.x[i], self.y[i]) = (x, y);
        }
        self.begin();
    }

    fn begin(&mut self) {
        self.steps_done = 0;
        self.vx.fill(0.0);
        self.vy.fill(0.0);
        self.poi_cells.rebuild(&self.poi_x, &self.poi_y);
        for (slot, &p) in self.poi_cells.points().iter().enumerate() {
            let (x, y) = (self.poi_x[p as usize], self.poi_y[p as usize]);
            (self.slot_x[slot], self.slot_y[slot]) = (x, y);
            self.poi_ticks[slot] = Vec2::from_u(x, y);
        }
        self.totals = Totals::default();
        self.score.clear();
        self.refresh();
        // The spawn state counts in no metric.
        self.score.steps_covered.fill(0);
    }

    /// One step of the dynamics: moves every UAV by its action, then scores the new state (reward, coverage, energy)
    /// and adds it to the metrics.
    ///
    /// # Panics
    /// When there is not one action for each UAV.
    pub fn step(&mut self, actions: &[Action]) {
        let n = self.x.len();
        assert!(actions.len() == n, "step: {} actions for {n} UAVs", actions.len());
        let side = self.scenario.side_u;
        for (i, action) in actions.iter().enumerate() {
            let (vx, vy) = action.next_velocity((self.vx[i], self.vy[i]));
            (self.vx[i], self.vy[i]) = (vx, vy);
            // The velocity is left as it is at the edge.
            self.x[i] = (self.x[i] + vx).clamp(0.0, side);
            self.y[i] = (self.y[i] + vy).clamp(0.0, side);
        }
        self.steps_done += 1;
        self.refresh();
        self.totals.add(&self.score);
    }

    /// Recomputes the communication graph, groups and scores from the present positions and velocities.
    pub(super) fn refresh(&mut self) {
        for (e, (&vx, &vy)) in self.score.energy.iter_mut().zip(self.vx.iter().zip(&self.vy)) {
            *e = step_energy(vx, vy);
        }
        self.update_graph();
        let inputs = ScoreInputs {
            side_u: self.scenario.side_u,
            x: &self.x,
            y: &self.y,
            poi_x: &self.slot_x,
            poi_y: &self.slot_y,
            pois: &self.poi_cells,
            groups: &self.groups,
        };
        self.score.count_coverage(&inputs);
        self.score.update_rewards(&inputs);
    }

    /// Finds the neighbours of every UAV, and the groups.
    fn update_graph(&mut self) {
        const RANGE2: f32 = (COMMUNICATION_RANGE_U * COMMUNICATION_RANGE_U) as f32;
        self.uav_cells.rebuild(&self.x, &self.y);
        self.groups.clear();
        self.adjacency.clear();
        self.adjacency_starts.clear();
        for i in 0..self.x.len() {
            let (x, y) = (self.x[i], self.y[i]);
            let start = self.adjacency.len();
            self.adjacency_starts.push(start as u32);
            for run in self.uav_cells.around(x, y, COMMUNICATION_RANGE_U as f32) {
                for &j in &self.uav_cells.points()[run] {
                    let j = j as usize;
                    let (dx, dy) = (self.x[j] - x, self.y[j] - y);
                    if j != i && dx * dx + dy * dy <= RANGE2 {
                        self.adjacency.push(j as u16);
                        // The pair comes up twice; once is enough.
                        if j < i {
                            self.groups.join(i, j);
                        }
                    }
                }
            }
            self.degree[i] = (self.adjacency.len() - start) as u32;
        }
        self.adjacency_starts.push(self.adjacency.len() as u32);
        self.groups.number();
    }
}
