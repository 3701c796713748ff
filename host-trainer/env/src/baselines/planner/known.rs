//! What a planner knows of PoIs and of other UAVs.

use crate::plane::widened;
use crate::world::World;

/// A cell counts as seen when its centre is within this distance of a UAV, u.
pub(super) const SEEN_U: f64 = 12.5;

/// A PoI that the UAV knows.
#[derive(Clone, Copy, Debug)]
pub(super) struct KnownPoi {
    /// Position, u.
    pub at: (f64, f64),
    /// Index in the world; `None` where it is known from a memory alone.
    pub index: Option<usize>,
    /// Value of covering it for a step, at most 1.
    pub weight: f64,
}

/// Another UAV's claim on the PoIs around its target.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim {
    /// The other UAV.
    pub id: usize,
    /// Steps until it arrives at its target.
    pub flight: f64,
    /// Where it flies, u.
    pub target: (f64, f64),
    /// Steps since it said so.
    pub age: f64,
    /// Whether the other UAV has the lower priority.
    pub yields: bool,
}

/// Position of PoI `p` of a world, u.
pub(super) fn poi_position(world: &World, p: usize) -> (f64, f64) {
    widened((world.poi_x()[p], world.poi_y()[p]))
}
