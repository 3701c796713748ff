//! Saving and restoring a world in the middle of an episode.

use super::metrics::Totals;
use super::placement::PlacementError;
use super::state::World;
use serde::{Deserialize, Serialize};

/// The saved state of a [`World`]: with the scenario, all that it needs to go on exactly as if it had never stopped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    steps_done: u32,
    totals: Totals,
    uavs: Vec<Uav>,
    pois: Vec<Poi>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Uav {
    position: (f32, f32),
    velocity: (f32, f32),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Poi {
    position: (f32, f32),
    steps_covered: u32,
}

impl World {
    /// Saves the present state.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let uav = |i| Uav { position: self.position(i), velocity: self.velocity(i) };
        let poi =
            |p: usize| Poi { position: (self.poi_x[p], self.poi_y[p]), steps_covered: self.score.steps_covered[p] };
        Snapshot {
            steps_done: self.steps_done,
            totals: self.totals.clone(),
            uavs: (0..self.scenario.uavs).map(uav).collect(),
            pois: (0..self.scenario.pois).map(poi).collect(),
        }
    }

    /// Restores a state that a world of the same scenario saved.
    ///
    /// # Errors
    /// [`PlacementError`] when the snapshot is of another number of UAVs or PoIs, puts one outside the map or has a
    /// velocity that is not finite; the world is then unchanged.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), PlacementError> {
        for (index, &Uav { velocity: (vx, vy), .. }) in snapshot.uavs.iter().enumerate() {
            if !(vx.is_finite() && vy.is_finite()) {
                return Err(PlacementError::Velocity { index, vx, vy });
            }
        }
        let uavs: Vec<_> = snapshot.uavs.iter().map(|u| u.position).collect();
        let pois: Vec<_> = snapshot.pois.iter().map(|p| p.position).collect();
        self.set_positions(&uavs, &pois)?;
        for (i, uav) in snapshot.uavs.iter().enumerate() {
            (self.vx[i], self.vy[i]) = uav.velocity;
        }
        self.refresh();
        for (steps, poi) in self.score.steps_covered.iter_mut().zip(&snapshot.pois) {
            *steps = poi.steps_covered;
        }
        self.steps_done = snapshot.steps_done;
        self.totals = snapshot.totals.clone();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use firmware_core::action::Action;

    #[test]
    fn a_restored_world_goes_on_as_if_it_had_never_stopped() {
        let scenario = Scenario { steps: 40, ..Scenario::default() };
        let mut world = World::new(&scenario).unwrap();
        world.reset(1, 2);
        let act = |world: &mut World, t: usize| {
            let actions: Vec<_> = (0..20).map(|i| Action::new(((7 * i + t * t) % 17) as u8).unwrap()).collect();
            world.step(&actions);
        };
        (0..15).for_each(|t| act(&mut world, t));
        let snapshot = world.snapshot();
        let mut other = World::new(&scenario).unwrap();
        (0..40).for_each(|_| other.step(&[Action::COAST; 20]));
        other.restore(&snapshot).unwrap();
        assert_eq!(other.snapshot(), snapshot);
        assert_eq!(other.rewards(), world.rewards());
        for t in 15..40 {
            act(&mut world, t);
            act(&mut other, t);
            assert_eq!(other.rewards(), world.rewards());
        }
        assert_eq!(other.snapshot(), world.snapshot());
        assert_eq!(other.metrics(), world.metrics());
        assert!(other.done());
    }

    #[test]
    fn a_snapshot_of_another_scenario_is_refused() {
        let world = |uavs| World::new(&Scenario { uavs, ..Scenario::default() }).unwrap();
        let error = world(5).restore(&world(6).snapshot()).unwrap_err();
        assert_eq!(error, PlacementError::Uavs { got: 6, want: 5 });
    }
}
