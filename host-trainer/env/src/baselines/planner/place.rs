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
    /// Weight of the PoIs to be expected in an unseen cell from the distribution alone.
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
#[derive(Clone, Copy, Debug, Default)]
struct Prize {
    at: (f64, f64),
    weight: f64,
    /// Steps that others' claims secure.
    taken: f64,
}

/// The map around a UAV, column by column, with a margin of cells of no weight.
#[derive(Clone, Debug, Default)]
struct Window {
    columns: Range<usize>,
    rows: Range<usize>,
    /// Numbers from column to column.
    step: usize,
    /// What being near a cell is worth; 0 where it has been seen.
    weight: Vec<f64>,
    /// Steps that others' claims on a cell secure.
    taken: Vec<f64>,
}

/// Cells beyond a place that count for it at most: they end 11 u from its centre.
const MARGIN: usize = 2;

impl Window {
    fn clear(&mut self, columns: Range<usize>, rows: Range<usize>) {
        self.step = rows.len() + 2 * MARGIN;
        let cells = (columns.len() + 2 * MARGIN) * self.step;
        for values in [&mut self.weight, &mut self.taken] {
            values.clear();
            values.resize(cells, 0.0);
        }
        (self.columns, self.rows) = (columns, rows);
    }

    /// Place of a cell in the lists, moved by whole columns and rows.
    fn place(&self, (a, b): (usize, usize), (da, db): (usize, usize)) -> usize {
        (a - self.columns.start + da) * self.step + b - self.rows.start + db
    }

    /// Place of a cell in the lists.
    fn of(&self, cell: (usize, usize)) -> usize {
        self.place(cell, (MARGIN, MARGIN))
    }
}

/// A column of cells as its UAV knows it.
pub(super) struct Column<'c> {
    /// Its number.
    pub a: usize,
    /// The rows of it.
    pub rows: Range<usize>,
    /// To be filled in: summed nearness of the known PoIs to each cell.
    pub near: &'c mut [f64],
    /// To be filled in: which cells have been seen.
    pub seen: &'c mut [bool],
}

/// Chooses places; holds what is used anew each time.
#[derive(Clone, Debug, Default)]
pub(super) struct Chooser {
    claims: Vec<(f64, (f64, f64))>,
    pois: Vec<Prize>,
    window: Window,
    near: Vec<f64>,
    seen: Vec<bool>,
    time: Vec<f64>,
    worth: Vec<f64>,
}

impl Chooser {
    /// The best place to be, u; `None` when none is worth anything. `look` fills in a
    /// column of cells.
    pub(super) fn choose(
        &mut self,
        brief: &Brief<'_>,
        weights: &Weights,
        ground: &Ground,
        look: impl FnMut(Column<'_>),
    ) -> Option<(f64, f64)> {
        self.claims.clear();
        self.claims.extend(brief.claims.iter().map(|c| (secured(c, brief, weights), c.target)));
        self.pois.clear();
        for p in brief.pois {
            let taken = taken(&self.claims, p.at, CLAIM_U);
            self.pois.push(Prize { at: p.at, weight: p.weight, taken });
        }
        self.guess(brief, weights, ground, look);
        let coarse = self.coarse(brief, weights, ground)?;
        Some(self.refine(brief, weights, ground, coarse))
    }

    /// Weighs the cells that nobody has seen.
    fn guess(&mut self, brief: &Brief<'_>, weights: &Weights, ground: &Ground, mut look: impl FnMut(Column<'_>)) {
        let reach = brief.horizon * SPEED + EXPLORE_U;
        let (columns, rows) = (ground.span(brief.at.0, reach), ground.span(brief.at.1, reach));
        self.window.clear(columns.clone(), rows.clone());
        let Self { claims, window, near, seen, .. } = self;
        near.resize(rows.len(), 0.0);
        seen.resize(rows.len(), false);
        let near_known = weights.near_known;
        let trust = (3.0 * brief.unknown).min(1.0);
        for a in columns {
            look(Column { a, rows: rows.clone(), near, seen });
            near.iter_mut().for_each(|n| *n = -*n / weights.near_known_scale);
            exponentials(near);
            let at = window.of((a, rows.start));
            let (weight, taken) = (&mut window.weight[at..], &mut window.taken[at..]);
            for (k, b) in rows.clone().enumerate() {
                let guess =
                    weights.prior * ground.expected((a, b)) * brief.unknown + near_known * (1.0 - near[k]) * trust;
                let worth = brief.fade * guess;
                weight[k] = if !seen[k] && worth >= 1e-4 { worth } else { 0.0 };
            }
            for (secured, target) in claims.iter() {
                for (k, b) in rows.clone().enumerate() {
                    let range = f64::from(OBSERVATION_RANGE_U);
                    let near = squared(*target, ground.centre((a, b))) <= range * range;
                    taken[k] = if near && *secured > taken[k] { *secured } else { taken[k] };
                }
            }
        }
    }

