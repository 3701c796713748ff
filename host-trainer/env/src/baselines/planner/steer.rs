//! The action that flies to a place and stops there.

use super::distance;
use firmware_core::action::Action;
use firmware_core::geometry::SPEED_CAP_U;

const SPEED: f64 = SPEED_CAP_U as f64;
/// Beyond this distance, straight ahead is right, u.
const FAR_U: f64 = 14.0;
/// Within this distance three steps are looked ahead instead of two, u.
const CLOSE_U: f64 = 5.0;
/// Nearer than this is there, u.
const THERE_U: f64 = 0.5;
/// Price of speed near the target, in u of distance for each u/step.
const SPEED_PRICE: f64 = 1.5;
/// Weight of where the last velocity would lead.
const ONWARD: f64 = 2.0;

type Pair = (f64, f64);

/// The action that brings a UAV at `at` with `velocity` (u, u/step) to `target` soonest
/// and holds it there.
pub(super) fn steer(at: Pair, velocity: Pair, target: Pair) -> Action {
    let far = distance(at, target);
    let table = accelerations();
    let mut best = (f64::INFINITY, Action::COAST);
    for (action, acceleration) in Action::all().zip(table) {
        let v = after(velocity, acceleration);
        let cost = if far > FAR_U {
            let wanted = ((target.0 - at.0) / far * SPEED, (target.1 - at.1) / far * SPEED);
            super::squared(v, wanted)
        } else {
            let more = if far >= CLOSE_U { 1 } else { 2 };
            onward(at, v, target, more, 0.0, best.0, &table)
        };
        if cost < best.0 {
            best = (cost, action);
        }
    }
    best.1
}

/// Least cost of flying on from `at` with velocity `v`, over all choices in `more` further
/// steps; anything at or above `bound` is not looked at.
fn onward(at: Pair, v: Pair, target: Pair, more: u32, so_far: f64, bound: f64, table: &[Pair; 17]) -> f64 {
    let at = (at.0 + v.0, at.1 + v.1);
    let miss = |p: Pair| (distance(p, target) - THERE_U).max(0.0);
    let cost = so_far + miss(at) + SPEED_PRICE * distance(v, (0.0, 0.0));
    if cost >= bound {
        return f64::INFINITY;
    }
    if more == 0 {
        return cost + ONWARD * miss((at.0 + v.0, at.1 + v.1));
    }
    let mut best = bound;
    for &a in table {
        best = best.min(onward(at, after(v, a), target, more - 1, cost, best, table));
    }
    best
}

fn after(v: Pair, a: Pair) -> Pair {
    let next = (v.0 + a.0, v.1 + a.1);
    let speed = distance(next, (0.0, 0.0));
    let k = if speed > SPEED { SPEED / speed } else { 1.0 };
    (next.0 * k, next.1 * k)
}

fn accelerations() -> [Pair; 17] {
    let mut table = [(0.0, 0.0); 17];
    for (place, action) in table.iter_mut().zip(Action::all()) {
        *place = super::pair(action.acceleration());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrives_and_holds() {
        for target in [(30.0, 0.0), (3.0, 2.0), (-11.0, 7.5), (0.4, 0.0)] {
            let (mut at, mut v) = ((0.0, 0.0), (0.0, 0.0));
            for _ in 0..14 {
                v = after(v, super::super::pair(steer(at, v, target).acceleration()));
                at = (at.0 + v.0, at.1 + v.1);
            }
            assert!(distance(at, target) < 1.6, "{target:?}: {at:?}");
            assert!(distance(v, (0.0, 0.0)) < 1e-6, "{target:?}: {v:?}");
        }
    }
}
