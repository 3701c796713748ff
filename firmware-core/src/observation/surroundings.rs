//! What is free around a UAV, and which way its neighbours push.

use super::{Neighbour, RANGE};
use crate::geometry::{Vec2, div_round};

/// The PoIs in view that no neighbour covers.
#[derive(Default)]
pub(super) struct Free {
    /// How many.
    pub(super) count: i32,
    sum: (i32, i32),
}

impl Free {
    /// Adds one at an offset within the view.
    pub(super) fn add(&mut self, offset: Vec2) {
        self.count += 1;
        // |Δ| < 2^14: sums of 2^16 PoIs fit.
        self.sum = (self.sum.0.wrapping_add(offset.x), self.sum.1.wrapping_add(offset.y));
    }

    /// Their mean offset, ticks; zero when there are none.
    pub(super) fn mean(&self) -> Vec2 {
        let n = self.count.max(1);
        Vec2 { x: div_round(self.sum.0, n), y: div_round(self.sum.1, n) }
    }
}

/// `−Σ Δ·(1 − d²/18²)`, ticks: strong from near neighbours, nothing at the edge.
pub(super) fn push(neighbours: &[Neighbour]) -> Vec2 {
    let (mut x, mut y) = (0i32, 0i32);
    for n in neighbours {
        // In whole square units, 0 to 324; 16 neighbours sum to less than 2^27.
        let d2 = n.offset.x * n.offset.x + n.offset.y * n.offset.y;
        let share = (RANGE * RANGE - d2) >> 20;
        x -= n.offset.x * share;
        y -= n.offset.y * share;
    }
    const SQUARE: i32 = 18 * 18;
    Vec2 { x: div_round(x, SQUARE), y: div_round(y, SQUARE) }
}
