//! An upper bound on what `n` sets cover, from prices on the items.
//!
//! Maximise Σ y_p with y_p ≤ Σ_{j ∋ p} x_j and Σ x_j ≤ n, all 0 or 1. A price u_p in
//! [0, 1] for each covering constraint moves it into the objective (Lagrangian
//! relaxation), and what is left falls apart:
//!
//! L(u) = Σ_p (1 − u_p) + the n largest of c_j = Σ_{p ∈ j} u_p
//!
//! is no less than the optimum for any u. Subgradient steps look for the smallest.

/// Sets still open at a part of the search, over the items not yet covered.
#[derive(Clone, Debug, Default)]
pub(crate) struct Open {
    /// Which candidates they are.
    pub(crate) ids: Vec<u32>,
    /// Their items, one set after another.
    pub(crate) items: Vec<u32>,
    /// Where each set's items begin, and the end.
    pub(crate) starts: Vec<u32>,
    /// Items in any of them, ascending.
    pub(crate) union: Vec<u32>,
}

impl Open {
    pub(crate) fn len(&self) -> usize {
        self.ids.len()
    }

    /// Items of the set at place `j`.
    pub(crate) fn set(&self, j: usize) -> &[u32] {
        &self.items[self.starts[j] as usize..self.starts[j + 1] as usize]
    }
}

/// What the steps found out; sets are named by their place in [`Open`].
#[derive(Clone, Debug)]
pub(crate) struct Bound {
    /// Smallest L(u).
    pub(crate) value: f64,
    /// c_j at that u.
    pub(crate) worth: Vec<f64>,
    /// The n best sets at that u (all of them when there are no more).
    pub(crate) chosen: Vec<u32>,
    /// How often each set was among the n best of late, 0 to 1: about its value in the
    /// relaxed optimum.
    pub(crate) share: Vec<f64>,
}

/// Bounds may be short by this much, from rounding.
const ROUNDING: f64 = 1e-6;

impl Bound {
    /// Whether a choice bounded by `value` cannot cover more than `goal`.
    pub(crate) fn is_hopeless(value: f64, goal: u32) -> bool {
        value + ROUNDING < f64::from(goal) + 1.0
    }

    /// The bound as a number of items.
    pub(crate) fn whole(&self) -> u32 {
        (self.value + ROUNDING) as u32
    }
}

/// Weight of the new slope in the direction of a step; the rest is the last direction.
const NEW_SLOPE: f64 = 0.7;
/// Steps without a smaller value after which steps get shorter.
const PATIENCE: u32 = 8;
/// Steps shorter than this part of the first are not worth making.
const LEAST_PACE: f64 = 0.01;
/// Weight of one step in [`Bound::share`].
const SHARE_WEIGHT: f64 = 0.05;

/// Improves the prices `u` (one an item of the whole problem; those outside `open` are
/// left alone) by at most `steps` steps. Stops early once no more than `goal` items
/// can be covered.
pub(crate) fn improve(open: &Open, n: usize, u: &mut [f64], goal: u32, steps: u32) -> Bound {
    let mut d = Descent::new(open, n, u.len());
    let mut best_u = u.to_vec();
    let mut best = Bound { value: f64::INFINITY, worth: Vec::new(), chosen: Vec::new(), share: vec![0.0; open.len()] };
    let (mut pace, mut in_vain) = (1.0, 0);
    for _ in 0..steps {
        let value = d.value(u);
        for s in &mut best.share {
            *s *= 1.0 - SHARE_WEIGHT;
        }
        for &j in d.chosen() {
            best.share[j as usize] += SHARE_WEIGHT;
        }
        in_vain = if value < best.value - 1e-3 { 0 } else { in_vain + 1 };
        if value < best.value {
            best.value = value;
            best.worth.clone_from(&d.worth);
            best.chosen.clear();
            best.chosen.extend_from_slice(d.chosen());
            best_u.copy_from_slice(u);
        }
        if in_vain >= PATIENCE {
            in_vain = 0;
            pace *= 0.5;
        }
        let norm = d.aim(u);
        if Bound::is_hopeless(best.value, goal) || pace < LEAST_PACE || norm < 1e-12 {
            break;
        }
        // Polyak's step towards the goal.
        let length = pace * (value - f64::from(goal)).max(0.1) / norm;
        for &p in &open.union {
            let u = &mut u[p as usize];
            *u = (*u - length * d.direction[p as usize]).clamp(0.0, 1.0);
        }
    }
    u.copy_from_slice(&best_u);
    best
}

/// Working space of the steps.
struct Descent<'a> {
    open: &'a Open,
    /// Sets taken: n, or all when there are no more.
    take: usize,
    worth: Vec<f64>,
    /// Places of the sets, those taken first.
    order: Vec<u32>,
    /// How many of the sets taken contain each item.
    times: Vec<f64>,
    direction: Vec<f64>,
}

impl<'a> Descent<'a> {
    fn new(open: &'a Open, n: usize, items: usize) -> Self {
        let m = open.len();
        Self {
            open,
            take: n.min(m),
            worth: vec![0.0; m],
            order: (0..m as u32).collect(),
            times: vec![0.0; items],
            direction: vec![0.0; items],
        }
    }

    fn chosen(&self) -> &[u32] {
        &self.order[..self.take]
    }

    /// L(u); leaves the worths and the sets taken behind.
    fn value(&mut self, u: &[f64]) -> f64 {
        for (j, w) in self.worth.iter_mut().enumerate() {
            *w = self.open.set(j).iter().map(|&p| u[p as usize]).sum();
        }
        if (1..self.order.len()).contains(&self.take) {
            let worth = |j: u32| self.worth[j as usize];
            self.order.select_nth_unstable_by(self.take - 1, |&a, &b| worth(b).total_cmp(&worth(a)).then(a.cmp(&b)));
        }
        let unpaid: f64 = self.open.union.iter().map(|&p| 1.0 - u[p as usize]).sum();
        unpaid + self.chosen().iter().map(|&j| self.worth[j as usize]).sum::<f64>()
    }

    /// Turns the direction towards the slope of L at `u`; returns its squared length.
    fn aim(&mut self, u: &[f64]) -> f64 {
        for &p in &self.open.union {
            self.times[p as usize] = 0.0;
        }
        for &j in &self.order[..self.take] {
            for &p in self.open.set(j as usize) {
                self.times[p as usize] += 1.0;
            }
        }
        let mut norm = 0.0;
        for &p in &self.open.union {
            let p = p as usize;
            let (u, times) = (u[p], self.times[p]);
            // At u_p = 1 any y_p is optimal; the one that fits the sets taken gives the
            // flatter slope.
            let y = if u < 1.0 { 1.0 } else { times.min(1.0) };
            // Prices do not fall below 0.
            let slope = if u <= 0.0 { (times - y).min(0.0) } else { times - y };
            self.direction[p] = NEW_SLOPE * slope + (1.0 - NEW_SLOPE) * self.direction[p];
            norm += self.direction[p] * self.direction[p];
        }
        norm
    }
}
