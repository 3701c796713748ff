//! The choice of a target: the most valuable cell, refined to 1 u.

use super::exponential::exponentials;
use super::fine_grid::{FINE, FineGrid, LINE};
use super::inputs::{PlannerInputs, Weights};
use super::local_map::{CellColumn, LocalMap};
use super::prior_map::PriorMap;
use super::valuation::{
    CLAIM_U, COVERAGE_U, EXPLORATION_U, SPEED, ValueSource, claimed_steps, heading_factor, positive, remaining_steps,
    secured_steps,
};
use crate::plane::squared_distance;
use core::ops::Range;
use firmware_core::geometry::OBSERVATION_RANGE_U;

/// Selects targets; holds the working space of a selection.
#[derive(Clone, Debug, Default)]
pub(super) struct TargetSelector {
    /// Secured steps and target of each claim.
    claims: Vec<(f64, (f64, f64))>,
    pois: Vec<ValueSource>,
    local_map: LocalMap,
    /// Density of known PoIs in a column of cells.
    density: Vec<f64>,
    /// Seen cells of a column.
    explored: Vec<bool>,
    /// Remaining steps and value of each candidate cell.
    remaining: Vec<f64>,
    value: Vec<f64>,
}

impl TargetSelector {
    /// The most valuable target, u; `None` when no target has any value. `fill_column` fills in a column of cells from
    /// what the UAV knows.
    pub(super) fn select(
        &mut self,
        inputs: &PlannerInputs<'_>,
        weights: &Weights,
        map: &PriorMap,
        fill_column: impl FnMut(CellColumn<'_>),
    ) -> Option<(f64, f64)> {
        self.claims.clear();
        self.claims.extend(inputs.claims.iter().map(|c| (secured_steps(c, inputs, weights), c.target)));
        self.pois.clear();
        for p in inputs.pois {
            let claimed = claimed_steps(&self.claims, p.at, CLAIM_U);
            self.pois.push(ValueSource { at: p.at, weight: p.weight, claimed });
        }
        self.value_unseen_cells(inputs, weights, map, fill_column);
        let cell = self.best_cell(inputs, weights, map)?;
        Some(self.refine(inputs, weights, map, cell))
    }

    /// Estimates the value of the cells that no UAV has seen.
    fn value_unseen_cells(
        &mut self,
        inputs: &PlannerInputs<'_>,
        weights: &Weights,
        map: &PriorMap,
        mut fill_column: impl FnMut(CellColumn<'_>),
    ) {
        let reach = inputs.horizon * SPEED + EXPLORATION_U;
        let (columns, rows) = (map.span(inputs.at.0, reach), map.span(inputs.at.1, reach));
        self.local_map.reset(columns.clone(), rows.clone());
        let Self { claims, local_map, density, explored, .. } = self;
        density.resize(rows.len(), 0.0);
        explored.resize(rows.len(), false);
        let near_known = weights.near_known;
        let trust = (3.0 * inputs.unknown).min(1.0);
        for a in columns {
            fill_column(CellColumn { a, rows: rows.clone(), density, explored });
            density.iter_mut().for_each(|d| *d = -*d / weights.near_known_scale);
            exponentials(density);
            let at = local_map.index((a, rows.start));
            let (weight, claimed) = (&mut local_map.weight[at..], &mut local_map.claimed[at..]);
            for (k, b) in rows.clone().enumerate() {
                let estimate = weights.prior * map.expected_pois((a, b)) * inputs.unknown
                    + near_known * (1.0 - density[k]) * trust;
                let value = inputs.estimate_factor * estimate;
                weight[k] = if !explored[k] && value >= 1e-4 { value } else { 0.0 };
            }
            for (secured, target) in claims.iter() {
                for (k, b) in rows.clone().enumerate() {
                    let range = f64::from(OBSERVATION_RANGE_U);
                    let near = squared_distance(*target, map.centre((a, b))) <= range * range;
                    claimed[k] = if near && *secured > claimed[k] { *secured } else { claimed[k] };
                }
            }
        }
    }

    /// The centre of the most valuable cell.
    fn best_cell(&mut self, inputs: &PlannerInputs<'_>, weights: &Weights, map: &PriorMap) -> Option<(f64, f64)> {
        let reach = inputs.horizon * SPEED;
        let (columns, rows) = (map.span(inputs.at.0, reach), map.span(inputs.at.1, reach));
        let Self { pois, local_map, remaining, value, .. } = self;
        remaining.clear();
        for a in columns.clone() {
            remaining.extend(rows.clone().map(|b| remaining_steps(inputs, map.centre((a, b)))));
        }
        value.clear();
        value.resize(remaining.len(), 0.0);
        if rows.is_empty() {
            return None;
        }
        let lines = value.chunks_exact_mut(rows.len()).zip(remaining.chunks_exact(rows.len()));
        for (a, (value, remaining)) in columns.clone().zip(lines) {
            // Cells whose centres are within 11 u of this one's, column by column.
            for (da, db) in
                [(0, 2), (1, 1), (1, 2), (1, 3), (2, 0), (2, 1), (2, 2), (2, 3), (2, 4), (3, 1), (3, 2), (3, 3), (4, 2)]
            {
                let at = local_map.index_from((a, rows.start), (da, db));
                let cells = local_map.weight[at..].iter().zip(&local_map.claimed[at..]);
                for ((value, remaining), (weight, claimed)) in value.iter_mut().zip(remaining).zip(cells) {
                    *value += weight * positive(remaining - claimed);
                }
            }
        }
        for poi in pois.iter() {
            let range = weights.reach_u;
            for a in clip(map.span(poi.at.0, range), &columns) {
                for b in clip(map.span(poi.at.1, range), &rows) {
                    let k = (a - columns.start) * rows.len() + b - rows.start;
                    if squared_distance(map.centre((a, b)), poi.at) <= range * range {
                        value[k] += poi.weight * positive(remaining[k] - poi.claimed);
                    }
                }
            }
        }
        // Upper bound of the heading factor, rounding included.
        let most = 1.0 + weights.inertia * (1.0 + 1e-9);
        let mut best: Option<(f64, (f64, f64))> = None;
        let cells = columns.flat_map(|a| rows.clone().map(move |b| (a, b)));
        for (cell, &value) in cells.zip(value.iter()) {
            let to_beat = best.map_or(0.0, |b| b.0);
            if value * most <= to_beat {
                continue;
            }
            let centre = map.centre(cell);
            let value = value * heading_factor(inputs, weights, centre);
            if value > to_beat {
                best = Some((value, centre));
            }
        }
        best.map(|(_, centre)| centre)
    }

    /// The best target on a grid of 1 u around the best cell and around the present target.
    fn refine(&self, inputs: &PlannerInputs<'_>, weights: &Weights, map: &PriorMap, cell: (f64, f64)) -> (f64, f64) {
        let mut best = (-1.0, cell);
        for (middle, is_present_target) in [(Some(cell), false), (inputs.present_target, true)] {
            let Some(middle) = middle else { continue };
            let grid = FineGrid::new(inputs, map, middle);
            let values = self.values_on(&grid, weights, map, middle);
            for (i, line) in values.iter().enumerate() {
                for (j, &value) in line.iter().take(FINE).enumerate() {
                    let mut value = value;
                    if is_present_target {
                        value *= 1.0 + weights.hysteresis;
                        if (i, j) == (FINE / 2, FINE / 2) {
                            value *= 1.0 + weights.hysteresis;
                        }
                    }
                    if value > best.0 {
                        best = (value, (grid.x[i], grid.y[j]));
                    }
                }
            }
        }
        best.1
    }

    /// The values of the targets of a fine grid around `middle`.
    fn values_on(&self, grid: &FineGrid, weights: &Weights, map: &PriorMap, middle: (f64, f64)) -> [[f64; LINE]; FINE] {
        let mut values = [[0.0; LINE]; FINE];
        // Only what some target of the grid can reach.
        let limit = COVERAGE_U.max(EXPLORATION_U) + 1.5 * (FINE / 2) as f64;
        for poi in self.pois.iter().filter(|p| squared_distance(p.at, middle) <= limit * limit) {
            grid.add(poi, &mut values, |d2| {
                let beyond_sure = positive((d2.sqrt() - weights.sure_u) / (COVERAGE_U - weights.sure_u));
                if d2 <= COVERAGE_U * COVERAGE_U { 1.0 - 0.8 * beyond_sure } else { 0.0 }
            });
        }
        let local_map = &self.local_map;
        for a in clip(map.span(middle.0, limit), &local_map.columns) {
            for b in clip(map.span(middle.1, limit), &local_map.rows) {
                let (at, k) = (map.centre((a, b)), local_map.index((a, b)));
                let cell = ValueSource { at, weight: local_map.weight[k], claimed: local_map.claimed[k] };
                if cell.weight > 0.0 && squared_distance(at, middle) <= limit * limit {
                    let limit = EXPLORATION_U * EXPLORATION_U;
                    grid.add(&cell, &mut values, |d2| if d2 <= limit { 1.0 } else { 0.0 });
                }
            }
        }
        values
    }
}

/// The part of `a` that lies in `b`.
fn clip(a: Range<usize>, b: &Range<usize>) -> Range<usize> {
    let start = a.start.clamp(b.start, b.end);
    start..a.end.clamp(start, b.end)
}
