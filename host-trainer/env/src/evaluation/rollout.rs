//! One episode from its spawn state to its end.

use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;

/// Flies `policy` from the spawn state of `world` to the end of the episode; `on_state` is called with every state, the
/// spawn state first.
pub(crate) fn rollout<P: Policy + ?Sized>(world: &mut World, policy: &mut P, mut on_state: impl FnMut(&World)) {
    let mut actions = vec![Action::COAST; world.scenario().uavs];
    policy.begin(world);
    on_state(world);
    while !world.done() {
        policy.act(world, &mut actions);
        world.step(&actions);
        on_state(world);
    }
}
