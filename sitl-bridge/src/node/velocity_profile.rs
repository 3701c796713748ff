//! From an action to velocity and acceleration setpoints.

use crate::autopilot::{STANDING_S, STANDING_SPEED};
use crate::mission::Scale;
use firmware_core::action::Action;
use firmware_core::gate::Vector;
use firmware_core::geometry::{SPEED_CAP_U, Vec2};

/// Between two setpoints at 5 Hz, s.
const PERIOD_S: f64 = 0.2;

/// Which acceleration a setpoint feeds forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedForward {
    /// The acceleration of the velocity ramp, and zero once the velocity is reached. It is limited to what
    /// a vehicle whose node dies survives: see `docs/safety.md`.
    #[default]
    Ramp,
    /// The action's own acceleration, all the time: a simulator with the scenario's own dynamics
    /// recovers the action from it.
    Action,
}

/// The velocity profile of a decision: a ramp from the velocity of the setpoint before it (or the one
/// measured) to the action's next velocity, with the greatest acceleration of the scenario, then that
/// velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityProfile {
    /// `time_boot_ms` when the ramp begins: that of the setpoint before the decision, or of the decision.
    pub decided_ms: u32,
    /// The action that was decided.
    pub action: Action,
    from_mps: [f64; 2],
    to_mps: [f64; 2],
    ramp_s: f64,
    action_mps2: [f64; 2],
    /// Greatest speed of a vehicle that goes on with a setpoint for [`STANDING_S`], m/s.
    standing_mps: f64,
}

impl VelocityProfile {
    /// The profile of `action`. `observed` is the velocity in the observation, ticks/step;
    /// `from_mps` is the velocity east and north that the ramp begins with at `decided_ms`, m/s.
    #[must_use]
    pub fn new(action: Action, decided_ms: u32, observed: Vec2, from_mps: [f64; 2], scale: Scale) -> Self {
        let next = action.next_velocity(observed.to_u());
        let to_mps = [next.0, next.1].map(|v| scale.mps(v));
        let (ax, ay) = action.acceleration();
        let change = (to_mps[0] - from_mps[0]).hypot(to_mps[1] - from_mps[1]);
        Self {
            decided_ms,
            action,
            from_mps,
            to_mps,
            ramp_s: change / scale.mps2(SPEED_CAP_U as f32),
            action_mps2: [ax, ay].map(|a| scale.mps2(a)),
            standing_mps: STANDING_SPEED * scale.mps(SPEED_CAP_U as f32),
        }
    }

    /// Velocity east and north that the ramp begins with, m/s.
    #[must_use]
    pub const fn from_mps(&self) -> [f64; 2] {
        self.from_mps
    }

    /// Velocity (mm/s) and acceleration (mm/s²) at a `time_boot_ms`.
    #[must_use]
    pub fn at(&self, boot_ms: u32, feed_forward: FeedForward) -> (Vector, Vector) {
        let passed_s = f64::from(boot_ms.wrapping_sub(self.decided_ms) as i32) / 1000.0;
        let ramping = passed_s < self.ramp_s;
        let done = if ramping { (passed_s / self.ramp_s).max(0.0) } else { 1.0 };
        let velocity = |axis: usize| self.from_mps[axis] + (self.to_mps[axis] - self.from_mps[axis]) * done;
        let velocity = [0, 1].map(velocity);
        let acceleration = match feed_forward {
            FeedForward::Action => self.action_mps2,
            FeedForward::Ramp if ramping => {
                let ramp = [0, 1].map(|axis| (self.to_mps[axis] - self.from_mps[axis]) / self.ramp_s);
                // No more than the next setpoint has made of it, and none for what it would do alone.
                let consumed = ((self.ramp_s - passed_s.max(0.0)) / PERIOD_S).min(1.0);
                let share = consumed.min(standing_share(velocity, ramp, self.standing_mps));
                ramp.map(|a| a * share)
            }
            FeedForward::Ramp => [0.0; 2],
        };
        let vector = |v: [f64; 2]| Vector::new(thousandths(v[0]), thousandths(v[1]));
        (vector(velocity), vector(acceleration))
    }
}

/// The greatest share of `acceleration`, 0 to 1, with which a vehicle at `velocity` is no faster than
/// `speed` after [`STANDING_S`]: the greater solution of |v + s·a·t|² = speed².
fn standing_share(velocity: [f64; 2], acceleration: [f64; 2], speed: f64) -> f64 {
    let gain = acceleration.map(|a| a * STANDING_S);
    let square = gain[0] * gain[0] + gain[1] * gain[1];
    if square < 1e-9 {
        return 0.0;
    }
    let along = velocity[0] * gain[0] + velocity[1] * gain[1];
    let excess = velocity[0] * velocity[0] + velocity[1] * velocity[1] - speed * speed;
    ((-along + (along * along - square * excess).max(0.0).sqrt()) / square).clamp(0.0, 1.0)
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
        assert_eq!(at(0), (Vector::new(0, 0), Vector::new(2067, 0)));
        assert_eq!(at(1000), (Vector::new(2500, 0), Vector::new(1233, 0)));
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
