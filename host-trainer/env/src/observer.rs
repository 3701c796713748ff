//! What each UAV sees: the board's own observation.

use crate::world::World;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, OBSERVATION_RANGE_U, State, Vec2};
use firmware_core::observation::{BuildObservation, MAX_NEIGHBOURS, Neighbour, Neighbours, Scene};
use firmware_core::random::tie_breaker;

/// The neighbours that a UAV keeps: those its graph layer aggregates over, besides
/// itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Neighbourhood {
    /// How many.
    pub count: u8,
    /// Their ids, nearest first; zeros beyond `count`.
    pub to: [u16; MAX_NEIGHBOURS],
}

impl Neighbourhood {
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

/// Builds the observations of a world, with the tie-breakers of one policy seed.
#[derive(Clone, Debug)]
pub struct Observer {
    policy_seed: u64,
    tie_period: u32,
    /// Of the present state, one a UAV.
    beacons: Vec<Beacon>,
}

impl Observer {
    /// Tie-breakers are drawn from `policy_seed` anew every `tie_period` steps (0
    /// counts as 1), as on board.
    #[must_use]
    pub fn new(policy_seed: u64, tie_period: u32) -> Self {
        Self { policy_seed, tie_period, beacons: Vec::new() }
    }

    /// Writes the observation and the kept neighbours of every UAV in the present
    /// state. Positions are rounded to ticks first, as on board; ids are the UAVs'
    /// indices and the step is [`World::steps_done`].
    ///
    /// # Panics
    /// When `out` or `links` has not one entry a UAV.
    pub fn observe<O: BuildObservation>(&mut self, world: &World, out: &mut [O], links: &mut [Neighbourhood]) {
        let uavs = world.scenario().uavs;
        assert!(
            out.len() == uavs && links.len() == uavs,
            "observe: one observation and one Neighbourhood for each UAV"
        );
        self.fill_beacons(world);
        let half_side = world.scenario().half_side_ticks();
        let mut neighbours = Neighbours::new();
        for (i, (out, links)) in out.iter_mut().zip(links).enumerate() {
            self.find_neighbours(world, i, &mut neighbours);
            *links = links_to(&neighbours);
            let own = self.beacons[i];
            let scene = Scene { id: i as u16, own: own.state, tie: own.tie, half_side, neighbours: &neighbours };
            let in_cells = world.poi_cells.around(world.x[i], world.y[i], OBSERVATION_RANGE_U as f32);
            *out = O::build(&scene, in_cells.flat_map(|run| &world.poi_ticks[run]).copied());
        }
    }

    fn fill_beacons(&mut self, world: &World) {
        let step = world.steps_done();
        self.beacons.clear();
        self.beacons.extend((0..world.x.len()).map(|i| Beacon {
            state: State {
                position: Vec2::from_u(world.x[i], world.y[i]),
                velocity: Vec2::from_u(world.vx[i], world.vy[i]),
            },
            tie: tie_breaker(self.policy_seed, i as u16, step, self.tie_period),
        }));
    }

    fn find_neighbours(&self, world: &World, i: usize, neighbours: &mut Neighbours) {
        neighbours.clear();
        let own = self.beacons[i].state.position;
        for run in world.uav_cells.around(world.x[i], world.y[i], COMMUNICATION_RANGE_U as f32) {
            for &j in &world.uav_cells.points()[run] {
                if j as usize == i {
                    continue;
                }
                let Beacon { state, tie } = self.beacons[j as usize];
                let offset = state.position - own;
                neighbours.insert(Neighbour { id: j as u16, offset, velocity: state.velocity, tie });
            }
        }
    }
}

fn links_to(neighbours: &Neighbours) -> Neighbourhood {
    let mut links = Neighbourhood::default();
    for (to, n) in links.to.iter_mut().zip(neighbours.as_slice()) {
        *to = n.id;
        links.count += 1;
    }
    links
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use firmware_core::observation::{Observation, observe};
    use proptest::prelude::*;

    /// Everything about every UAV and PoI, without cells.
    fn naive(world: &World, policy_seed: u64, tie_period: u32) -> Vec<(Observation, Neighbourhood)> {
        let n = world.scenario().uavs;
        let ticks = |i| Vec2::from_u(world.x()[i], world.y()[i]);
        let velocity = |i| Vec2::from_u(world.vx()[i], world.vy()[i]);
        let tie = |i| tie_breaker(policy_seed, i as u16, world.steps_done(), tie_period);
        let pois = || world.poi_x().iter().zip(world.poi_y()).map(|(&x, &y)| Vec2::from_u(x, y));
        let view = |i: usize| {
            let mut neighbours = Neighbours::new();
            for j in (0..n).filter(|&j| j != i) {
                let offset = ticks(j) - ticks(i);
                neighbours.insert(Neighbour { id: j as u16, offset, velocity: velocity(j), tie: tie(j) });
            }
            let own = State { position: ticks(i), velocity: velocity(i) };
            let half_side = world.scenario().half_side_ticks();
            let scene = Scene { id: i as u16, own, tie: tie(i), half_side, neighbours: &neighbours };
            (observe(&scene, pois()), links_to(&neighbours))
        };
        (0..n).map(view).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn cells_show_each_uav_all_that_is_in_range(
            uavs in 1usize..60,
            pois in 1usize..200,
            side_u in 20.0f32..300.0,
            index in 0u64..1000,
            policy_seed: u64,
            tie_period in 0u32..5,
        ) {
            use firmware_core::action::Action;
            let scenario = Scenario { uavs, pois, side_u, ..Scenario::default() };
            let mut world = World::new(&scenario).unwrap();
            world.reset(7, index);
            for step in 0..3 {
                let mut out = vec![[0; firmware_core::observation::LEN]; uavs];
                let mut links = vec![Neighbourhood::default(); uavs];
                Observer::new(policy_seed, tie_period).observe(&world, &mut out, &mut links);
                let got: Vec<_> = out.into_iter().zip(links).collect();
                prop_assert_eq!(got, naive(&world, policy_seed, tie_period));
                let actions: Vec<_> = (0..uavs).map(|i| Action::new(((i * 5 + step) % 17) as u8).unwrap()).collect();
                world.step(&actions);
            }
        }
    }
}
