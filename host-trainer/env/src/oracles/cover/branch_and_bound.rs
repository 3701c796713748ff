//! Branch and bound for the maximum cover.

use super::bit_matrix::BitMatrix;
use super::candidates::Set;
use super::lagrangian_bound::{Bound, tighten};
use super::local_search::Selection;
use super::subproblem::Subproblem;

/// Subgradient steps at the root node.
const ROOT_STEPS: u32 = 600;
/// Subgradient steps at every other node.
const STEPS: u32 = 120;
/// Perturbations of the first incumbent when the root node leaves a gap.
const PERTURBATIONS: u32 = 400;

/// The best choice found, and the bound on better ones.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub(crate) chosen: Vec<u32>,
    pub(crate) upper_bound: u32,
    pub(crate) nodes: u64,
}

/// The best `n` of `sets` (by falling size, none empty) over the items `0..items`, visiting about `node_limit` nodes at
/// most.
pub(crate) fn solve(sets: &[Set], items: usize, n: usize, node_limit: u64) -> Solution {
    let mut selection = Selection::new(sets, items);
    selection.add_greedily(n);
    selection.exchange(n);
    let mut search = Search { sets, n, incumbent: Vec::new(), covered: 0, nodes: 0, node_limit, unexplored_bound: 0 };
    search.update_incumbent(&selection.chosen, selection.covered);
    let mut root = Node {
        chosen: Vec::new(),
        covered: 0,
        is_covered: vec![false; items],
        undecided: (0..sets.len() as u32).collect(),
        prices: vec![0.5; items],
    };
    let subproblem = search.reduce(&mut root);
    // With no more sets than may be chosen, the selection covers all that can be covered.
    if n > 0 && subproblem.len() > n {
        let bound = tighten(&subproblem, n, &mut root.prices, search.covered, ROOT_STEPS);
        if bound.floor() > search.covered {
            selection.perturb(n, PERTURBATIONS, bound.floor());
            search.update_incumbent(&selection.chosen, selection.covered);
            root.undecided = subproblem.ids;
            search.branch(root);
        }
    }
    Solution { upper_bound: search.covered.max(search.unexplored_bound), chosen: search.incumbent, nodes: search.nodes }
}

/// A node of the search tree: some sets are chosen, some excluded.
#[derive(Clone)]
struct Node {
    chosen: Vec<u32>,
    covered: u32,
    /// Which items the chosen sets cover.
    is_covered: Vec<bool>,
    /// Candidates neither chosen nor excluded.
    undecided: Vec<u32>,
    /// Prices that the bound starts from.
    prices: Vec<f64>,
}

impl Node {
    fn choose(&mut self, id: u32, items: &[u32]) {
        self.chosen.push(id);
        for &p in items {
            self.covered += u32::from(!self.is_covered[p as usize]);
            self.is_covered[p as usize] = true;
        }
    }
}

struct Search<'a> {
    sets: &'a [Set],
    n: usize,
    /// The best choice so far.
    incumbent: Vec<u32>,
    /// Items that it covers.
    covered: u32,
    nodes: u64,
    node_limit: u64,
    /// Greatest bound of a node that was given up at the limit.
    unexplored_bound: u32,
}

