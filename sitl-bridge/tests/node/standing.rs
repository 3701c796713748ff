//! How far a vehicle flies on whose node dies: the last setpoint is left standing. Computed with models of
//! ArduCopter; `docs/safety.md` has what they are and what was measured.

use firmware_core::action::Action;
use firmware_core::geometry::Vec2;
use sitl_bridge::mission::Scale;
use sitl_bridge::node::{FeedForward, VelocityProfile};

const SCALE: Scale = Scale { unit_m: 2.5, step_ms: 2000 };
/// The autopilot's own braking after its timeout, m/s².
const BRAKING: f64 = 2.5;
/// How far a vehicle is behind what it is asked: fits the distances that were measured, s.
const BEHIND_S: f64 = 0.65;

/// Distance flown by a point mass with velocity `v` that goes on accelerating with `a` for `timeout_s`, and
/// then brakes, m.
fn point_mass(v: [f64; 2], a: [f64; 2], timeout_s: f64) -> f64 {
    let along = |axis: usize, t: f64| v[axis] * t + a[axis] * t * t / 2.0;
    let end = [0, 1].map(|axis| v[axis] + a[axis] * timeout_s);
    let speed = end[0].hypot(end[1]);
    let braking_s = speed / BRAKING;
    let place = [0, 1].map(|axis| along(axis, timeout_s) + end[axis] * braking_s / 2.0);
    place[0].hypot(place[1])
}

/// The same where the vehicle is behind what it is asked.
fn behind(v: [f64; 2], a: [f64; 2], timeout_s: f64) -> f64 {
    let is = [0, 1].map(|axis| v[axis] - BEHIND_S * a[axis]);
    point_mass(v, a, timeout_s) + BEHIND_S * is[0].hypot(is[1])
}

/// Every setpoint of every action from many velocities, m/s and m/s².
fn setpoints() -> Vec<([f64; 2], [f64; 2])> {
    let mut all = Vec::new();
    for index in 0..17 {
        let action = Action::new(index).unwrap();
        for (speed, turn) in (0..=16).flat_map(|speed| (0..16).map(move |turn| (speed, turn))) {
            let (sin, cos) = (f64::from(turn) * std::f64::consts::TAU / 16.0).sin_cos();
            let speed = f64::from(speed) / 4.0;
            let observed = Vec2::from_u((speed * cos) as f32, (speed * sin) as f32);
            let measured = [cos, sin].map(|share| speed * 1.25 * share);
            let profile = VelocityProfile::new(action, 0, observed, measured, SCALE);
            for boot_ms in (0..4000).step_by(50) {
                let (v, a) = profile.at(boot_ms, FeedForward::Ramp);
                let si = |v: firmware_core::gate::Vector| [f64::from(v.east) / 1000.0, f64::from(v.north) / 1000.0];
                all.push((si(v), si(a)));
            }
        }
    }
    all
}

#[test]
fn the_model_flies_no_less_far_than_what_was_measured() {
    // Killed at 4.3 m/s in a ramp of 2.5 m/s², which was fed forward wholly.
    let asked = 4.3 + BEHIND_S * 2.5;
    for (timeout_s, measured_m) in [(0.6, 17.5), (1.0, 23.8), (3.0, 59.3)] {
        let computed = behind([asked, 0.0], [2.5, 0.0], timeout_s);
        assert!((measured_m..measured_m * 1.2).contains(&computed), "{timeout_s} s: {computed} m");
    }
}

#[test]
fn a_setpoint_left_standing_ends_within_bounds() {
    let farthest = |model: fn([f64; 2], [f64; 2], f64) -> f64, timeout_s: f64| {
        setpoints().iter().map(|&(v, a)| model(v, a, timeout_s)).fold(0.0, f64::max)
    };
    let computed = [1.0, 3.0].map(|timeout_s| [farthest(point_mass, timeout_s), farthest(behind, timeout_s)]);
    let bounds = [[10.5, 13.7], [22.0, 25.0]];
    for (computed, bounds) in computed.iter().zip(&bounds) {
        assert!(computed[0] <= bounds[0] && computed[1] <= bounds[1], "{computed:?} m");
    }
}

#[test]
fn no_acceleration_is_fed_forward_where_none_is_needed() {
    let profile = VelocityProfile::new(Action::new(0).unwrap(), 0, Vec2::default(), [0.0; 2], SCALE);
    let at = |boot_ms: u32| profile.at(boot_ms, FeedForward::Ramp).1.east;
    assert!(at(1900) > 0 && at(1900) < at(1000) / 2, "more than the next setpoint makes of it: {}", at(1900));
    assert_eq!((at(2000), at(5000)), (0, 0));
    let coasting = VelocityProfile::new(Action::COAST, 0, Vec2::from_u(4.0, 0.0), [5.0, 0.0], SCALE);
    assert_eq!(coasting.at(100, FeedForward::Ramp).1.east, 0);
}
