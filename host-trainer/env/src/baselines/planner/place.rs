//! What a place is worth, and the best one.

use super::ground::Ground;
use super::{distance, squared};
use core::ops::Range;
use firmware_core::geometry::{COVERAGE_RANGE_U, OBSERVATION_RANGE_U, SPEED_CAP_U};

const SPEED: f64 = SPEED_CAP_U as f64;
const COVERAGE_U: f64 = COVERAGE_RANGE_U as f64;
/// An unseen cell counts for places within this distance of it, u.
const EXPLORE_U: f64 = 11.0;
/// A claim holds the PoIs within this distance of its target, u: a little less than
/// coverage, since nobody arrives to the inch.
const CLAIM_U: f64 = COVERAGE_U - 0.3;
/// Steps after which an old claim has lost all but 1/e of its weight.
const CLAIM_FADES: f64 = 180.0;

/// Settings of the choice.
#[derive(Clone, Debug)]
pub(super) struct Weights {
    /// A PoI counts for coarse places within this distance, u.
    pub reach_u: f64,
    /// Within this distance of the refined place a PoI counts in full; from there to the
    /// coverage range its weight falls to a fifth.
    pub sure_u: f64,
    /// Weight of the PoIs to be expected in an unseen cell from the law alone.
    pub prior: f64,
    /// Weight of the guess that PoIs lie near known ones.
    pub near_known: f64,
    /// Summed nearness at which that guess has reached 63 %.
    pub near_known_scale: f64,
    /// Bonus of places straight ahead.
    pub inertia: f64,
    /// Weight of the claims of UAVs that yield.
    pub junior_claim: f64,
    /// Bonus of the present target.
    pub hysteresis: f64,
}

/// A PoI that the UAV knows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Poi {
    /// Position, u.
    pub at: (f64, f64),
    /// Its number.
    pub index: usize,
    /// What a step of covering it is worth, at most 1.
    pub weight: f64,
}

/// Where another UAV is and wants to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim {
    pub id: usize,
    pub at: (f64, f64),
    pub target: (f64, f64),
    /// Steps since it was so.
    pub age: f64,
    /// Whether the other yields to this UAV.
    pub junior: bool,
}

/// All that a choice depends on, besides the seen cells.
pub(super) struct Brief<'b> {
    pub id: usize,
    pub at: (f64, f64),
    pub velocity: (f64, f64),
    /// Steps to look ahead.
    pub horizon: f64,
    pub pois: &'b [Poi],
    pub claims: &'b [Claim],
    /// Share of the PoIs that it does not know.
    pub unknown: f64,
    /// Weight of guesses.
    pub fade: f64,
    /// Present target, if it may be kept.
    pub kept: Option<(f64, f64)>,
}

/// Something worth being near: a PoI or an unseen cell.
struct Prize {
    at: (f64, f64),
    weight: f64,
    /// Steps that others' claims secure.
    taken: f64,
}

/// An unseen cell.
struct Unseen {
    cell: (usize, usize),
    prize: Prize,
}

/// The best place to be, u; `None` when none is worth anything.
pub(super) fn choose(
    brief: &Brief<'_>,
    weights: &Weights,
    ground: &Ground,
    unseen: impl Fn((usize, usize)) -> bool,
    nearness: impl Fn((usize, usize)) -> f64,
) -> Option<(f64, f64)> {
    let claims: Vec<(f64, (f64, f64))> = brief.claims.iter().map(|c| (secured(c, brief, weights), c.target)).collect();
    let taken = |at: (f64, f64), range: f64| {
        claims.iter().filter(|(_, t)| squared(*t, at) <= range * range).fold(0.0f64, |most, (g, _)| most.max(*g))
    };
    let pois: Vec<Prize> =
        brief.pois.iter().map(|p| Prize { at: p.at, weight: p.weight, taken: taken(p.at, CLAIM_U) }).collect();
    let reach = brief.horizon * SPEED + EXPLORE_U;
    let mut cells = Vec::new();
    for a in ground.span(brief.at.0, reach) {
        for b in ground.span(brief.at.1, reach) {
            if unseen((a, b)) {
                let near = 1.0 - libm::exp(-nearness((a, b)) / weights.near_known_scale);
                let guess = weights.prior * ground.expected((a, b)) * brief.unknown
                    + weights.near_known * near * (3.0 * brief.unknown).min(1.0);
                let at = ground.centre((a, b));
                if brief.fade * guess >= 1e-4 {
                    let taken = taken(at, f64::from(OBSERVATION_RANGE_U));
                    cells.push(Unseen { cell: (a, b), prize: Prize { at, weight: brief.fade * guess, taken } });
                }
            }
        }
    }
    let coarse = coarse(brief, weights, ground, &pois, &cells)?;
    Some(refine(brief, weights, ground, &pois, &cells, coarse))
}

/// Steps that a claim secures, weighted by its age and its UAV's rank.
fn secured(claim: &Claim, brief: &Brief<'_>, weights: &Weights) -> f64 {
    let flight = (distance(claim.at, claim.target) / SPEED - claim.age).max(0.0);
    let rank = if claim.junior { weights.junior_claim } else { 1.0 };
    rank * libm::exp(-claim.age / CLAIM_FADES) * (brief.horizon - flight).max(0.0)
}

