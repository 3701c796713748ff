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
    if far > FAR_U {
        let wanted = ((target.0 - at.0) / far * SPEED, (target.1 - at.1) / far * SPEED);
        let cost = |a: Pair| super::squared(after(velocity, a), wanted);
        return first_least(table.iter().map(|&a| cost(a)));
    }
    let search = Search { target, table };
    let more = if far >= CLOSE_U { 1 } else { 2 };
    // What a flight costs that does the best at each step: no better one costs more. A
    // little above it, so that rounding does not exclude that flight itself.
    let mut bound = search.greedy(at, velocity, more) + 1e-9;
    let costs = table.iter().map(|&a| {
        let cost = search.onward(at, after(velocity, a), more, 0.0, bound);
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

/// A search for the cheapest flight to a target.
struct Search {
    target: Pair,
    table: [Pair; 17],
}

impl Search {
    fn miss(&self, p: Pair) -> f64 {
        (distance(p, self.target) - THERE_U).max(0.0)
    }

    /// Least cost of flying on from `at` with velocity `v`, over all choices in `more`
    /// further steps; anything at or above `bound` is not looked at.
    fn onward(&self, at: Pair, v: Pair, more: u32, so_far: f64, bound: f64) -> f64 {
        let at = (at.0 + v.0, at.1 + v.1);
        let miss = self.miss(at);
        let cost = so_far + miss + SPEED_PRICE * distance(v, (0.0, 0.0));
        if more == 0 {
            if cost >= bound {
                return f64::INFINITY;
            }
            return cost + ONWARD * self.miss((at.0 + v.0, at.1 + v.1));
        }
        // A step's flight costs more than the way it saves, so the next step costs no less
        // than this miss, and each later one no less than this miss without the way till then.
        let later = f64::from(more - 1) * (miss - SPEED).max(0.0);
        if cost + miss + later - 1e-9 >= bound {
            return f64::INFINITY;
        }
        let mut best = bound;
        for &a in &self.table {
            best = best.min(self.onward(at, after(v, a), more - 1, cost, best));
        }
        best
    }

    /// Cost of a flight that takes the cheapest next step each time.
    fn greedy(&self, mut at: Pair, mut v: Pair, more: u32) -> f64 {
        let mut total = 0.0;
        for _ in 0..=more {
            let mut best = (f64::INFINITY, 0.0, v);
            for &a in &self.table {
                let next = after(v, a);
                let there = (at.0 + next.0, at.1 + next.1);
                let cost = self.miss(there) + SPEED_PRICE * distance(next, (0.0, 0.0));
                let judged = cost + ONWARD * self.miss((there.0 + next.0, there.1 + next.1));
                if judged < best.0 {
                    best = (judged, cost, next);
                }
            }
            (total, v) = (total + best.1, best.2);
            at = (at.0 + v.0, at.1 + v.1);
        }
        total + ONWARD * self.miss((at.0 + v.0, at.1 + v.1))
    }
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
    use proptest::prelude::*;

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

    /// Least cost over all flights, without bounds.
    fn cheapest(s: &Search, at: Pair, v: Pair, more: u32, so_far: f64) -> f64 {
        let at = (at.0 + v.0, at.1 + v.1);
        let cost = so_far + s.miss(at) + SPEED_PRICE * distance(v, (0.0, 0.0));
        if more == 0 {
            return cost + ONWARD * s.miss((at.0 + v.0, at.1 + v.1));
        }
        let least = |a: &Pair| cheapest(s, at, after(v, *a), more - 1, cost);
        s.table.iter().map(least).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn no_flight_is_cheaper(
            (far, bearing) in (0.0..FAR_U, 0.0..std::f64::consts::TAU),
            (speed, heading) in (0.0..SPEED, 0.0..std::f64::consts::TAU),
        ) {
            let (at, target) = ((50.0, 60.0), (50.0 + far * bearing.cos(), 60.0 + far * bearing.sin()));
            let v = (speed * heading.cos(), speed * heading.sin());
            let search = Search { target, table: accelerations() };
            let more = if distance(at, target) >= CLOSE_U { 1 } else { 2 };
            let costs = search.table.iter().map(|&a| cheapest(&search, at, after(v, a), more, 0.0));
            prop_assert_eq!(steer(at, v, target), first_least(costs));
        }
    }
}
