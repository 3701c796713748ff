//! The most PoIs that so many discs can cover, with a proof.
//!
//! Candidate sites are the discs around a PoI and those through two PoIs; of the sets
//! of PoIs they cover the maximal ones are kept (`candidates`). Greedy picks improved by
//! exchange give a cover (`heuristic`), prices on the PoIs a bound (`bound`), and a
//! search closes what gap is left (`search`).

mod bound;
mod candidates;
mod heuristic;
mod search;
#[cfg(test)]
mod tests;

use crate::scenario::Scenario;
use crate::world::World;
use candidates::{maximal_sets, smallest_disc};
use firmware_core::geometry::COVERAGE_RANGE_U;
use search::search;

/// Discs are this much smaller than the coverage range, u, so that sites rounded to
/// `f32` still cover the PoIs on their edge.
const EDGE_SLACK_U: f64 = 1e-4;
/// Parts of the search that [`maximum_cover`] looks at before it gives up on the proof.
pub const NODE_LIMIT: u64 = 100_000;

/// Sites for UAVs, and how good they are.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// Sites, u: as many as asked for, or fewer when those cover every PoI.
    pub sites: Vec<(f32, f32)>,
    /// PoIs within the coverage range of a site.
    pub covered: usize,
    /// No choice of sites covers more than this.
    pub upper_bound: usize,
    /// Whether `covered` is the most possible, that is equal to `upper_bound`.
    pub proven: bool,
    /// Parts of the search looked at.
    pub nodes: u64,
}

/// The best `n` sites for the PoIs at `pois` (finite, u). See
/// [`maximum_cover_within`].
#[must_use]
pub fn maximum_cover(pois: &[(f32, f32)], n: usize) -> Cover {
    maximum_cover_within(pois, n, NODE_LIMIT)
}

/// The best `n` sites for the PoIs at `pois` (finite, u), looking at no more than about
/// `nodes` parts of the search; when those do not suffice, `proven` is false and
/// `upper_bound` says what a better choice could cover at most.
///
/// Bounds are for discs of 10 u less 10⁻⁴ u. The result is a function of the arguments.
#[must_use]
pub fn maximum_cover_within(pois: &[(f32, f32)], n: usize, nodes: u64) -> Cover {
    let points: Vec<_> = pois.iter().map(|&(x, y)| (f64::from(x), f64::from(y))).collect();
    let sets = maximal_sets(&points, f64::from(COVERAGE_RANGE_U) - EDGE_SLACK_U);
    let found = search(&sets, points.len(), n, nodes);
    let site = |&j: &u32| {
        // The middle of what is covered leaves the most room for error.
        let members: Vec<_> = sets[j as usize].iter().map(|&p| points[p as usize]).collect();
        let ((x, y), _) = smallest_disc(&members);
        (x as f32, y as f32)
    };
    let sites: Vec<_> = found.chosen.iter().map(site).collect();
    let covered = covered_by(&sites, pois);
    let upper_bound = covered.max(found.upper_bound as usize);
    Cover { sites, covered, upper_bound, proven: covered == upper_bound, nodes: found.nodes }
}

/// The best sites for the UAVs of a world.
#[must_use]
pub fn best_sites(world: &World) -> Cover {
    let Scenario { uavs, .. } = *world.scenario();
    let pois: Vec<_> = world.poi_x().iter().copied().zip(world.poi_y().iter().copied()).collect();
    maximum_cover(&pois, uavs)
}

/// PoIs within the coverage range of a site, as a world counts them.
fn covered_by(sites: &[(f32, f32)], pois: &[(f32, f32)]) -> usize {
    const RANGE2: f32 = (COVERAGE_RANGE_U * COVERAGE_RANGE_U) as f32;
    let near = |p: &(f32, f32), s: &(f32, f32)| {
        let (dx, dy) = (p.0 - s.0, p.1 - s.1);
        dx * dx + dy * dy <= RANGE2
    };
    pois.iter().filter(|p| sites.iter().any(|s| near(p, s))).count()
}
