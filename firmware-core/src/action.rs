//! The 17 actions and what they do to a velocity.

use crate::geometry::SPEED_CAP_U;

/// Number of actions.
pub const ACTIONS: usize = 17;

/// √½.
const S: f32 = core::f32::consts::FRAC_1_SQRT_2;

/// Unit directions of actions 0–7 (and 8–15).
const DIRECTIONS: [(f32, f32); 8] =
    [(1.0, 0.0), (S, -S), (0.0, -1.0), (-S, -S), (-1.0, 0.0), (-S, S), (0.0, 1.0), (S, S)];

/// One of the 17 actions: 0–7 accelerate 4 u/step² along a direction, 8–15 do so
/// with 2 u/step², 16 coasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Action(u8);

impl Action {
    /// No acceleration: the UAV keeps its velocity (there is no drag).
    pub const COAST: Self = Self((ACTIONS - 1) as u8);

    /// The action of this index, if there is one.
    #[must_use]
    pub const fn new(index: u8) -> Option<Self> {
        if (index as usize) < ACTIONS { Some(Self(index)) } else { None }
    }

    /// Every action in order.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..ACTIONS as u8).map(Self)
    }

    /// Index, 0 to 16.
    #[must_use]
    pub const fn index(self) -> u8 {
        self.0
    }

    /// Acceleration (east, north), u/step².
    #[must_use]
    pub fn acceleration(self) -> (f32, f32) {
        let k = self.0 as usize;
        match DIRECTIONS.get(k % 8) {
            Some(&(x, y)) if k < 8 => (4.0 * x, 4.0 * y),
            Some(&(x, y)) if k < 16 => (2.0 * x, 2.0 * y),
            _ => (0.0, 0.0),
        }
    }

    /// Velocity after one step of this action, u/step: `v + a`, shortened to
    /// 4 u/step when it is faster.
    #[must_use]
    pub fn next_velocity(self, velocity: (f32, f32)) -> (f32, f32) {
        let (ax, ay) = self.acceleration();
        let (x, y) = (velocity.0 + ax, velocity.1 + ay);
        let cap = SPEED_CAP_U as f32;
        let speed = libm::sqrtf(x * x + y * y);
        if speed > cap { (x * (cap / speed), y * (cap / speed)) } else { (x, y) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_beyond_the_table_are_no_action() {
        assert_eq!(Action::new(16), Some(Action::COAST));
        assert_eq!(Action::new(17), None);
        assert_eq!(Action::all().count(), ACTIONS);
    }

    #[test]
    fn opposite_directions_cancel() {
        for k in (0..4u8).chain(8..12) {
            let (a, b) = (Action(k).acceleration(), Action(k + 4).acceleration());
            assert_eq!((a.0 + b.0, a.1 + b.1), (0.0, 0.0));
        }
    }

    #[test]
    fn speed_is_capped_and_coasting_keeps_velocity() {
        assert_eq!(Action::COAST.next_velocity((1.5, -2.0)), (1.5, -2.0));
        let (x, y) = Action(7).next_velocity((4.0, 0.0));
        assert!((x * x + y * y - 16.0).abs() < 1e-4, "{x} {y}");
    }
}
