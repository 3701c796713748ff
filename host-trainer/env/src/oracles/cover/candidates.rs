//! Candidate sets: the maximal sets of PoIs that one disc covers.

use super::disc::{EDGE, discs_through};
use crate::plane::squared_distance;

/// A candidate set: indices of the PoIs that it covers, ascending.
pub(crate) type Set = Vec<u32>;

/// Every maximal set of points that one disc of radius `r` covers. A disc that covers
/// several points can be moved, without losing one, until two of them lie on its edge;
/// so the discs through two points, and those around one point, are all there are.
pub(crate) fn maximal_sets(points: &[(f64, f64)], r: f64) -> Vec<Set> {
    let mut sets = Vec::new();
    for (i, &a) in points.iter().enumerate() {
        sets.push(covered_from(points, a, r));
        for &b in &points[i + 1..] {
            for centre in discs_through(a, b, r).into_iter().flatten() {
                sets.push(covered_from(points, centre, r));
            }
        }
    }
    keep_maximal(&mut sets);
    sets
}

fn covered_from(points: &[(f64, f64)], centre: (f64, f64), r: f64) -> Set {
    let limit = (r + EDGE) * (r + EDGE);
    let inside = |&&p: &&(f64, f64)| squared_distance(p, centre) <= limit;
    points.iter().enumerate().filter(|(_, p)| inside(p)).map(|(i, _)| i as u32).collect()
}

/// Drops every set contained in another; of equal sets one stays. The rest are ordered
/// by falling size, then by their items.
pub(crate) fn keep_maximal(sets: &mut Vec<Set>) {
    sets.sort_unstable_by(|a, b| b.len().cmp(&a.len()).then_with(|| a.cmp(b)));
    sets.dedup();
    let mut kept: Vec<Set> = Vec::with_capacity(sets.len());
    for set in sets.drain(..) {
        if !kept.iter().any(|k| is_subset(&set, k)) {
            kept.push(set);
        }
    }
    *sets = kept;
}

fn is_subset(a: &[u32], b: &[u32]) -> bool {
    let mut b = b.iter();
    a.iter().all(|x| b.by_ref().find(|&y| y >= x) == Some(x))
}
