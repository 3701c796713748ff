//! The target: the best of the candidate places, on the grid and beyond the view, refined on a
//! grid of 1 u.

use super::candidates::{Grid, HORIZON, LINE, MIDDLE, PLACES, SIDE, SPACING, STEP, grid_offset, square, squares};
use super::exploration::{UNIT_VECTORS, place_offset};
use super::poi::{COVERAGE_RANGE, CoveredBy, VisiblePoi};
use crate::geometry::{SPEED_CAP_U, TICKS_PER_U, Vec2, div_round};

/// Distance of neighbouring places of the refined grid, ticks.
const FINE_SPACING: i32 = TICKS_PER_U;
/// Within these distances of a refined place, ticks, a PoI counts 5, 3 and 1: the nearer it is
/// to the limit of coverage, the less certain it is that the UAV will cover it once there.
const CERTAINTY_RANGES: [i16; 3] = [square(8_909), square(9_574), square(COVERAGE_RANGE)];
/// That is multiplied by this for a PoI that only neighbours which yield cover …
const YIELDED_WEIGHT: i16 = 3;
/// … and by this for one that nobody covers.
const UNCOVERED_WEIGHT: i16 = 4;

/// No bonus for lying ahead is greater, in 1/1024: 5 · 64 · √2 · 8192 / 2048, for a velocity of twice
/// the cap on both axes.
const MAX_AHEAD_BONUS: i32 = 1811;

/// The target: the candidate place of greatest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Target {
    /// Value of the coarse place, 64ths of a PoI-step, with the bonus for lying ahead.
    pub(super) value: i32,
    /// The coarse place, relative to the UAV.
    pub(super) coarse: Vec2,
    /// The fine place, relative to the UAV.
    pub(super) fine: Vec2,
    /// The change of velocity that flies there, ticks per step.
    pub(super) velocity_change: Vec2,
    /// What is covered there: 20 for a PoI well inside coverage range, less near its limit.
    pub(super) covered: i32,
}

impl Target {
    /// The best of the candidate places of these values; zeros when none is of any value.
    pub(super) fn choose(pois: &[VisiblePoi], values: &Grid, exploration: &[i16], velocity: Vec2) -> Self {
        let mut best = Self::default();
        // Not bound to the cap here: a beacon or estimate may say more.
        let cap = 2 * SPEED_CAP_U * TICKS_PER_U;
        let (vx, vy) = (velocity.x.clamp(-cap, cap), velocity.y.clamp(-cap, cap));
        let moving = vx * vx + vy * vy > TICKS_PER_U * TICKS_PER_U / 4;
        let mut on_grid = false;
        let mut consider = |value: i16, (ux, uy): (i32, i32), place: Vec2, of_grid: bool| {
            let value = i32::from(value);
            // Most places are out of the question whatever their bonus.
            if value * (1024 + MAX_AHEAD_BONUS) <= best.value << 10 {
                return;
            }
            // 0.6 of the cosine at full speed, in 1/1024, for a unit vector in 64ths.
            let bonus = if moving { ((ux * vx + uy * vy) * 5) >> 11 } else { 0 };
            let value = (value * (1024 + bonus)) >> 10;
            if value > best.value {
                (best.value, best.coarse, on_grid) = (value, place, of_grid);
            }
        };
        for (row, (line, units)) in values.iter().zip(&PLACES.directions).enumerate() {
            for (column, (&value, &(ux, uy))) in line.iter().zip(units).enumerate() {
                consider(value, (ux.into(), uy.into()), grid_offset(row, column, SPACING), true);
            }
        }
        for (&value, &unit) in exploration.iter().zip(&UNIT_VECTORS) {
            consider(value, (unit.0 / 16, unit.1 / 16), place_offset(unit), false);
        }
        if best.value > 0 {
            best.fine = best.coarse;
            if on_grid {
                (best.fine, best.covered) = refine(pois, best.coarse);
            }
            let target_velocity = within_cap(best.fine);
            best.velocity_change = Vec2 { x: target_velocity.x - vx, y: target_velocity.y - vy };
        }
        best
    }
}

/// The best of the fine places around a coarse one, and what is covered there.
fn refine(pois: &[VisiblePoi], coarse: Vec2) -> (Vec2, i32) {
    let mut count = [[0i16; LINE]; SIDE];
    for poi in pois {
        let weight = match poi.covered_by() {
            CoveredBy::Priority => continue,
            CoveredBy::Yielding => YIELDED_WEIGHT,
            CoveredBy::Nobody => UNCOVERED_WEIGHT,
        };
        let at = poi.offset() - coarse;
        // None of the fine places reaches beyond.
        const LIMIT: i32 = COVERAGE_RANGE + MIDDLE * FINE_SPACING;
        if at.x.abs() > LIMIT || at.y.abs() > LIMIT {
            continue;
        }
        let (dx, dy) = (squares::<LINE>(at.x, FINE_SPACING), squares::<SIDE>(at.y, FINE_SPACING));
        for (line, dy) in count.iter_mut().zip(dy) {
            for (count, dx) in line.iter_mut().zip(dx) {
                let within = |k: usize| i16::from(dx + dy <= CERTAINTY_RANGES[k]);
                *count += weight * (2 * within(0) + 2 * within(1) + within(2));
            }
        }
    }
    let mut best = (0, coarse, 0);
    for (row, line) in count.iter().enumerate() {
        for (column, &count) in line.iter().take(SIDE).enumerate() {
            let count = i32::from(count);
            if count * (i32::from(HORIZON / STEP) * SPACING) <= best.0 {
                continue;
            }
            let step = grid_offset(row, column, FINE_SPACING);
            let at = Vec2 { x: coarse.x + step.x, y: coarse.y + step.y };
            // What is left of the horizon, in ticks of flight; the distance to within 4 %.
            let (x, y) = (at.x.abs(), at.y.abs());
            let far = (1007 * x.max(y) + 441 * x.min(y)) >> 10;
            let value = count * (i32::from(HORIZON / STEP) * SPACING - far);
            if value > best.0 {
                best = (value, at, count);
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