/// The best cell centre.
fn coarse(
    brief: &Brief<'_>,
    weights: &Weights,
    ground: &Ground,
    pois: &[Prize],
    cells: &[Unseen],
) -> Option<(f64, f64)> {
    let reach = brief.horizon * SPEED;
    let (columns, rows) = (ground.span(brief.at.0, reach), ground.span(brief.at.1, reach));
    let places = || columns.clone().flat_map(|a| rows.clone().map(move |b| (a, b)));
    let time: Vec<f64> = places().map(|c| time_there(brief, ground.centre(c))).collect();
    let mut worth = vec![0.0f64; time.len()];
    for cell in cells {
        // Centres of cells within 11 u of this one's, column by column.
        for (da, half) in [(-2, 0), (-1, 1), (0, 2), (1, 1), (2, 0)] {
            let ((a, b), prize) = (cell.cell, &cell.prize);
            let Some(a) = a.checked_add_signed(da).filter(|a| columns.contains(a)) else { continue };
            let reached = clip(b.saturating_sub(half)..b + half + 1, &rows);
            let first = (a - columns.start) * rows.len();
            let line = first + reached.start - rows.start..first + reached.end - rows.start;
            for (worth, time) in worth[line.clone()].iter_mut().zip(&time[line]) {
                *worth += prize.weight * (time - prize.taken).max(0.0);
            }
        }
    }
    for prize in pois {
        let range = weights.reach_u;
        for a in clip(ground.span(prize.at.0, range), &columns) {
            for b in clip(ground.span(prize.at.1, range), &rows) {
                let k = (a - columns.start) * rows.len() + b - rows.start;
                if squared(ground.centre((a, b)), prize.at) <= range * range {
                    worth[k] += prize.weight * (time[k] - prize.taken).max(0.0);
                }
            }
        }
    }
    let mut best: Option<(f64, (f64, f64))> = None;
    for (cell, &worth) in places().zip(&worth) {
        let place = ground.centre(cell);
        let worth = if worth > 0.0 { worth * ahead(brief, weights, place) } else { 0.0 };
        if worth > best.map_or(0.0, |b| b.0) {
            best = Some((worth, place));
        }
    }
    best.map(|(_, place)| place)
}

fn clip(a: Range<usize>, b: &Range<usize>) -> Range<usize> {
    let start = a.start.clamp(b.start, b.end);
    start..a.end.clamp(start, b.end)
}

/// Steps that are left after the flight to a place.
fn time_there(brief: &Brief<'_>, place: (f64, f64)) -> f64 {
    brief.horizon - distance(place, brief.at) / SPEED
}

/// Factor of a place for lying ahead. A UAV that hovers and sees nothing has a direction
/// of its own, by its id, so that a crowd spreads.
fn ahead(brief: &Brief<'_>, weights: &Weights, place: (f64, f64)) -> f64 {
    let (vx, vy) = brief.velocity;
    let moving = vx * vx + vy * vy > 0.25;
    let far = distance(place, brief.at);
    if weights.inertia == 0.0 || far <= 4.0 || !(moving || brief.pois.is_empty()) {
        return 1.0;
    }
    let (ux, uy) = if moving {
        (vx / SPEED, vy / SPEED)
    } else {
        // Multiples of the golden angle never crowd.
        let angle = 2.399_96 * brief.id as f64;
        (libm::cos(angle), libm::sin(angle))
    };
    1.0 + weights.inertia * ((place.0 - brief.at.0) * ux + (place.1 - brief.at.1) * uy) / far
}

/// The best point on a grid of 1 u around the best cell and around the present target.
fn refine(
    brief: &Brief<'_>,
    weights: &Weights,
    ground: &Ground,
    pois: &[Prize],
    cells: &[Unseen],
    coarse: (f64, f64),
) -> (f64, f64) {
    const AROUND: i32 = 3;
    // Closer to the edge there is nothing to win.
    let inside = |v: f64| v.clamp(2.0, ground.side_u() - 2.0);
    let mut best = (-1.0, coarse);
    for (middle, kept) in [(Some(coarse), false), (brief.kept, true)] {
        let Some(middle) = middle else { continue };
        // Only prizes that some point of the grid can win.
        let limit = COVERAGE_U.max(EXPLORE_U) + 1.5 * f64::from(AROUND);
        let near = |p: &&Prize| squared(p.at, middle) <= limit * limit;
        let pois: Vec<&Prize> = pois.iter().filter(near).collect();
        let cells: Vec<&Prize> = cells.iter().map(|c| &c.prize).filter(near).collect();
        for dx in -AROUND..=AROUND {
            for dy in -AROUND..=AROUND {
                let place = (inside(middle.0 + f64::from(dx)), inside(middle.1 + f64::from(dy)));
                let time = time_there(brief, place);
                let mut worth = 0.0;
                for &&Prize { at, weight, taken } in &pois {
                    let d2 = squared(place, at);
                    if time > taken && d2 <= COVERAGE_U * COVERAGE_U {
                        let past = ((d2.sqrt() - weights.sure_u) / (COVERAGE_U - weights.sure_u)).max(0.0);
                        worth += weight * (time - taken) * (1.0 - 0.8 * past);
                    }
                }
                for &&Prize { at, weight, taken } in &cells {
                    if time > taken && squared(place, at) <= EXPLORE_U * EXPLORE_U {
                        worth += weight * (time - taken);
                    }
                }
                if kept {
                    worth *= 1.0 + weights.hysteresis;
                    if (dx, dy) == (0, 0) {
                        worth *= 1.0 + weights.hysteresis;
                    }
                }
                if worth > best.0 {
                    best = (worth, place);
                }
            }
        }
    }
    best.1
}
