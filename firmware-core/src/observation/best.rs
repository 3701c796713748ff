//! What places around a UAV are worth, and the best of them.
//!
//! A place is worth the steps of coverage to be won there within a horizon: for each PoI in
//! reach of it the steps that are left after the flight, less those that a neighbour which
//! yields would win with it anyway. PoIs that a neighbour which goes first covers count
//! nothing. Places lie on a grid of 4 u; the best one is refined on a grid of 1 u.

use super::explore;
use super::{COVER, Claim, SeenPoi};
use crate::geometry::{SPEED_CAP_U, TICKS_PER_U, Vec2, div_round};

/// Places along a side of either grid, and numbers to a line: whole vectors.
const SIDE: usize = 7;
const LINE: usize = 8;
const MIDDLE: i32 = SIDE as i32 / 2;
/// Distance of neighbouring places, ticks: coarse and fine.
const COARSE: i32 = 4 * TICKS_PER_U;
const FINE: i32 = TICKS_PER_U;

/// Steps are counted in 64ths.
const STEP: i16 = 64;
/// How far ahead it looks.
const HORIZON: i16 = 8 * STEP;
/// What a neighbour that yields wins with a PoI that it covers: 1.88 steps.
const YIELDED: i16 = 120;
/// Within this distance of a coarse place a PoI counts, ticks: 9.84 u.
const REACH: i32 = 10_076;
/// Within these distances of a fine place, ticks, a PoI counts 5, 3 and 1: nobody arrives to the
/// inch.
const SURE: [i16; 3] = [square(8_909), square(9_574), square(COVER)];
/// Times that, what a PoI counts that a neighbour which yields covers, and one that nobody covers.
const SHARED: i16 = 3;
const WHOLE: i16 = 4;

/// No bonus for lying ahead is greater, in 1/1024: 5 · 64 · √2 · 8192 / 2048, for a velocity of twice
/// the cap on both axes.
const MOST_AHEAD: i32 = 1811;

/// Greatest worth: all PoIs in view, at once.
pub(super) const WORTH: i32 = HORIZON as i32 * 24;

/// Squares of distances are compared in 1/16 u²: two axes of at most 25 u fit 16 bits.
const fn square(ticks: i32) -> i16 {
    ((ticks * ticks) >> 16) as i16
}

type Grid = [[i16; LINE]; SIDE];

/// Flight time to each coarse place, and the direction of those more than 4 u away in 64ths.
struct Places {
    left: Grid,
    ahead: [[(i8, i8); SIDE]; SIDE],
}

static PLACES: Places = {
    let mut places = Places { left: [[0; LINE]; SIDE], ahead: [[(0, 0); SIDE]; SIDE] };
    let mut row = 0;
    while row < SIDE {
        let mut column = 0;
        while column < SIDE {
            let (x, y) = (column as i32 - MIDDLE, row as i32 - MIDDLE);
            // Units of 4 u: one takes a step.
            let square = (x * x + y * y) as u32;
            let far = (square * STEP as u32 * STEP as u32).isqrt() as i32;
            places.left[row][column] = HORIZON - far as i16;
            if square > 1 {
                let unit = STEP as i32 * STEP as i32;
                places.ahead[row][column] = ((x * unit / far) as i8, (y * unit / far) as i8);
            }
            column += 1;
        }
        row += 1;
    }
    places
};

/// The offset of a place, ticks.
const fn offset(row: usize, column: usize, spacing: i32) -> Vec2 {
    Vec2 { x: (column as i32 - MIDDLE) * spacing, y: (row as i32 - MIDDLE) * spacing }
}

/// Squared distances of a coordinate from the lines of a grid around the origin.
fn squares<const N: usize>(coordinate: i32, spacing: i32) -> [i16; N] {
    core::array::from_fn(|k| square(coordinate - (k as i32 - MIDDLE) * spacing))
}

/// What the coarse places are worth.
pub(super) fn worth(pois: &[SeenPoi]) -> Grid {
    let mut worth = [[0i16; LINE]; SIDE];
    for poi in pois {
        let taken = match poi.claim() {
            Claim::Senior => continue,
            Claim::Junior => YIELDED,
            Claim::Nobody => 0,
        };
        let at = poi.offset();
        let (dx, dy) = (squares::<LINE>(at.x, COARSE), squares::<SIDE>(at.y, COARSE));
        for ((line, left), dy) in worth.iter_mut().zip(&PLACES.left).zip(dy) {
            for ((worth, left), dx) in line.iter_mut().zip(left).zip(dx) {
                // At most 22 PoIs of 512. Flights are shorter than 8 steps less what is yielded.
                let won = left - taken;
                *worth += if dx + dy <= square(REACH) { won } else { 0 };
            }
        }
    }
    worth
}

/// Worth of the place itself, of the eight around it, and of the eight 8 u away.
pub(super) const fn rings(worth: &Grid) -> [i16; 17] {
    let [_, south2, south, middle, north, north2, _] = worth;
    let ([_, sww, _, ss, _, see, ..], [_, nww, _, nn, _, nee, ..]) = (south2, north2);
    let ([_, _, sw, s, se, ..], [_, _, nw, n, ne, ..]) = (south, north);
    let [_, ww, w, here, e, ee, ..] = middle;
    [*here, *e, *se, *s, *sw, *w, *nw, *n, *ne, *ee, *see, *ss, *sww, *ww, *nww, *nn, *nee]
}

