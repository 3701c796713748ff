//! The oracle that has to fly to its sites.

use super::targets::targets;
use crate::policy::Policy;
use crate::steering::fly_toward;
use crate::world::World;
use firmware_core::action::Action;

/// Flies each UAV straight to one of the best static sites (see [`super::cover`]) and keeps it there, as near as a
/// controller that looks one step ahead can with the action table. UAVs and sites are matched for the least summed
/// distance; UAVs without a site stay where they spawn.
#[derive(Clone, Debug, Default)]
pub struct FlyToSites {
    targets: Vec<(f32, f32)>,
}

impl FlyToSites {
    /// An oracle for any world.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Where each UAV flies in this episode, (east, north) in u; empty before the first.
    #[must_use]
    pub fn targets(&self) -> &[(f32, f32)] {
        &self.targets
    }
}

impl Policy for FlyToSites {
    fn begin(&mut self, world: &World) {
        self.targets = targets(world);
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        for (i, (action, target)) in actions.iter_mut().zip(&self.targets).enumerate() {
            let (x, y) = world.position(i);
            *action = fly_toward((target.0 - x, target.1 - y), world.velocity(i));
        }
    }
}
