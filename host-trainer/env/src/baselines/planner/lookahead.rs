//! Receding-horizon control: the action that flies to a target and stops there, by a search over the next two or three
//! actions.

use crate::plane::{distance, squared_distance, widened};
use firmware_core::action::Action;
use firmware_core::geometry::SPEED_CAP_U;

const SPEED: f64 = SPEED_CAP_U as f64;
/// Beyond this distance the UAV flies straight at the target, without a search, u.
const FAR_U: f64 = 14.0;
/// Within this distance the search is over three actions instead of two, u.
const CLOSE_U: f64 = 5.0;
/// A position error below this costs nothing, u.
const TOLERANCE_U: f64 = 0.5;
/// Cost of speed near the target, in u of position error for each u/step.
const SPEED_COST: f64 = 1.5;
/// Weight of the terminal cost: the position error one step beyond the horizon at the last velocity.
const TERMINAL_WEIGHT: f64 = 2.0;

/// A position (u), a velocity (u/step) or an acceleration (u/step²).
type Vector = (f64, f64);

/// The action that brings a UAV at `at` (u) with `velocity` (u/step) to `target` (u) soonest and holds it there.
pub(super) fn fly_to(at: Vector, velocity: Vector, target: Vector) -> Action {
    let far = distance(at, target);
    let accelerations = accelerations();
    if far > FAR_U {
        let wanted = ((target.0 - at.0) / far * SPEED, (target.1 - at.1) / far * SPEED);
        let cost = |a: Vector| squared_distance(next_velocity(velocity, a), wanted);
        return first_least(accelerations.iter().map(|&a| cost(a)));
    }
    let search = Search { target, accelerations };
    let more = if far >= CLOSE_U { 1 } else { 2 };
    // The cost of the greedy trajectory is an upper bound of the least cost. It is raised a little, so that rounding
    // does not exclude that trajectory itself.
    let mut bound = search.greedy_cost(at, velocity, more) + 1e-9;
    let costs = search.accelerations.iter().map(|&a| {
        let cost = search.cost_to_go(at, next_velocity(velocity, a), more, 0.0, bound);
        bound = bound.min(cost);
        cost
    });
    first_least(costs)
}

/// The action of the least cost; of equal ones the first.
fn first_least(costs: impl Iterator<Item = f64>) -> Action {
    let mut best = (f64::INFINITY, Action::COAST);
    for (action, cost) in Action::all().zip(costs) {
        if cost < best.0 {
            best = (cost, action);
        }
    }
    best.1
}

/// A depth-first branch-and-bound search for the trajectory of least cost to a target.
struct Search {
    target: Vector,
    accelerations: [Vector; 17],
}

impl Search {
    /// Position error at `p` beyond the tolerance, u.
    fn position_error(&self, p: Vector) -> f64 {
        (distance(p, self.target) - TOLERANCE_U).max(0.0)
    }

    /// Least cost of flying on from `at` with velocity `v`, over all actions of the `more` steps after this one, added
    /// to `so_far`. Trajectories whose cost reaches `bound` are pruned.
    fn cost_to_go(&self, at: Vector, v: Vector, more: u32, so_far: f64, bound: f64) -> f64 {
        let at = (at.0 + v.0, at.1 + v.1);
        let error = self.position_error(at);
        let cost = so_far + error + SPEED_COST * distance(v, (0.0, 0.0));
        if more == 0 {
            if cost >= bound {
                return f64::INFINITY;
            }
            return cost + TERMINAL_WEIGHT * self.position_error((at.0 + v.0, at.1 + v.1));
        }
        // Lower bound: a step's speed costs more than the error it removes, so the next step costs no less than this
        // error, and each later one no less than this error less the way flown till then.
        let later = f64::from(more - 1) * (error - SPEED).max(0.0);
        if cost + error + later - 1e-9 >= bound {
            return f64::INFINITY;
        }
        let mut best = bound;
        for &a in &self.accelerations {
            best = best.min(self.cost_to_go(at, next_velocity(v, a), more - 1, cost, best));
        }
        best
    }

    /// Cost of the trajectory that takes the cheapest next step each time.
    fn greedy_cost(&self, mut at: Vector, mut v: Vector, more: u32) -> f64 {
        let mut total = 0.0;
        for _ in 0..=more {
            let mut best = (f64::INFINITY, 0.0, v);
            for &a in &self.accelerations {
                let next = next_velocity(v, a);
                let position = (at.0 + next.0, at.1 + next.1);
                let cost = self.position_error(position) + SPEED_COST * distance(next, (0.0, 0.0));
                let with_terminal =
                    cost + TERMINAL_WEIGHT * self.position_error((position.0 + next.0, position.1 + next.1));
                if with_terminal < best.0 {
                    best = (with_terminal, cost, next);
                }
            }
            (total, v) = (total + best.1, best.2);
            at = (at.0 + v.0, at.1 + v.1);
        }
        total + TERMINAL_WEIGHT * self.position_error((at.0 + v.0, at.1 + v.1))
    }
}

/// The velocity that the acceleration `a` makes of `v`, at most at full speed.
fn next_velocity(v: Vector, a: Vector) -> Vector {
    let next = (v.0 + a.0, v.1 + a.1);
    let speed = distance(next, (0.0, 0.0));
    let k = if speed > SPEED { SPEED / speed } else { 1.0 };
    (next.0 * k, next.1 * k)
}

/// Accelerations of all actions, by index.
fn accelerations() -> [Vector; 17] {
    let mut table = [(0.0, 0.0); 17];
    for (acceleration, action) in table.iter_mut().zip(Action::all()) {
        *acceleration = widened(action.acceleration());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn arrives_and_holds() {
        for target in [(30.0, 0.0), (3.0, 2.0), (-11.0, 7.5), (0.4, 0.0)] {
            let (mut at, mut v) = ((0.0, 0.0), (0.0, 0.0));
            for _ in 0..14 {
                v = next_velocity(v, widened(fly_to(at, v, target).acceleration()));
                at = (at.0 + v.0, at.1 + v.1);
            }
            assert!(distance(at, target) < 1.6, "{target:?}: {at:?}");
            assert!(distance(v, (0.0, 0.0)) < 1e-6, "{target:?}: {v:?}");
        }
    }

    /// Least cost over all trajectories, without pruning.
    fn exhaustive(s: &Search, at: Vector, v: Vector, more: u32, so_far: f64) -> f64 {
        let at = (at.0 + v.0, at.1 + v.1);
        let cost = so_far + s.position_error(at) + SPEED_COST * distance(v, (0.0, 0.0));
        if more == 0 {
            return cost + TERMINAL_WEIGHT * s.position_error((at.0 + v.0, at.1 + v.1));
        }
        let least = |a: &Vector| exhaustive(s, at, next_velocity(v, *a), more - 1, cost);
        s.accelerations.iter().map(least).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn no_trajectory_costs_less(
            (far, bearing) in (0.0..FAR_U, 0.0..std::f64::consts::TAU),
            (speed, heading) in (0.0..SPEED, 0.0..std::f64::consts::TAU),
        ) {
            let (at, target) = ((50.0, 60.0), (50.0 + far * bearing.cos(), 60.0 + far * bearing.sin()));
            let v = (speed * heading.cos(), speed * heading.sin());
            let search = Search { target, accelerations: accelerations() };
            let more = if distance(at, target) >= CLOSE_U { 1 } else { 2 };
            let costs = search.accelerations.iter().map(|&a| exhaustive(&search, at, next_velocity(v, a), more, 0.0));
            prop_assert_eq!(fly_to(at, v, target), first_least(costs));
        }
    }
}
