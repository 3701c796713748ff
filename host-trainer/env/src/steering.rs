//! From a place to an action.

use crate::plane::{distance, squared};
use firmware_core::action::Action;
use firmware_core::geometry::SPEED_CAP_U;

/// The action whose next velocity is nearest to the one that flies straight along
/// `offset` (u) and arrives in one step, or at 4 u/step when that is too far. Equal
/// ones: the first.
pub(crate) fn toward(offset: (f32, f32), velocity: (f32, f32)) -> Action {
    let cap = SPEED_CAP_U as f32;
    let length = distance(offset, (0.0, 0.0));
    let k = if length > cap { cap / length } else { 1.0 };
    nearest((offset.0 * k, offset.1 * k), velocity)
}

/// The action whose next velocity is nearest to `wanted`.
pub(crate) fn nearest(wanted: (f32, f32), velocity: (f32, f32)) -> Action {
    let mut best = (Action::COAST, f32::INFINITY);
    for action in Action::all() {
        let miss = squared(action.next_velocity(velocity), wanted);
        if miss < best.1 {
            best = (action, miss);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flies_straight_and_stops_on_the_spot() {
        assert_eq!(toward((30.0, 0.0), (0.0, 0.0)).index(), 0);
        assert_eq!(toward((0.0, 30.0), (0.0, 0.0)).index(), 6);
        assert_eq!(toward((30.0, 0.0), (4.0, 0.0)).next_velocity((4.0, 0.0)), (4.0, 0.0));
        // Full brake.
        assert_eq!(toward((0.0, 0.0), (4.0, 0.0)).index(), 4);
        assert_eq!(toward((0.0, 0.0), (0.0, 0.0)), Action::COAST);
    }
}