    /// The best cell centre.
    fn coarse(&mut self, brief: &Brief<'_>, weights: &Weights, ground: &Ground) -> Option<(f64, f64)> {
        let reach = brief.horizon * SPEED;
        let (columns, rows) = (ground.span(brief.at.0, reach), ground.span(brief.at.1, reach));
        let Self { pois, window, time, worth, .. } = self;
        time.clear();
        for a in columns.clone() {
            time.extend(rows.clone().map(|b| time_there(brief, ground.centre((a, b)))));
        }
        worth.clear();
        worth.resize(time.len(), 0.0);
        if rows.is_empty() {
            return None;
        }
        let lines = worth.chunks_exact_mut(rows.len()).zip(time.chunks_exact(rows.len()));
        for (a, (worth, time)) in columns.clone().zip(lines) {
            // Cells whose centres are within 11 u of this one's, column by column.
            for (da, db) in
                [(0, 2), (1, 1), (1, 2), (1, 3), (2, 0), (2, 1), (2, 2), (2, 3), (2, 4), (3, 1), (3, 2), (3, 3), (4, 2)]
            {
                let at = window.place((a, rows.start), (da, db));
                let cells = window.weight[at..].iter().zip(&window.taken[at..]);
                for ((worth, time), (weight, taken)) in worth.iter_mut().zip(time).zip(cells) {
                    *worth += weight * positive(time - taken);
                }
            }
        }
        for prize in pois.iter() {
            let range = weights.reach_u;
            for a in clip(ground.span(prize.at.0, range), &columns) {
                for b in clip(ground.span(prize.at.1, range), &rows) {
                    let k = (a - columns.start) * rows.len() + b - rows.start;
                    if squared(ground.centre((a, b)), prize.at) <= range * range {
                        worth[k] += prize.weight * positive(time[k] - prize.taken);
                    }
                }
            }
        }
        // No place gains more than this by lying ahead (nor by how that is rounded).
        let most = 1.0 + weights.inertia * (1.0 + 1e-9);
        let mut best: Option<(f64, (f64, f64))> = None;
        let places = columns.flat_map(|a| rows.clone().map(move |b| (a, b)));
        for (cell, &worth) in places.zip(worth.iter()) {
            let bar = best.map_or(0.0, |b| b.0);
            if worth * most <= bar {
                continue;
            }
            let place = ground.centre(cell);
            let worth = worth * ahead(brief, weights, place);
            if worth > bar {
                best = Some((worth, place));
            }
        }
        best.map(|(_, place)| place)
    }

    /// The best point on a grid of 1 u around the best cell and around the present target.
    fn refine(&self, brief: &Brief<'_>, weights: &Weights, ground: &Ground, coarse: (f64, f64)) -> (f64, f64) {
        let mut best = (-1.0, coarse);
        for (middle, kept) in [(Some(coarse), false), (brief.kept, true)] {
            let Some(middle) = middle else { continue };
            let grid = FineGrid::new(brief, ground, middle);
            let worth = self.worth_of(&grid, weights, ground, middle);
            for i in 0..FINE {
                for j in 0..FINE {
                    let mut worth = worth[i][j];
                    if kept {
                        worth *= 1.0 + weights.hysteresis;
                        if (i, j) == (FINE / 2, FINE / 2) {
                            worth *= 1.0 + weights.hysteresis;
                        }
                    }
                    if worth > best.0 {
                        best = (worth, (grid.x[i], grid.y[j]));
                    }
                }
            }
        }
        best.1
    }

    /// What the points of a fine grid around `middle` are worth.
    fn worth_of(&self, grid: &FineGrid, weights: &Weights, ground: &Ground, middle: (f64, f64)) -> [[f64; LINE]; FINE] {
        let mut worth = [[0.0; LINE]; FINE];
        // Only prizes that some point of the grid can win.
        let limit = COVERAGE_U.max(EXPLORE_U) + 1.5 * (FINE / 2) as f64;
        for prize in self.pois.iter().filter(|p| squared(p.at, middle) <= limit * limit) {
            grid.add(prize, &mut worth, |d2| {
                let past = positive((d2.sqrt() - weights.sure_u) / (COVERAGE_U - weights.sure_u));
                if d2 <= COVERAGE_U * COVERAGE_U { 1.0 - 0.8 * past } else { 0.0 }
            });
        }
        let window = &self.window;
        for a in clip(ground.span(middle.0, limit), &window.columns) {
            for b in clip(ground.span(middle.1, limit), &window.rows) {
                let (at, k) = (ground.centre((a, b)), window.of((a, b)));
                let prize = Prize { at, weight: window.weight[k], taken: window.taken[k] };
                if prize.weight > 0.0 && squared(at, middle) <= limit * limit {
                    grid.add(&prize, &mut worth, |d2| if d2 <= EXPLORE_U * EXPLORE_U { 1.0 } else { 0.0 });
                }
            }
        }
        worth
    }
}

