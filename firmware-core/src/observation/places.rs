//! Where it would pay to go: what is free around a UAV, and which way its neighbours
//! push.

use super::{COVER, Neighbour, RANGE};
use crate::geometry::{TICKS_PER_U, Vec2, div_round};

/// Places at which free PoIs are counted: here, and along eight directions 4 u and 8 u
/// away.
pub(super) const SPOTS: usize = 17;

/// The places as offsets, ticks.
static SPOT: [(i32, i32); SPOTS] = {
    const fn ring(spots: &mut [(i32, i32); SPOTS], at: usize, reach: i32, diagonal: i32) {
        let ring = [
            (reach, 0),
            (diagonal, -diagonal),
            (0, -reach),
            (-diagonal, -diagonal),
            (-reach, 0),
            (-diagonal, diagonal),
            (0, reach),
            (diagonal, diagonal),
        ];
        let mut k = 0;
        while k < ring.len() {
            spots[at + k] = ring[k];
            k += 1;
        }
    }
    let mut spots = [(0, 0); SPOTS];
    // 4 u and 8 u, and √½ of them.
    ring(&mut spots, 1, 4 * TICKS_PER_U, 2896);
    ring(&mut spots, 9, 8 * TICKS_PER_U, 5793);
    spots
};

/// The PoIs in view that no neighbour covers.
#[derive(Default)]
pub(super) struct Free {
    /// How many.
    pub(super) count: i32,
    sum: (i32, i32),
    /// How many lie in coverage range of each place.
    pub(super) gains: [i32; SPOTS],
}

impl Free {
    /// Adds one at an offset within the view.
    pub(super) fn add(&mut self, offset: Vec2) {
        self.count += 1;
        // |Δ| < 2^14: sums of 2^16 PoIs fit.
        self.sum = (self.sum.0.wrapping_add(offset.x), self.sum.1.wrapping_add(offset.y));
        for (gain, &(x, y)) in self.gains.iter_mut().zip(&SPOT) {
            // At most (13 + 8)·1,024 ticks an axis: the sum of squares stays below 2^31.
            let (x, y) = (offset.x - x, offset.y - y);
            *gain += i32::from(x * x + y * y <= COVER * COVER);
        }
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
