//! Forms of the observation: what an actor can be trained on and fly with.

use super::scene::Scene;
use crate::geometry::Vec2;
use core::fmt::Debug;

/// A form of the observation. The compact one is [`Observation`](super::Observation), the
/// paper's own is [`Cells`](super::cells::Cells).
pub trait BuildObservation: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Identifies the form in actor files.
    const ID: u16;
    /// Numbers that a network takes.
    const LEN: usize;
    /// One in which every number is zero.
    const ZERO: Self;

    /// Builds the observation of a scene with the `PoIs` at these positions (ticks); those out
    /// of view are left out, and their order does not matter.
    fn build(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Self;
}
