//! The maximum cover of the PoIs of a world, from candidate discs to proven sites.

use super::branch_and_bound::solve;
use super::candidates::maximal_sets;
use super::disc::smallest_enclosing_disc;
use crate::plane::{squared_distance, widened};
use crate::scenario::Scenario;
use crate::world::World;
use firmware_core::geometry::COVERAGE_RANGE_U;

/// Discs are this much smaller than the coverage range, u, so that sites rounded to
/// `f32` still cover the PoIs on their edge.
pub(super) const EDGE_SLACK_U: f64 = 1e-4;
/// Branch-and-bound nodes after which [`maximum_cover`] gives up on the proof.
pub const NODE_LIMIT: u64 = 100_000;

/// Sites for UAVs, and how close to the optimum they are proven to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// Sites, u: as many as asked for, or fewer when those cover every PoI.
    pub sites: Vec<(f32, f32)>,
    /// Number of PoIs within the coverage range of a site.
    pub covered: usize,
    /// Upper bound: no choice of as many sites covers more PoIs.
    pub upper_bound: usize,
    /// Whether the sites are proven optimal, that is `covered` equals `upper_bound`.
    pub proven: bool,
    /// Branch-and-bound nodes that were visited.
    pub nodes: u64,
}

/// The best `n` sites for the PoIs at `pois` (finite, u): [`maximum_cover_within`] with [`NODE_LIMIT`].
#[must_use]
pub fn maximum_cover(pois: &[(f32, f32)], n: usize) -> Cover {
    maximum_cover_within(pois, n, NODE_LIMIT)
}

/// The best `n` sites for the PoIs at `pois` (finite, u), visiting about `nodes` branch-and-bound nodes at most. When
/// those do not suffice, `proven` is false and `upper_bound` says what a better choice could cover at most.
///
/// Bounds are for discs of 10 u less 10⁻⁴ u. The result is a function of the arguments.
#[must_use]
pub fn maximum_cover_within(pois: &[(f32, f32)], n: usize, nodes: u64) -> Cover {
    let points: Vec<_> = pois.iter().copied().map(widened).collect();
    let sets = maximal_sets(&points, f64::from(COVERAGE_RANGE_U) - EDGE_SLACK_U);
    let solution = solve(&sets, points.len(), n, nodes);
    let site = |&j: &u32| {
        // The middle of what is covered leaves the most room for error.
        let members: Vec<_> = sets[j as usize].iter().map(|&p| points[p as usize]).collect();
        let ((x, y), _) = smallest_enclosing_disc(&members);
        (x as f32, y as f32)
    };
    let sites: Vec<_> = solution.chosen.iter().map(site).collect();
    let covered = covered_by(&sites, pois);
    let upper_bound = covered.max(solution.upper_bound as usize);
    Cover { sites, covered, upper_bound, proven: covered == upper_bound, nodes: solution.nodes }
}

/// The best sites for the UAVs of a world in its present episode.
#[must_use]
pub fn best_sites(world: &World) -> Cover {
    let Scenario { uavs, .. } = *world.scenario();
    let pois: Vec<_> = world.poi_x().iter().copied().zip(world.poi_y().iter().copied()).collect();
    maximum_cover(&pois, uavs)
}

/// PoIs within the coverage range of a site, as a world counts them.
fn covered_by(sites: &[(f32, f32)], pois: &[(f32, f32)]) -> usize {
    const RANGE2: f32 = (COVERAGE_RANGE_U * COVERAGE_RANGE_U) as f32;
    pois.iter().filter(|&&p| sites.iter().any(|&site| squared_distance(p, site) <= RANGE2)).count()
}