/// Points along a side of the fine grid, and numbers to a line of it: whole vectors.
const FINE: usize = 7;
const LINE: usize = 8;

/// Points 1 u apart.
struct FineGrid {
    x: [f64; FINE],
    y: [f64; LINE],
    /// Steps that are left there.
    time: [[f64; LINE]; FINE],
}

impl FineGrid {
    fn new(brief: &Brief<'_>, ground: &Ground, middle: (f64, f64)) -> Self {
        // Closer to the edge there is nothing to win.
        let inside = |v: f64| v.clamp(2.0, ground.side_u() - 2.0);
        let aside = |k: usize| k as f64 - (FINE / 2) as f64;
        let x = std::array::from_fn(|i| inside(middle.0 + aside(i)));
        let y = std::array::from_fn(|j| inside(middle.1 + aside(j)));
        let time = x.map(|x| y.map(|y| time_there(brief, (x, y))));
        Self { x, y, time }
    }

    /// Adds a prize's worth to every point; `share` is that part of it which counts at a
    /// squared distance.
    #[inline]
    fn add(&self, prize: &Prize, worth: &mut [[f64; LINE]; FINE], share: impl Fn(f64) -> f64) {
        let &Prize { at, weight, taken } = prize;
        let dy2 = self.y.map(|y| (y - at.1) * (y - at.1));
        for ((x, time), worth) in self.x.iter().zip(&self.time).zip(worth) {
            let dx2 = (x - at.0) * (x - at.0);
            for ((dy2, time), worth) in dy2.iter().zip(time).zip(worth) {
                *worth += weight * positive(time - taken) * share(dx2 + dy2);
            }
        }
    }
}

/// Most steps that claims on a place secure: claims whose target is within `range` of it.
fn taken(claims: &[(f64, (f64, f64))], at: (f64, f64), range: f64) -> f64 {
    claims.iter().filter(|(_, t)| squared(*t, at) <= range * range).fold(0.0f64, |most, (g, _)| most.max(*g))
}

/// A number, or 0 below 0.
#[inline]
fn positive(v: f64) -> f64 {
    if v > 0.0 { v } else { 0.0 }
}

/// Steps that a claim secures, weighted by its age and its UAV's rank.
fn secured(claim: &Claim, brief: &Brief<'_>, weights: &Weights) -> f64 {
    let flight = (distance(claim.at, claim.target) / SPEED - claim.age).max(0.0);
    let rank = if claim.junior { weights.junior_claim } else { 1.0 };
    rank * libm::exp(-claim.age / CLAIM_FADES) * (brief.horizon - flight).max(0.0)
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

/// Replaces each x, at most 0, by eˣ: `libm::exp` to the bit, in a form without branches.
fn exponentials(values: &mut [f64]) {
    /// Adding and taking away 1.5·2⁵² rounds to a whole number.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const P: [f64; 5] = [
        1.666_666_666_666_660_2e-1,
        -2.777_777_777_701_559_3e-3,
        6.613_756_321_437_934e-5,
        -1.653_390_220_546_525_2e-6,
        4.138_136_797_057_238_5e-8,
    ];
    // Beyond this the result would be subnormal.
    if values.iter().any(|&x| x < -700.0) {
        values.iter_mut().for_each(|x| *x = libm::exp(*x));
        return;
    }
    for value in values {
        let x = *value;
        // Whole part of x/ln 2 − ½ towards zero, or what libm takes near zero.
        let quotient = std::f64::consts::LOG2_E * x - 0.5;
        let rounded = (quotient + ROUND) - ROUND;
        let towards_zero = if rounded < quotient { rounded + 1.0 } else { rounded };
        let near = if x > -f64::from_bits(0x3fd6_2e43_0000_0000) { 0.0 } else { -1.0 };
        let n = if x > -f64::from_bits(0x3ff0_a2b2_0000_0000) { near } else { towards_zero };
        let (high, low) = (x - n * LN2_HIGH, n * LN2_LOW);
        let r = high - low;
        let z = r * r;
        let c = r - z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * P[4]))));
        let y = 1.0 + (r * c / (2.0 - c) - low + high);
        let power = f64::from_bits((n + (ROUND + 1023.0)).to_bits() << 52);
        *value = if x > -f64::from_bits(0x3e30_0001_0000_0000) { 1.0 + x } else { y * power };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn exponentials_are_libms(far in 0.0f64..1000.0, near in 0.0f64..2.0, power in 0i32..60) {
            let mut values = [-far.min(700.0), -near, -near * f64::powi(0.5, power), -0.0, 0.0];
            let exact = values.map(libm::exp);
            exponentials(&mut values);
            prop_assert_eq!(values.map(f64::to_bits), exact.map(f64::to_bits));
            let mut one = [-far];
            exponentials(&mut one);
            prop_assert_eq!(one[0].to_bits(), libm::exp(-far).to_bits());
        }
    }
}
