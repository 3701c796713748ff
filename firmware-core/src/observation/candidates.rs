//! The value of candidate places around a UAV, on a grid of 4 u.
//!
//! The value of a place is the steps of coverage to be won there within a horizon: for each
//! PoI in reach of it the steps that are left after the flight, less those that a neighbour
//! which yields would win with it anyway. PoIs that a neighbour with priority covers count
//! nothing.

use super::poi::{CoveredBy, VisiblePoi};
use crate::geometry::{TICKS_PER_U, Vec2};

/// Places along a side of a grid.
pub(super) const SIDE: usize = 7;
/// Numbers in a line of a [`Grid`], the last one unused: whole vector registers.
pub(super) const LINE: usize = 8;
/// Row and column of the middle of a grid.
pub(super) const MIDDLE: i32 = SIDE as i32 / 2;
/// Distance of neighbouring places, ticks.
pub(super) const SPACING: i32 = 4 * TICKS_PER_U;

/// Steps are counted in 64ths.
pub(super) const STEP: i16 = 64;
/// How far ahead coverage is counted.
pub(super) const HORIZON: i16 = 8 * STEP;
/// What a neighbour that yields would win with a PoI that it covers: 1.88 steps.
const WON_BY_YIELDING: i16 = 120;
/// Within this distance of a place a PoI counts, ticks: 9.84 u.
const REACH: i32 = 10_076;

/// Greatest value in an observation: that of 24 PoIs without a flight.
pub(super) const MAX_VALUE: i32 = HORIZON as i32 * 24;

/// Squares of distances are compared in 1/16 u²: two axes of at most 25 u fit 16 bits.
pub(super) const fn square(ticks: i32) -> i16 {
    ((ticks * ticks) >> 16) as i16
}

/// A number for each place, rows from south to north.
pub(super) type Grid = [[i16; LINE]; SIDE];

/// What is fixed about each place.
pub(super) struct Places {
    /// What the flight to it leaves of the horizon.
    left: Grid,
    /// Its direction as a unit vector in 64ths, for those more than 4 u away.
    pub(super) directions: [[(i8, i8); SIDE]; SIDE],
}

/// Of every place of the grid.
pub(super) static PLACES: Places = {
    let mut places = Places { left: [[0; LINE]; SIDE], directions: [[(0, 0); SIDE]; SIDE] };
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
                places.directions[row][column] = ((x * unit / far) as i8, (y * unit / far) as i8);
            }
            column += 1;
        }
        row += 1;
    }
    places
};

/// The offset of a place of a grid, ticks.
pub(super) const fn grid_offset(row: usize, column: usize, spacing: i32) -> Vec2 {
    Vec2 { x: (column as i32 - MIDDLE) * spacing, y: (row as i32 - MIDDLE) * spacing }
}

/// Squared distances of a coordinate from the lines of a grid around the origin.
pub(super) fn squares<const N: usize>(coordinate: i32, spacing: i32) -> [i16; N] {
    core::array::from_fn(|k| square(coordinate - (k as i32 - MIDDLE) * spacing))
}

/// Values of the places, 64ths of a PoI-step.
pub(super) fn candidate_values(pois: &[VisiblePoi]) -> Grid {
    let mut values = [[0i16; LINE]; SIDE];
    for poi in pois {
        let yielded = match poi.covered_by() {
            CoveredBy::Priority => continue,
            CoveredBy::Yielding => WON_BY_YIELDING,
            CoveredBy::Nobody => 0,
        };
        let at = poi.offset();
        let (dx, dy) = (squares::<LINE>(at.x, SPACING), squares::<SIDE>(at.y, SPACING));
        for ((line, left), dy) in values.iter_mut().zip(&PLACES.left).zip(dy) {
            for ((value, left), dx) in line.iter_mut().zip(left).zip(dx) {
                // At most 22 PoIs of 512. Flights are shorter than 8 steps less what is yielded.
                let won = left - yielded;
                *value += if dx + dy <= square(REACH) { won } else { 0 };
            }
        }
    }
    values
}

/// Values of the middle, of the eight places around it, and of the eight 8 u away, each from
/// east clockwise.
pub(super) const fn ring_values(values: &Grid) -> [i16; 17] {
    let [_, south2, south, middle, north, north2, _] = values;
    let ([_, sww, _, ss, _, see, ..], [_, nww, _, nn, _, nee, ..]) = (south2, north2);
    let ([_, _, sw, s, se, ..], [_, _, nw, n, ne, ..]) = (south, north);
    let [_, ww, w, here, e, ee, ..] = middle;
    [*here, *e, *se, *s, *sw, *w, *nw, *n, *ne, *ee, *see, *ss, *sww, *ww, *nww, *nn, *nee]
}
