//! Forms of the observation: what an actor can be trained on and fly with.

use super::{ID, LEN, Observation, Scene, observe};
use crate::geometry::Vec2;
use core::fmt::Debug;

/// A form of the observation. The compact one is [`Observation`], the one that looks at cells
/// is [`Cells`](super::cells::Cells).
pub trait Form: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Identifies the form in actor files.
    const ID: u16;
    /// Numbers that a network takes.
    const LEN: usize;
    /// One in which every number is zero.
    const BLANK: Self;

    /// Builds the observation of a scene with the `PoIs` at these positions (ticks); those out
    /// of view are left out, and their order does not matter.
    fn of(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Self;
}

impl Form for Observation {
    const ID: u16 = ID;
    const LEN: usize = LEN;
    const BLANK: Self = [0; LEN];

    fn of(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Self {
        observe(scene, pois)
    }
}
