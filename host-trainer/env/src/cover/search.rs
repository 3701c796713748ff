//! Branch and bound for the maximum cover.

use super::bound::{Bound, Open, improve};
use super::candidates::Set;
use super::heuristic::Picks;
use crate::bits::BitRows;

/// Steps on the prices at the root and at the parts below it.
const ROOT_STEPS: u32 = 600;
const STEPS: u32 = 120;
/// Kicks of the heuristic when the root leaves a gap.
const KICKS: u32 = 400;

/// Best picks, and what is known about better ones.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) chosen: Vec<u32>,
    pub(crate) upper_bound: u32,
    pub(crate) nodes: u64,
}

/// The best `n` of `sets` (by falling size, none empty) over `0..items`, looking at
/// about `limit` parts of the search at most.
pub(crate) fn search(sets: &[Set], items: usize, n: usize, limit: u64) -> Found {
    let mut picks = Picks::new(sets, items);
    picks.fill(n);
    picks.exchange(n);
    let mut search = Search { sets, n, best: Vec::new(), covered: 0, nodes: 0, limit, left: 0 };
    search.offer(&picks.chosen, picks.covered);
    let mut root = Part {
        chosen: Vec::new(),
        covered: 0,
        done: vec![false; items],
        open: (0..sets.len() as u32).collect(),
        u: vec![0.5; items],
    };
    let open = search.reduce(&mut root);
    // Otherwise the picks cover everything that can be.
    if n > 0 && open.len() > n {
        let bound = improve(&open, n, &mut root.u, search.covered, ROOT_STEPS);
        if bound.whole() > search.covered {
            picks.kick(n, KICKS, bound.whole());
            search.offer(&picks.chosen, picks.covered);
            root.open = open.ids;
            search.explore(root);
        }
    }
    Found { upper_bound: search.covered.max(search.left), chosen: search.best, nodes: search.nodes }
}

/// A part of the search: some sets are picked, some are out.
#[derive(Clone)]
struct Part {
    chosen: Vec<u32>,
    covered: u32,
    /// Items the picks cover.
    done: Vec<bool>,
    /// Candidates neither picked nor out.
    open: Vec<u32>,
    /// Prices to start from.
    u: Vec<f64>,
}

impl Part {
    fn pick(&mut self, id: u32, items: &[u32]) {
        self.chosen.push(id);
        for &p in items {
            self.covered += u32::from(!self.done[p as usize]);
            self.done[p as usize] = true;
        }
    }
}

struct Search<'a> {
    sets: &'a [Set],
    n: usize,
    best: Vec<u32>,
    covered: u32,
    nodes: u64,
    limit: u64,
    /// Greatest bound of a part given up.
    left: u32,
}

impl Search<'_> {
    fn offer(&mut self, chosen: &[u32], covered: u32) {
        if covered > self.covered {
            self.covered = covered;
            self.best = chosen.to_vec();
        }
    }

    /// Looks for something better than the best in a part. Recurses once a pick, so no
    /// deeper than `n`.
    fn explore(&mut self, mut part: Part) {
        loop {
            self.nodes += 1;
            let picks = self.n - part.chosen.len();
            let open = self.reduce(&mut part);
            self.offer(&part.chosen, part.covered);
            if picks == 0 || open.len() == 0 {
                return;
            }
            let goal = self.covered - part.covered;
            let bound = improve(&open, picks, &mut part.u, goal, STEPS);
            self.offer_bound(&part, &open, &bound);
            let goal = self.covered - part.covered;
            if Bound::is_hopeless(bound.value, goal) {
                return;
            }
            if self.nodes >= self.limit {
                self.left = self.left.max(part.covered + bound.whole());
                return;
            }
            if fix(&mut part, &open, &bound, picks, goal) {
                continue;
            }
            let at = most_undecided(&open, &bound);
            part.open.retain(|&id| id != open.ids[at]);
            let mut with = part.clone();
            with.pick(open.ids[at], open.set(at));
            self.explore(with);
            // The loop goes on without it.
        }
    }

    /// The sets open in a part, without the items done and without sets that another
    /// contains; by falling size.
    fn reduce(&self, part: &mut Part) -> Open {
        let items = part.done.len();
        let rest = |id: u32| self.sets[id as usize].iter().copied().filter(|&p| !part.done[p as usize]);
        let mut ids: Vec<_> =
            part.open.iter().map(|&id| (rest(id).count(), id)).filter(|&(size, _)| size > 0).collect();
        ids.sort_unstable_by_key(|&(size, id)| (usize::MAX - size, id));
        let mut rows = BitRows::new(ids.len(), items);
        let mut open = Open::default();
        let mut seen = vec![false; items];
        for &(_, id) in &ids {
            let row = open.len();
            rows.clear(row);
            rest(id).for_each(|p| rows.set(row, p as usize));
            if (0..row).any(|larger| rows.is_subset(row, larger)) {
                continue;
            }
            open.ids.push(id);
            open.starts.push(open.items.len() as u32);
            open.items.extend(rest(id));
            rest(id).for_each(|p| seen[p as usize] = true);
        }
        open.starts.push(open.items.len() as u32);
        open.union = (0..items as u32).filter(|&p| seen[p as usize]).collect();
        part.open.clone_from(&open.ids);
        open
    }

    /// The sets behind a bound are a choice too.
    fn offer_bound(&mut self, part: &Part, open: &Open, bound: &Bound) {
        let mut whole = part.clone();
        for &j in &bound.chosen {
            whole.pick(open.ids[j as usize], open.set(j as usize));
        }
        self.offer(&whole.chosen, whole.covered);
    }
}

/// Settles the sets whose other choice the bound rules out, by their worth against the
/// best set not taken or the worst one taken. Returns whether enough was settled to
/// look at the part anew.
fn fix(part: &mut Part, open: &Open, bound: &Bound, picks: usize, goal: u32) -> bool {
    let mut taken = vec![false; open.len()];
    bound.chosen.iter().for_each(|&j| taken[j as usize] = true);
    let worths = |want: bool| bound.worth.iter().zip(&taken).filter(move |&(_, &t)| t == want).map(|(&w, _)| w);
    let best_left = worths(false).fold(0.0, f64::max);
    let worst_taken = if bound.chosen.len() < picks { 0.0 } else { worths(true).fold(f64::INFINITY, f64::min) };
    let before = part.chosen.len();
    part.open.clear();
    for (j, &id) in open.ids.iter().enumerate() {
        if taken[j] && Bound::is_hopeless(bound.value - bound.worth[j] + best_left, goal) {
            part.pick(id, open.set(j));
        } else if taken[j] || !Bound::is_hopeless(bound.value - worst_taken + bound.worth[j], goal) {
            part.open.push(id);
        }
    }
    part.chosen.len() > before || part.open.len() * 5 < open.len() * 4
}

/// The set to branch on: the one whose share is farthest from 0 and 1, weighted by its
/// worth.
fn most_undecided(open: &Open, bound: &Bound) -> usize {
    let score = |&j: &usize| bound.share[j] * (1.0 - bound.share[j]) * bound.worth[j];
    (0..open.len()).max_by(|a, b| score(a).total_cmp(&score(b)).then(b.cmp(a))).unwrap_or(0)
}
