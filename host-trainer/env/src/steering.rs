//! One-step velocity control: the action whose next velocity is nearest to a wanted one.

use crate::plane::{distance, squared_distance};
use firmware_core::action::Action;
use firmware_core::geometry::SPEED_CAP_U;

/// The action whose next velocity is nearest to flying straight along `offset` (u), arriving in one step, or at
/// 4 u/step when that is too far; of equally near actions the first. `velocity` is the present one, u/step.
pub(crate) fn fly_toward(offset: (f32, f32), velocity: (f32, f32)) -> Action {
    let cap = SPEED_CAP_U as f32;
    let length = distance(offset, (0.0, 0.0));
    let k = if length > cap { cap / length } else { 1.0 };
    nearest_action((offset.0 * k, offset.1 * k), velocity)
}

/// The action that makes of `velocity` (u/step) the velocity nearest to `wanted`; of equally near actions the first.
pub(crate) fn nearest_action(wanted: (f32, f32), velocity: (f32, f32)) -> Action {
    let mut best = (Action::COAST, f32::INFINITY);
    for action in Action::all() {
        let error = squared_distance(action.next_velocity(velocity), wanted);
        if error < best.1 {
            best = (action, error);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flies_straight_and_stops_on_the_spot() {
        assert_eq!(fly_toward((30.0, 0.0), (0.0, 0.0)).index(), 0);
        assert_eq!(fly_toward((0.0, 30.0), (0.0, 0.0)).index(), 6);
        assert_eq!(fly_toward((30.0, 0.0), (4.0, 0.0)).next_velocity((4.0, 0.0)), (4.0, 0.0));
        // Full brake.
        assert_eq!(fly_toward((0.0, 0.0), (4.0, 0.0)).index(), 4);
        assert_eq!(fly_toward((0.0, 0.0), (0.0, 0.0)), Action::COAST);
    }
}
