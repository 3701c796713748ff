//! What an observation is made of.

use super::neighbours::{Neighbour, Neighbours};
use crate::geometry::State;

/// Greatest half side of a map, ticks (8,192 u); larger ones are taken as this.
pub const HALF_SIDE_LIMIT: i32 = 1 << 23;

/// What an observation is made of, but for the PoIs.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Own id: breaks equal tie-breakers.
    pub id: u16,
    /// Own measured state.
    pub own: State,
    /// Own tie-breaker of the step (see [`crate::random::tie_breaker`]).
    pub tie: i8,
    /// Half the side of the map, ticks, 1 to [`HALF_SIDE_LIMIT`]; the map's south-west corner
    /// is the origin.
    pub half_side: i32,
    /// Neighbours in range.
    pub neighbours: &'a Neighbours,
}

impl Scene<'_> {
    /// Whether this UAV has priority over a neighbour: by the higher tie-breaker, and by the
    /// higher id where those are equal. The one without priority yields.
    pub(super) fn has_priority_over(&self, n: &Neighbour) -> bool {
        (self.tie, self.id) > (n.tie, n.id)
    }
}