impl Search<'_> {
    fn update_incumbent(&mut self, chosen: &[u32], covered: u32) {
        if covered > self.covered {
            self.covered = covered;
            self.incumbent = chosen.to_vec();
        }
    }

    /// Searches below a node for something better than the incumbent. Recurses once for each chosen set, so no deeper
    /// than `n`.
    fn branch(&mut self, mut node: Node) {
        loop {
            self.nodes += 1;
            let to_choose = self.n - node.chosen.len();
            let subproblem = self.reduce(&mut node);
            self.update_incumbent(&node.chosen, node.covered);
            if to_choose == 0 || subproblem.len() == 0 {
                return;
            }
            let to_beat = self.covered - node.covered;
            let bound = tighten(&subproblem, to_choose, &mut node.prices, to_beat, STEPS);
            self.try_relaxed_choice(&node, &subproblem, &bound);
            let to_beat = self.covered - node.covered;
            if Bound::prunes(bound.value, to_beat) {
                return;
            }
            if self.nodes >= self.node_limit {
                self.unexplored_bound = self.unexplored_bound.max(node.covered + bound.floor());
                return;
            }
            if fix_sets(&mut node, &subproblem, &bound, to_choose, to_beat) {
                continue;
            }
            let at = branching_set(&subproblem, &bound);
            node.undecided.retain(|&id| id != subproblem.ids[at]);
            let mut with = node.clone();
            with.choose(subproblem.ids[at], subproblem.set(at));
            self.branch(with);
            // The loop goes on with the node that excludes the set.
        }
    }

    /// The undecided sets of a node without the items covered already and without dominated sets (those that another
    /// contains), by falling size.
    fn reduce(&self, node: &mut Node) -> Subproblem {
        let items = node.is_covered.len();
        let rest = |id: u32| self.sets[id as usize].iter().copied().filter(|&p| !node.is_covered[p as usize]);
        let mut ids: Vec<_> =
            node.undecided.iter().map(|&id| (rest(id).count(), id)).filter(|&(size, _)| size > 0).collect();
        ids.sort_unstable_by_key(|&(size, id)| (usize::MAX - size, id));
        let mut rows = BitMatrix::new(ids.len(), items);
        let mut subproblem = Subproblem::default();
        let mut in_union = vec![false; items];
        for &(_, id) in &ids {
            let row = subproblem.len();
            rows.clear(row);
            rest(id).for_each(|p| rows.set(row, p as usize));
            if (0..row).any(|larger| rows.is_subset(row, larger)) {
                continue;
            }
            subproblem.ids.push(id);
            subproblem.starts.push(subproblem.items.len() as u32);
            subproblem.items.extend(rest(id));
            rest(id).for_each(|p| in_union[p as usize] = true);
        }
        subproblem.starts.push(subproblem.items.len() as u32);
        subproblem.union = (0..items as u32).filter(|&p| in_union[p as usize]).collect();
        node.undecided.clone_from(&subproblem.ids);
        subproblem
    }

    /// The sets behind a bound are a feasible choice too.
    fn try_relaxed_choice(&mut self, node: &Node, subproblem: &Subproblem, bound: &Bound) {
        let mut whole = node.clone();
        for &j in &bound.chosen {
            whole.choose(subproblem.ids[j as usize], subproblem.set(j as usize));
        }
        self.update_incumbent(&whole.chosen, whole.covered);
    }
}

/// Variable fixing: chooses or excludes the sets whose other choice the bound rules out, by their reduced value against
/// the best set not chosen or the worst one chosen. Returns whether enough was fixed to bound the node anew.
fn fix_sets(node: &mut Node, subproblem: &Subproblem, bound: &Bound, to_choose: usize, to_beat: u32) -> bool {
    let mut is_chosen = vec![false; subproblem.len()];
    bound.chosen.iter().for_each(|&j| is_chosen[j as usize] = true);
    let values = |want: bool| bound.reduced.iter().zip(&is_chosen).filter(move |&(_, &c)| c == want).map(|(&v, _)| v);
    let best_left = values(false).fold(0.0, f64::max);
    let worst_chosen = if bound.chosen.len() < to_choose { 0.0 } else { values(true).fold(f64::INFINITY, f64::min) };
    let before = node.chosen.len();
    node.undecided.clear();
    for (j, &id) in subproblem.ids.iter().enumerate() {
        if is_chosen[j] && Bound::prunes(bound.value - bound.reduced[j] + best_left, to_beat) {
            node.choose(id, subproblem.set(j));
        } else if is_chosen[j] || !Bound::prunes(bound.value - worst_chosen + bound.reduced[j], to_beat) {
            node.undecided.push(id);
        }
    }
    node.chosen.len() > before || node.undecided.len() * 5 < subproblem.len() * 4
}

/// Index of the set to branch on: the one whose frequency is farthest from 0 and 1, weighted by its reduced value.
fn branching_set(subproblem: &Subproblem, bound: &Bound) -> usize {
    let score = |&j: &usize| bound.frequency[j] * (1.0 - bound.frequency[j]) * bound.reduced[j];
    (0..subproblem.len()).max_by(|a, b| score(a).total_cmp(&score(b)).then(b.cmp(a))).unwrap_or(0)
}
