//! What flies the UAVs of a world.

use crate::world::World;
use firmware_core::action::Action;

/// Chooses the actions of one world, episode after episode. Each world gets a policy
/// of its own, so that worlds run side by side and none disturbs another.
pub trait Policy {
    /// A new episode begins in `world`, which stands at its spawn state.
    fn begin(&mut self, world: &World) {
        let _ = world;
    }

    /// Writes the action of every UAV for the present state of `world`. `actions` has
    /// one entry a UAV; each holds [`Action::COAST`] in the first step and the last
    /// choice afterwards.
    fn act(&mut self, world: &World, actions: &mut [Action]);
}

impl<P: Policy + ?Sized> Policy for Box<P> {
    fn begin(&mut self, world: &World) {
        (**self).begin(world);
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        (**self).act(world, actions);
    }
}
