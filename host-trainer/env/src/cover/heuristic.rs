//! Good covers quickly: greedy, exchange and kicks.

use super::candidates::Set;
use crate::random::{below, stream};

/// Picks of sets, with how often each item is covered.
#[derive(Clone, Debug)]
pub(crate) struct Picks<'a> {
    sets: &'a [Set],
    times: Vec<u32>,
    pub(crate) chosen: Vec<u32>,
    pub(crate) covered: u32,
}

impl<'a> Picks<'a> {
    /// Nothing picked from `sets` (by falling size) over `items` items.
    pub(crate) fn new(sets: &'a [Set], items: usize) -> Self {
        Self { sets, times: vec![0; items], chosen: Vec::new(), covered: 0 }
    }

    /// Items that set `j` would add.
    fn gain(&self, j: usize) -> u32 {
        self.sets[j].iter().map(|&p| u32::from(self.times[p as usize] == 0)).sum()
    }

    fn add(&mut self, j: u32) {
        for &p in &self.sets[j as usize] {
            self.covered += u32::from(self.times[p as usize] == 0);
            self.times[p as usize] += 1;
        }
        self.chosen.push(j);
    }

    fn remove_at(&mut self, at: usize) -> u32 {
        let j = self.chosen.remove(at);
        for &p in &self.sets[j as usize] {
            self.times[p as usize] -= 1;
            self.covered -= u32::from(self.times[p as usize] == 0);
        }
        j
    }

    /// Adds the set of the greatest gain (the first of equals) until there are `n` or
    /// none gains.
    pub(crate) fn fill(&mut self, n: usize) {
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

    /// Takes each pick back in turn and fills up again, until nothing improves.
    pub(crate) fn exchange(&mut self, n: usize) {
        let mut in_vain = 0;
        while in_vain < self.chosen.len() {
            let (before, others) = (self.covered, self.chosen.len() - 1);
            let old = self.remove_at(0);
            self.fill(n);
            if self.covered > before {
                in_vain = 0;
                continue;
            }
            while self.chosen.len() > others {
                self.remove_at(others);
            }
            self.add(old);
            in_vain += 1;
        }
    }

    /// Takes back a few picks at random, adds a random one, fills up and exchanges;
    /// keeps what is no worse. Does so `rounds` times or until `enough` are covered.
    pub(crate) fn kick(&mut self, n: usize, rounds: u32, enough: u32) {
        let mut rng = stream("covey cover", 0, 0);
        for _ in 0..rounds {
            if self.covered >= enough {
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
            next.fill(n);
            next.exchange(n);
            if next.covered >= self.covered {
                *self = next;
            }
        }
    }
}
