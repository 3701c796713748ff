//! From an action to velocity and acceleration setpoints.

use crate::mission::Scale;
use firmware_core::action::Action;
use firmware_core::gate::Vector;
use firmware_core::geometry::{SPEED_CAP_U, Vec2};

/// Which acceleration a setpoint feeds forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedForward {
    /// The acceleration of the velocity ramp, and zero once the velocity is reached: what an autopilot
    /// tracks best.
    #[default]
    Ramp,
    /// The action's own acceleration, all the time: a simulator with the scenario's own dynamics
    /// recovers the action from it.
    Action,
}

/// The velocity profile of a decision: a ramp from the velocity measured when it was made to the
/// action's next velocity, with the greatest acceleration of the scenario, then that velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityProfile {
    /// `time_boot_ms` when the decision was made.
    pub decided_ms: u32,
    /// The action that was decided.
    pub action: Action,
    from_mps: [f64; 2],
    to_mps: [f64; 2],
    ramp_s: f64,
    action_mps2: [f64; 2],
}

impl VelocityProfile {
    /// The profile of `action`. `observed` is the velocity in the observation, ticks/step;
    /// `measured_mps` is the velocity east and north when the decision was made, m/s.
    #[must_use]
    pub fn new(action: Action, decided_ms: u32, observed: Vec2, measured_mps: [f64; 2], scale: Scale) -> Self {
        let next = action.next_velocity(observed.to_u());
        let to_mps = [next.0, next.1].map(|v| scale.mps(v));
        let (ax, ay) = action.acceleration();
        let change = (to_mps[0] - measured_mps[0]).hypot(to_mps[1] - measured_mps[1]);
        Self {
            decided_ms,
            action,
            from_mps: measured_mps,
            to_mps,
            ramp_s: change / scale.mps2(SPEED_CAP_U as f32),
            action_mps2: [ax, ay].map(|a| scale.mps2(a)),
        }
    }

    /// Velocity east and north when the decision was made, m/s.
    #[must_use]
    pub const fn measured_mps(&self) -> [f64; 2] {
        self.from_mps
    }

    /// Velocity (mm/s) and acceleration (mm/s²) at a `time_boot_ms`.
    #[must_use]
    pub fn at(&self, boot_ms: u32, feed_forward: FeedForward) -> (Vector, Vector) {
        let passed_s = f64::from(boot_ms.wrapping_sub(self.decided_ms) as i32) / 1000.0;
        let ramping = passed_s < self.ramp_s;
        let done = if ramping { (passed_s / self.ramp_s).max(0.0) } else { 1.0 };
        let velocity = |axis: usize| self.from_mps[axis] + (self.to_mps[axis] - self.from_mps[axis]) * done;
        let acceleration = |axis: usize| match feed_forward {
            FeedForward::Action => self.action_mps2[axis],
            FeedForward::Ramp if ramping => (self.to_mps[axis] - self.from_mps[axis]) / self.ramp_s,
            FeedForward::Ramp => 0.0,
        };
        let vector = |v: [f64; 2]| Vector::new(thousandths(v[0]), thousandths(v[1]));
        (vector([0, 1].map(velocity)), vector([0, 1].map(acceleration)))
    }
}

/// Metres to millimetres, rounded to the nearest; likewise m/s to mm/s and m/s² to mm/s².
pub(super) fn thousandths(si: f64) -> i32 {
    (si * 1000.0).round() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCALE: Scale = Scale { unit_m: 2.5, step_ms: 2000 };

    fn action(index: u8) -> Action {
        Action::new(index).unwrap()
    }

    #[test]
    fn a_full_acceleration_takes_a_step() {
        // 4 u/step² east from rest: 5 m/s after 2 s at 2.5 m/s².
        let profile = VelocityProfile::new(action(0), u32::MAX - 499, Vec2::default(), [0.0, 0.0], SCALE);
        let at = |ms: u32| profile.at((u32::MAX - 499).wrapping_add(ms), FeedForward::Ramp);
        assert_eq!(at(0), (Vector::new(0, 0), Vector::new(2500, 0)));
        assert_eq!(at(1000), (Vector::new(2500, 0), Vector::new(2500, 0)));
        assert_eq!(at(2000), (Vector::new(5000, 0), Vector::new(0, 0)));
        assert_eq!(at(9000), (Vector::new(5000, 0), Vector::new(0, 0)));
    }

    #[test]
    fn the_cap_shortens_the_ramp_but_not_the_action() {
        let east = Vec2::from_u(4.0, 0.0);
        let profile = VelocityProfile::new(action(0), 0, east, [5.0, 0.0], SCALE);
        assert_eq!(profile.at(200, FeedForward::Ramp), (Vector::new(5000, 0), Vector::new(0, 0)));
        assert_eq!(profile.at(200, FeedForward::Action), (Vector::new(5000, 0), Vector::new(2500, 0)));
    }

    #[test]
    fn coasting_keeps_the_velocity_that_was_observed() {
        let profile = VelocityProfile::new(Action::COAST, 0, Vec2::from_u(2.0, -1.0), [2.0, -1.0], SCALE);
        assert_eq!(profile.at(2000, FeedForward::Ramp).0, Vector::new(2500, -1250));
    }
}
