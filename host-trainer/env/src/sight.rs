//! What each UAV sees: the board's own observation.

use crate::world::World;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, OBSERVATION_RANGE_U, State, TICKS_PER_U, Vec2};
use firmware_core::observation::{MAX_NEIGHBOURS, Neighbour, Neighbours, Observation, Scene, observe};
use firmware_core::random::tie_breaker;

/// The neighbours that a UAV keeps: those its graph layer aggregates over, besides
/// itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Links {
    /// How many.
    pub count: u8,
    /// Their ids, nearest first; zeros beyond `count`.
    pub to: [u16; MAX_NEIGHBOURS],
}

impl Links {
    /// Ids of the neighbours, nearest first.
    #[must_use]
    pub fn as_slice(&self) -> &[u16] {
        &self.to[..usize::from(self.count)]
    }
}

/// What the board knows of a UAV at a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Beacon {
    state: State,
    tie: i8,
}

impl World {
    /// Writes the observation and the kept neighbours of every UAV in the present
    /// state. Positions are rounded to ticks first, as on board; ids are the UAVs'
    /// indices and the step is [`World::steps_done`]. Tie-breakers are drawn from
    /// `policy_seed` anew every `tie_period` steps.
    ///
    /// # Panics
    /// When `out` or `links` has not one entry a UAV.
    pub fn observe(&mut self, policy_seed: u64, tie_period: u32, out: &mut [Observation], links: &mut [Links]) {
        let n = self.scenario().uavs;
        assert!(out.len() == n && links.len() == n, "observe: one observation and one Links for each of {n} UAVs");
        self.fill_beacons(policy_seed, tie_period);
        let half_side = (self.scenario().side_u * (TICKS_PER_U as f32 / 2.0)) as i32;
        let mut neighbours = Neighbours::new();
        for (i, (out, links)) in out.iter_mut().zip(links).enumerate() {
            self.find_neighbours(i, &mut neighbours);
            *links = links_to(&neighbours);
            let own = self.beacons[i];
            let scene = Scene { id: i as u16, own: own.state, tie: own.tie, half_side, neighbours: &neighbours };
            let in_cells = self.poi_cells.around(self.x[i], self.y[i], OBSERVATION_RANGE_U as f32);
            *out = observe(&scene, in_cells.flat_map(|run| &self.poi_ticks[run]).copied());
        }
    }

    fn fill_beacons(&mut self, policy_seed: u64, tie_period: u32) {
        let step = self.steps_done();
        for i in 0..self.beacons.len() {
            let state =
                State { position: Vec2::from_u(self.x[i], self.y[i]), velocity: Vec2::from_u(self.vx[i], self.vy[i]) };
            self.beacons[i] = Beacon { state, tie: tie_breaker(policy_seed, i as u16, step, tie_period) };
        }
    }

    fn find_neighbours(&self, i: usize, neighbours: &mut Neighbours) {
        neighbours.clear();
        let own = self.beacons[i].state.position;
        for run in self.uav_cells.around(self.x[i], self.y[i], COMMUNICATION_RANGE_U as f32) {
            for &j in &self.uav_cells.points()[run] {
                if j as usize == i {
                    continue;
                }
                let Beacon { state, tie } = self.beacons[j as usize];
                let offset = state.position - own;
                neighbours.offer(Neighbour { id: j as u16, offset, velocity: state.velocity, tie });
            }
        }
    }
}

fn links_to(neighbours: &Neighbours) -> Links {
    let mut links = Links::default();
    for (to, n) in links.to.iter_mut().zip(neighbours.as_slice()) {
        *to = n.id;
        links.count += 1;
    }
    links
}
