//! The neighbours in communication range, as a UAV sees them.

use super::nearest::insert_sorted;
use crate::geometry::{COMMUNICATION_RANGE_U, TICKS_PER_U, Vec2};
use heapless::Vec;

/// Neighbours a UAV keeps (the nearest), and aggregates over.
pub const MAX_NEIGHBOURS: usize = 16;

/// [`COMMUNICATION_RANGE_U`] in ticks.
pub(crate) const COMMUNICATION_RANGE: i32 = COMMUNICATION_RANGE_U * TICKS_PER_U;

/// A neighbour as seen from a UAV.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Neighbour {
    /// Its id.
    pub id: u16,
    /// Where it is, relative to the observer, ticks.
    pub offset: Vec2,
    /// Its velocity, ticks per step.
    pub velocity: Vec2,
    /// Its tie-breaker of the step.
    pub tie: i8,
}

impl Neighbour {
    /// Nearest first; equal distances by id. This order decides who is kept when
    /// there are more than [`MAX_NEIGHBOURS`].
    pub(super) fn key(&self) -> (u32, u16) {
        // Only called for neighbours in range, where `within` is `Some`.
        (self.offset.within(COMMUNICATION_RANGE).unwrap_or(u32::MAX), self.id)
    }
}

/// Up to [`MAX_NEIGHBOURS`] neighbours, the nearest, nearest first.
#[derive(Clone, Debug, Default)]
pub struct Neighbours(Vec<Neighbour, MAX_NEIGHBOURS>);

impl Neighbours {
    /// No neighbours.
    #[must_use]
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Forgets them all.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Takes a neighbour in, if it is in communication range and among the nearest.
    pub fn insert(&mut self, n: Neighbour) {
        if n.offset.within(COMMUNICATION_RANGE).is_none() {
            return;
        }
        let before = |a: &Neighbour, b: &Neighbour| a.key() < b.key();
        insert_sorted(&mut self.0, n, before);
    }

    /// The neighbours, nearest first.
    #[must_use]
    pub fn as_slice(&self) -> &[Neighbour] {
        &self.0
    }
}
