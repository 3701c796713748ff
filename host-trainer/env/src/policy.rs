//! The interface of a policy.

use crate::world::World;
use firmware_core::action::Action;

/// Chooses the actions of all UAVs of one world, episode after episode. Each world gets a policy of its own, so that
/// worlds can run side by side on several threads.
pub trait Policy {
    /// Called when a new episode begins in `world`, which is in its spawn state.
    fn begin(&mut self, world: &World) {
        let _ = world;
    }

    /// Writes the action of every UAV for the present state of `world`. `actions` has one entry for each UAV: before
    /// the first step of an episode [`Action::COAST`], afterwards the action of the step before.
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
