//! Observations of a world whose UAVs know of each other without loss or delay.

use super::neighbourhood::{Neighbourhood, assert_one_each};
use crate::world::World;
use firmware_core::geometry::{State, Vec2};
use firmware_core::observation::{BuildObservation, Neighbour, Neighbours, Scene};
use firmware_core::random::tie_breaker;

/// What a UAV's beacon tells the others in a step.
#[derive(Clone, Copy, Debug, Default)]
struct BeaconContent {
    state: State,
    tie: i8,
}

/// Builds the observations of a world with the code that runs on board, as if every message arrived at once and
/// without loss. [`crate::radio::RadioObserver`] does the same over a lossy radio.
#[derive(Clone, Debug)]
pub struct Observer {
    policy_seed: u64,
    tie_period: u32,
    /// Of the present state, one for each UAV.
    beacons: Vec<BeaconContent>,
}

impl Observer {
    /// An observer whose tie-breakers (random numbers in the observation that let UAVs in equal positions act
    /// differently) are drawn from `policy_seed` anew every `tie_period` steps (0 counts as 1), as on board.
    #[must_use]
    pub fn new(policy_seed: u64, tie_period: u32) -> Self {
        Self { policy_seed, tie_period, beacons: Vec::new() }
    }

    /// Writes the observation and the neighbourhood of every UAV in the present state. Positions are rounded to ticks
    /// (1/1024 u) first, as on board; ids are the UAVs' indices and the step is [`World::steps_done`].
    ///
    /// # Panics
    /// When `observations` or `neighbourhoods` has not one entry for each UAV.
    pub fn observe<O: BuildObservation>(
        &mut self,
        world: &World,
        observations: &mut [O],
        neighbourhoods: &mut [Neighbourhood],
    ) {
        let uavs = world.scenario().uavs;
        assert_one_each(observations, neighbourhoods, uavs);
        self.fill_beacons(world);
        let half_side = world.scenario().half_side_ticks();
        let mut neighbours = Neighbours::new();
        for (i, (observation, neighbourhood)) in observations.iter_mut().zip(neighbourhoods).enumerate() {
            self.find_neighbours(world, i, &mut neighbours);
            *neighbourhood = neighbours.as_slice().iter().map(|n| n.id).collect();
            let own = self.beacons[i];
            let scene = Scene { id: i as u16, own: own.state, tie: own.tie, half_side, neighbours: &neighbours };
            *observation = O::build(&scene, world.poi_ticks_near(i));
        }
    }

    fn fill_beacons(&mut self, world: &World) {
        let step = world.steps_done();
        self.beacons.clear();
        self.beacons.extend((0..world.scenario().uavs).map(|i| BeaconContent {
            state: State {
                position: Vec2::from_u(world.x()[i], world.y()[i]),
                velocity: Vec2::from_u(world.vx()[i], world.vy()[i]),
            },
            tie: tie_breaker(self.policy_seed, i as u16, step, self.tie_period),
        }));
    }

    fn find_neighbours(&self, world: &World, i: usize, neighbours: &mut Neighbours) {
        neighbours.clear();
        let own = self.beacons[i].state.position;
        for j in world.uavs_near(i).filter(|&j| j != i) {
            let BeaconContent { state, tie } = self.beacons[j];
            let offset = state.position - own;
            neighbours.insert(Neighbour { id: j as u16, offset, velocity: state.velocity, tie });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use firmware_core::observation::{Observation, observe};
    use proptest::prelude::*;

    /// The same by going through all UAVs and PoIs, without a grid.
    fn brute_force(world: &World, policy_seed: u64, tie_period: u32) -> Vec<(Observation, Neighbourhood)> {
        let n = world.scenario().uavs;
        let ticks = |i| Vec2::from_u(world.x()[i], world.y()[i]);
        let velocity = |i| Vec2::from_u(world.vx()[i], world.vy()[i]);
        let tie = |i| tie_breaker(policy_seed, i as u16, world.steps_done(), tie_period);
        let pois = || world.poi_x().iter().zip(world.poi_y()).map(|(&x, &y)| Vec2::from_u(x, y));
        let of_uav = |i: usize| {
            let mut neighbours = Neighbours::new();
            for j in (0..n).filter(|&j| j != i) {
                let offset = ticks(j) - ticks(i);
                neighbours.insert(Neighbour { id: j as u16, offset, velocity: velocity(j), tie: tie(j) });
            }
            let own = State { position: ticks(i), velocity: velocity(i) };
            let half_side = world.scenario().half_side_ticks();
            let scene = Scene { id: i as u16, own, tie: tie(i), half_side, neighbours: &neighbours };
            (observe(&scene, pois()), neighbours.as_slice().iter().map(|n| n.id).collect())
        };
        (0..n).map(of_uav).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn the_grid_leaves_out_nothing_in_range(
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
                let mut observations = vec![[0; firmware_core::observation::LEN]; uavs];
                let mut neighbourhoods = vec![Neighbourhood::default(); uavs];
                Observer::new(policy_seed, tie_period).observe(&world, &mut observations, &mut neighbourhoods);
                let got: Vec<_> = observations.into_iter().zip(neighbourhoods).collect();
                prop_assert_eq!(got, brute_force(&world, policy_seed, tie_period));
                let actions: Vec<_> = (0..uavs).map(|i| Action::new(((i * 5 + step) % 17) as u8).unwrap()).collect();
                world.step(&actions);
            }
        }
    }
}
