//! An upper bound on what `n` sets cover, by Lagrangian relaxation.
//!
//! Maximise Σ y_p with y_p ≤ Σ_{j ∋ p} x_j and Σ x_j ≤ n, all 0 or 1. A price u_p in
//! [0, 1] for each covering constraint moves it into the objective (Lagrangian
//! relaxation), and what is left falls apart:
//!
//! L(u) = Σ_p (1 − u_p) + the n largest of c_j = Σ_{p ∈ j} u_p
//!
//! is no less than the optimum for any u. Subgradient descent looks for the smallest.

use super::subproblem::Subproblem;

/// The smallest bound found; sets are named by their index in [`Subproblem`].
#[derive(Clone, Debug)]
pub(crate) struct Bound {
    /// Smallest L(u).
    pub(crate) value: f64,
    /// The reduced values c_j of the sets at that u.
    pub(crate) reduced: Vec<f64>,
    /// The n best sets at that u (all of them when there are no more).
    pub(crate) chosen: Vec<u32>,
    /// How often each set was among the n best in recent steps, 0 to 1: an estimate of x_j in the relaxed optimum.
    pub(crate) frequency: Vec<f64>,
}

/// Bounds may be short by this much, from rounding.
const ROUNDING: f64 = 1e-6;

impl Bound {
    /// Whether a choice bounded by `value` cannot cover more than `to_beat` items, so that it can be pruned.
    pub(crate) fn prunes(value: f64, to_beat: u32) -> bool {
        value + ROUNDING < f64::from(to_beat) + 1.0
    }

    /// The bound rounded down to a number of items.
    pub(crate) fn floor(&self) -> u32 {
        (self.value + ROUNDING) as u32
    }
}

/// Weight of the new subgradient in the direction of a step; the rest is the last direction.
const NEW_SUBGRADIENT: f64 = 0.7;
/// Steps without improvement after which the step size is halved.
const PATIENCE: u32 = 8;
/// Step size, as a fraction of the first, below which the descent ends.
const LEAST_STEP_SIZE: f64 = 0.01;
/// Weight of one step in [`Bound::frequency`].
const FREQUENCY_WEIGHT: f64 = 0.05;

/// Improves the prices `u` (one for each item of the whole problem; those outside `subproblem` are left alone) by at
/// most `steps` subgradient steps. Stops early once no more than `to_beat` items (those of the incumbent) can be
/// covered.
pub(crate) fn tighten(subproblem: &Subproblem, n: usize, u: &mut [f64], to_beat: u32, steps: u32) -> Bound {
    let mut d = SubgradientDescent::new(subproblem, n, u.len());
    let mut best_u = u.to_vec();
    let mut best =
        Bound { value: f64::INFINITY, reduced: Vec::new(), chosen: Vec::new(), frequency: vec![0.0; subproblem.len()] };
    let (mut step_size, mut without_improvement) = (1.0, 0);
    for _ in 0..steps {
        let value = d.value(u);
        for f in &mut best.frequency {
            *f *= 1.0 - FREQUENCY_WEIGHT;
        }
        for &j in d.chosen() {
            best.frequency[j as usize] += FREQUENCY_WEIGHT;
        }
        without_improvement = if value < best.value - 1e-3 { 0 } else { without_improvement + 1 };
        if value < best.value {
            best.value = value;
            best.reduced.clone_from(&d.reduced);
            best.chosen.clear();
            best.chosen.extend_from_slice(d.chosen());
            best_u.copy_from_slice(u);
        }
        if without_improvement >= PATIENCE {
            without_improvement = 0;
            step_size *= 0.5;
        }
        let norm = d.update_direction(u);
        if Bound::prunes(best.value, to_beat) || step_size < LEAST_STEP_SIZE || norm < 1e-12 {
            break;
        }
        // Polyak's step length, towards the value to beat.
        let length = step_size * (value - f64::from(to_beat)).max(0.1) / norm;
        for &p in &subproblem.union {
            let u = &mut u[p as usize];
            *u = (*u - length * d.direction[p as usize]).clamp(0.0, 1.0);
        }
    }
    u.copy_from_slice(&best_u);
    best
}

/// Working space of the descent.
struct SubgradientDescent<'a> {
    subproblem: &'a Subproblem,
    /// Number of sets in the relaxed solution: n, or all when there are no more.
    chosen_count: usize,
    reduced: Vec<f64>,
    /// Indices of the sets, the n best first.
    order: Vec<u32>,
    /// How many of the chosen sets contain each item.
    multiplicity: Vec<f64>,
    direction: Vec<f64>,
}

impl<'a> SubgradientDescent<'a> {
    fn new(subproblem: &'a Subproblem, n: usize, items: usize) -> Self {
        let m = subproblem.len();
        Self {
            subproblem,
            chosen_count: n.min(m),
            reduced: vec![0.0; m],
            order: (0..m as u32).collect(),
            multiplicity: vec![0.0; items],
            direction: vec![0.0; items],
        }
    }

    fn chosen(&self) -> &[u32] {
        &self.order[..self.chosen_count]
    }

    /// L(u); leaves the reduced values and the chosen sets behind.
    fn value(&mut self, u: &[f64]) -> f64 {
        for (j, w) in self.reduced.iter_mut().enumerate() {
            *w = self.subproblem.set(j).iter().map(|&p| u[p as usize]).sum();
        }
        if (1..self.order.len()).contains(&self.chosen_count) {
            let reduced = |j: u32| self.reduced[j as usize];
            self.order.select_nth_unstable_by(self.chosen_count - 1, |&a, &b| {
                reduced(b).total_cmp(&reduced(a)).then(a.cmp(&b))
            });
        }
        let uncovered: f64 = self.subproblem.union.iter().map(|&p| 1.0 - u[p as usize]).sum();
        uncovered + self.chosen().iter().map(|&j| self.reduced[j as usize]).sum::<f64>()
    }

    /// Updates the direction by the subgradient of L at `u`; returns its squared length.
    fn update_direction(&mut self, u: &[f64]) -> f64 {
        for &p in &self.subproblem.union {
            self.multiplicity[p as usize] = 0.0;
        }
        for &j in &self.order[..self.chosen_count] {
            for &p in self.subproblem.set(j as usize) {
                self.multiplicity[p as usize] += 1.0;
            }
        }
        let mut norm = 0.0;
        for &p in &self.subproblem.union {
            let p = p as usize;
            let (u, multiplicity) = (u[p], self.multiplicity[p]);
            // At u_p = 1 any y_p is optimal; the one that fits the chosen sets gives the smaller subgradient.
            let y = if u < 1.0 { 1.0 } else { multiplicity.min(1.0) };
            // Prices do not fall below 0.
            let subgradient = if u <= 0.0 { (multiplicity - y).min(0.0) } else { multiplicity - y };
            self.direction[p] = NEW_SUBGRADIENT * subgradient + (1.0 - NEW_SUBGRADIENT) * self.direction[p];
            norm += self.direction[p] * self.direction[p];
        }
        norm
    }
}
