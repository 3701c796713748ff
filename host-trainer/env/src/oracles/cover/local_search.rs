//! Good covers quickly: iterated local search.
//!
//! Greedy selection, exchange until a local optimum, perturbation.

use super::candidates::Set;
use crate::random::{below, stream};

/// A selection of sets, with how often each item is covered.
#[derive(Clone, Debug)]
pub(crate) struct Selection<'a> {
    sets: &'a [Set],
    multiplicity: Vec<u32>,
    pub(crate) chosen: Vec<u32>,
    pub(crate) covered: u32,
}

impl<'a> Selection<'a> {
    /// The empty selection from `sets` (by falling size) over `items` items.
    pub(crate) fn new(sets: &'a [Set], items: usize) -> Self {
        Self { sets, multiplicity: vec![0; items], chosen: Vec::new(), covered: 0 }
    }

    /// Number of items that set `j` would add.
    fn gain(&self, j: usize) -> u32 {
        self.sets[j].iter().map(|&p| u32::from(self.multiplicity[p as usize] == 0)).sum()
    }

    fn add(&mut self, j: u32) {
        for &p in &self.sets[j as usize] {
            self.covered += u32::from(self.multiplicity[p as usize] == 0);
            self.multiplicity[p as usize] += 1;
        }
        self.chosen.push(j);
    }

    fn remove_at(&mut self, at: usize) -> u32 {
        let j = self.chosen.remove(at);
        for &p in &self.sets[j as usize] {
            self.multiplicity[p as usize] -= 1;
            self.covered -= u32::from(self.multiplicity[p as usize] == 0);
        }
        j
    }

    /// Greedy selection: adds the set of the greatest gain (the first of equals) until there are `n` or none gains.
    pub(crate) fn add_greedily(&mut self, n: usize) {
        while self.chosen.len() < n {
            let mut best = (0, 0);
            for j in 0..self.sets.len() {
                // Sets come by falling size: none further on can gain more.
                if self.sets[j].len() as u32 <= best.0 {
                    break;
                }
                let gain = self.gain(j);
                if gain > best.0 {
                    best = (gain, j as u32);
                }
            }
            if best.0 == 0 {
                return;
            }
            self.add(best.1);
        }
    }

    /// Local search: removes each set in turn and adds greedily again, until no exchange improves.
    pub(crate) fn exchange(&mut self, n: usize) {
        let mut without_improvement = 0;
        while without_improvement < self.chosen.len() {
            let (before, others) = (self.covered, self.chosen.len() - 1);
            let old = self.remove_at(0);
            self.add_greedily(n);
            if self.covered > before {
                without_improvement = 0;
                continue;
            }
            while self.chosen.len() > others {
                self.remove_at(others);
            }
            self.add(old);
            without_improvement += 1;
        }
    }

    /// Perturbation: removes three to five sets at random, adds a random one, then adds greedily and exchanges; keeps
    /// what is no worse. Does so `rounds` times or until `upper_bound` items are covered.
    pub(crate) fn perturb(&mut self, n: usize, rounds: u32, upper_bound: u32) {
        let mut rng = stream("covey cover", 0, 0);
        for _ in 0..rounds {
            if self.covered >= upper_bound {
                return;
            }
            let mut next = self.clone();
            for _ in 0..3 + below(&mut rng, 3) {
                if !next.chosen.is_empty() {
                    let at = below(&mut rng, next.chosen.len() as u32);
                    next.remove_at(at as usize);
                }
            }
            next.add(below(&mut rng, self.sets.len() as u32));
            next.add_greedily(n);
            next.exchange(n);
            if next.covered >= self.covered {
                *self = next;
            }
        }
    }
}
