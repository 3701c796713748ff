//! Points of a memory's grid, and how few bits a message needs for them.

use crate::geometry::{TICKS_PER_U, Vec2};
use crate::observation::HALF_SIDE_LIMIT;

/// Side of a grid square, ticks: half a map unit.
pub const GRID: i32 = TICKS_PER_U / 2;
/// Bits of a coordinate of a PoI in a message.
pub(super) const POI_BITS: u32 = 9;
/// Bits of a coordinate of a target in a message, in whole units.
pub(super) const TARGET_BITS: u32 = 8;

/// A square of the grid, counted from the map's south-west corner. Two PoIs in one are one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GridPoint {
    /// Squares to the east.
    pub x: u16,
    /// Squares to the north.
    pub y: u16,
}

impl GridPoint {
    /// The square of a position (ticks); the nearest one for positions outside of the map.
    #[must_use]
    pub fn of(position: Vec2) -> Self {
        const MOST: i32 = 2 * HALF_SIDE_LIMIT / GRID - 1;
        let axis = |t: i32| (t >> GRID.ilog2()).clamp(0, MOST) as u16;
        Self { x: axis(position.x), y: axis(position.y) }
    }

    /// The middle of the square, ticks.
    #[must_use]
    pub const fn middle(self) -> Vec2 {
        Vec2 { x: self.x as i32 * GRID + GRID / 2, y: self.y as i32 * GRID + GRID / 2 }
    }

    /// Squared distance of its middle from a position, ticks².
    pub(super) fn distance2(self, from: Vec2) -> u64 {
        let offset = self.middle() - from;
        let square = |v: i32| u64::from(v.unsigned_abs()).pow(2);
        square(offset.x) + square(offset.y)
    }

    /// Whether it lies on a map of `side` squares along each side.
    pub(super) fn is_on_map(self, side: u32) -> bool {
        u32::from(self.x) < side && u32::from(self.y) < side
    }
}

/// What a coordinate of a message means: the value congruent to `bits` in the window of
/// 2^`BITS` that lies around the sender, moved so far that it does not leave the map.
/// `sender` and `side` are in the same unit.
pub(super) fn in_window<const BITS: u32>(bits: u32, sender: u16, side: u32) -> u16 {
    let first = window_start::<BITS>(sender, side);
    let beyond = bits.wrapping_sub(first) & ((1 << BITS) - 1);
    // Sides are at most 2¹⁵ grid squares, windows 2⁹.
    (first + beyond).min(u32::from(u16::MAX)) as u16
}

/// Whether a coordinate can be told by a sender: it lies in that window.
pub(super) fn is_in_window<const BITS: u32>(value: u16, sender: u16, side: u32) -> bool {
    let first = window_start::<BITS>(sender, side);
    (first..first + (1 << BITS)).contains(&u32::from(value))
}

fn window_start<const BITS: u32>(sender: u16, side: u32) -> u32 {
    let width = 1 << BITS;
    u32::from(sender).saturating_sub(width / 2).min(side.saturating_sub(width))
}
