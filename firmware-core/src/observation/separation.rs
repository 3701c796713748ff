//! The direction away from the neighbours.

use super::neighbours::{COMMUNICATION_RANGE, Neighbour};
use crate::geometry::{Vec2, div_round};

/// `−Σ Δ·(1 − d²/18²)`, ticks: strong from near neighbours, nothing at the edge of
/// communication range.
pub(super) fn separation(neighbours: &[Neighbour]) -> Vec2 {
    let (mut x, mut y) = (0i32, 0i32);
    for n in neighbours {
        // In whole square units, 0 to 324; 16 neighbours sum to less than 2^27.
        let d2 = n.offset.x * n.offset.x + n.offset.y * n.offset.y;
        let share = (COMMUNICATION_RANGE * COMMUNICATION_RANGE - d2) >> 20;
        x -= n.offset.x * share;
        y -= n.offset.y * share;
    }
    const SQUARE: i32 = 18 * 18;
    Vec2 { x: div_round(x, SQUARE), y: div_round(y, SQUARE) }
}