/// The best place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Best {
    /// What the coarse place is worth, 64ths of a PoI-step, with a bonus for lying ahead.
    pub(super) worth: i32,
    /// The coarse place, relative to the UAV.
    pub(super) coarse: Vec2,
    /// The fine place, relative to the UAV.
    pub(super) fine: Vec2,
    /// What changes the velocity to the one that flies there.
    pub(super) acceleration: Vec2,
    /// What is covered there: 20 for a PoI that is certain.
    pub(super) count: i32,
}

/// The best place; zeros when none is worth anything.
pub(super) fn best(pois: &[SeenPoi], worth: &Grid, outlooks: &[i16], velocity: Vec2) -> Best {
    let mut best = Best::default();
    // Not bound to the cap here: a beacon or estimate may say more.
    let cap = 2 * SPEED_CAP_U * TICKS_PER_U;
    let (vx, vy) = (velocity.x.clamp(-cap, cap), velocity.y.clamp(-cap, cap));
    let moving = vx * vx + vy * vy > TICKS_PER_U * TICKS_PER_U / 4;
    let mut on_grid = false;
    let mut consider = |worth: i16, (ux, uy): (i32, i32), place: Vec2, of_grid: bool| {
        let worth = i32::from(worth);
        // Most places are out of the question whatever their bonus.
        if worth * (1024 + MOST_AHEAD) <= best.worth << 10 {
            return;
        }
        // 0.6 of the cosine at full speed, in 1/1024, for a unit vector in 64ths.
        let along = if moving { ((ux * vx + uy * vy) * 5) >> 11 } else { 0 };
        let worth = (worth * (1024 + along)) >> 10;
        if worth > best.worth {
            (best.worth, best.coarse, on_grid) = (worth, place, of_grid);
        }
    };
    for (row, (line, units)) in worth.iter().zip(&PLACES.ahead).enumerate() {
        for (column, (&worth, &(ux, uy))) in line.iter().zip(units).enumerate() {
            consider(worth, (ux.into(), uy.into()), offset(row, column, COARSE), true);
        }
    }
    for (&worth, &unit) in outlooks.iter().zip(&explore::AROUND) {
        consider(worth, (unit.0 / 16, unit.1 / 16), explore::place(unit), false);
    }
    if best.worth > 0 {
        best.fine = best.coarse;
        if on_grid {
            (best.fine, best.count) = refine(pois, best.coarse);
        }
        let wanted = within_cap(best.fine);
        best.acceleration = Vec2 { x: wanted.x - vx, y: wanted.y - vy };
    }
    best
}

/// The best of the fine places around a coarse one, and what is covered there.
fn refine(pois: &[SeenPoi], coarse: Vec2) -> (Vec2, i32) {
    let mut count = [[0i16; LINE]; SIDE];
    for poi in pois {
        let weight = match poi.claim() {
            Claim::Senior => continue,
            Claim::Junior => SHARED,
            Claim::Nobody => WHOLE,
        };
        let at = poi.offset() - coarse;
        // None of the fine places reaches beyond.
        const LIMIT: i32 = COVER + MIDDLE * FINE;
        if at.x.abs() > LIMIT || at.y.abs() > LIMIT {
            continue;
        }
        let (dx, dy) = (squares::<LINE>(at.x, FINE), squares::<SIDE>(at.y, FINE));
        for (line, dy) in count.iter_mut().zip(dy) {
            for (count, dx) in line.iter_mut().zip(dx) {
                let within = |k: usize| i16::from(dx + dy <= SURE[k]);
                *count += weight * (2 * within(0) + 2 * within(1) + within(2));
            }
        }
    }
    let mut best = (0, coarse, 0);
    for (row, line) in count.iter().enumerate() {
        for (column, &count) in line.iter().take(SIDE).enumerate() {
            let count = i32::from(count);
            if count * (i32::from(HORIZON / STEP) * COARSE) <= best.0 {
                continue;
            }
            let step = offset(row, column, FINE);
            let at = Vec2 { x: coarse.x + step.x, y: coarse.y + step.y };
            // What is left of the horizon, in ticks of flight; the distance to within 4 %.
            let (x, y) = (at.x.abs(), at.y.abs());
            let far = (1007 * x.max(y) + 441 * x.min(y)) >> 10;
            let worth = count * (i32::from(HORIZON / STEP) * COARSE - far);
            if worth > best.0 {
                best = (worth, at, count);
            }
        }
    }
    (best.1, best.2)
}

/// The vector, shortened to the speed cap.
fn within_cap(v: Vec2) -> Vec2 {
    const CAP: i32 = SPEED_CAP_U * TICKS_PER_U;
    // At most 15 u an axis.
    let far = (v.x * v.x + v.y * v.y).unsigned_abs().isqrt() as i32;
    if far <= CAP { v } else { Vec2 { x: div_round(v.x * CAP, far), y: div_round(v.y * CAP, far) } }
}
