//! The paper's own observation (section 3.1.2): id and position in binary, velocity, and maps
//! of the PoIs and UAVs around.
//!
//! | index | what | value |
//! |---|---|---|
//! | 0 + k | bit k of the own id, k = 0..7 | 0 or 1 |
//! | 8 + k | bit k of the own x position in whole u, k = 0..7 | 0 or 1 |
//! | 16 + k | bit k of the own y position | 0 or 1 |
//! | 24, 25 | own velocity | v / 4 u/step |
//! | 26 + 27 (row + 13) + column + 13 | PoIs in view around this many u north and east | how many |
//! | 755 + 19 (row + 9) + column + 9 | neighbours around this many times 2 u north and east | how many |
//!
//! Nearly all of these numbers are zero, so an observation is the list of those that are one;
//! an index that is listed twice counts two. `docs/observation-cells.md` has the details.

use super::form::BuildObservation;
use super::nearest::insert_sorted;
use super::neighbours::{COMMUNICATION_RANGE, MAX_NEIGHBOURS, Neighbour};
use super::poi::OBSERVATION_RANGE;
use super::scale::scaled;
use super::scene::Scene;
use crate::geometry::{COMMUNICATION_RANGE_U, OBSERVATION_RANGE_U, SPEED_CAP_U, TICKS_PER_U, Vec2, div_round};
use heapless::Vec;

/// Identifies this form of the observation in actor files.
pub const ID: u16 = 100;
/// PoIs that an observation holds at most (the nearest).
pub const MAX_POIS: usize = 80;
/// Ones that an observation holds at most.
pub const MAX_ACTIVE: usize = 3 * BITS + MAX_POIS + MAX_NEIGHBOURS;
/// Index of the velocity: east, then north.
pub const VELOCITY: usize = 3 * BITS;

/// Bits of the id and of a coordinate.
const BITS: usize = 8;
/// Side of a cell of the neighbours' map, u.
const NEIGHBOUR_CELL_U: i32 = 2;
/// The maps reach from minus this many cells to plus this many.
const POI_REACH: i32 = OBSERVATION_RANGE_U;
const NEIGHBOUR_REACH: i32 = COMMUNICATION_RANGE_U / NEIGHBOUR_CELL_U;
const POI_MAP: usize = VELOCITY + 2;
const NEIGHBOUR_MAP: usize = POI_MAP + map_len(POI_REACH);
/// Numbers that this form stands for.
pub const LEN: usize = NEIGHBOUR_MAP + map_len(NEIGHBOUR_REACH);

const fn map_len(reach: i32) -> usize {
    let side = 2 * reach as usize + 1;
    side * side
}

/// One observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    velocity: [i8; 2],
    count: u8,
    /// The first `count` are in use, the others zero.
    active: [u16; MAX_ACTIVE],
}

impl Cells {
    /// From its velocity and its ones; those beyond [`MAX_ACTIVE`] and indices that are not of
    /// ones are left out.
    #[must_use]
    pub fn new(velocity: [i8; 2], ones: impl IntoIterator<Item = u16>) -> Self {
        let mut cells = Self { velocity: velocity.map(|v| v.max(-127)), ..Self::ZERO };
        let known = |i: &u16| usize::from(*i) < LEN && !(VELOCITY..POI_MAP).contains(&usize::from(*i));
        for (slot, one) in cells.active.iter_mut().zip(ones.into_iter().filter(known)) {
            *slot = one;
            cells.count += 1;
        }
        cells
    }

    /// Numbers [`VELOCITY`] and the one behind it, in 1/127.
    #[must_use]
    pub const fn velocity(&self) -> [i8; 2] {
        self.velocity
    }

    /// Indices of the ones. A number is as large as its index is often here.
    #[must_use]
    pub fn active(&self) -> &[u16] {
        self.active.get(..usize::from(self.count)).unwrap_or_default()
    }
}

const _: () = assert!(MAX_ACTIVE <= u8::MAX as usize && LEN <= u16::MAX as usize);

/// A PoI in view: distance squared, then offset. In this order the nearest are kept.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct NearPoi {
    d2: u32,
    offset: Vec2,
}

impl BuildObservation for Cells {
    const ID: u16 = ID;
    const LEN: usize = LEN;
    const ZERO: Self = Self { velocity: [0; 2], count: 0, active: [0; MAX_ACTIVE] };

    fn build(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Self {
        let mut nearest: Vec<NearPoi, MAX_POIS> = Vec::new();
        for offset in pois.into_iter().map(|p| p - scene.own.position) {
            if let Some(d2) = offset.within(OBSERVATION_RANGE) {
                insert_sorted(&mut nearest, NearPoi { d2, offset }, NearPoi::lt);
            }
        }
        let own = &scene.own;
        // Of an id the lower bits.
        let numbers = [(0, scene.id as u8), (BITS, whole(own.position.x)), (2 * BITS, whole(own.position.y))];
        let bits = numbers
            .into_iter()
            .flat_map(|(first, n)| (0..BITS).filter(move |k| n >> k & 1 == 1).map(move |k| (first + k) as u16));
        let pois = nearest.iter().map(|p| cell::<POI_REACH, 1>(POI_MAP, p.offset));
        let near = |n: &Neighbour| cell::<NEIGHBOUR_REACH, NEIGHBOUR_CELL_U>(NEIGHBOUR_MAP, n.offset);
        let neighbours = scene.neighbours.as_slice().iter().map(near);
        let speed = scaled::<{ SPEED_CAP_U * TICKS_PER_U }>;
        Self::new([speed(own.velocity.x), speed(own.velocity.y)], bits.chain(pois).chain(neighbours))
    }
}

/// A coordinate in whole u, 0 to 255.
fn whole(ticks: i32) -> u8 {
    (ticks / TICKS_PER_U).clamp(0, 255) as u8
}

/// Index of the cell around `offset` in the map that begins at `first` and reaches `REACH` cells
/// of `SIDE_U`.
fn cell<const REACH: i32, const SIDE_U: i32>(first: usize, offset: Vec2) -> u16 {
    let axis = |t: i32| (div_round(t, SIDE_U * TICKS_PER_U).clamp(-REACH, REACH) + REACH) as u16;
    first as u16 + axis(offset.y) * (2 * REACH + 1) as u16 + axis(offset.x)
}

// Neighbours in range are on their map.
const _: () = assert!(COMMUNICATION_RANGE <= NEIGHBOUR_REACH * NEIGHBOUR_CELL_U * TICKS_PER_U);

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::neighbours::Neighbours;
    use super::*;
    use crate::geometry::State;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec as List;

    /// The module's table in plain numbers: all of them, the zeros too.
    fn naive(scene: &Scene<'_>, pois: &[Vec2]) -> List<f64> {
        let mut out = vec![0.0; LEN];
        let u = |t: i32| f64::from(t) / 1024.0;
        let bits = |out: &mut List<f64>, first: usize, n: u32| {
            (0..8).for_each(|k| out[first + k] = f64::from(n >> k & 1));
        };
        let (p, v) = (scene.own.position, scene.own.velocity);
        bits(&mut out, 0, u32::from(scene.id) % 256);
        bits(&mut out, 8, u(p.x).floor().clamp(0.0, 255.0) as u32);
        bits(&mut out, 16, u(p.y).floor().clamp(0.0, 255.0) as u32);
        let share = |t: i32| libm::round(127.0 * (u(t) / 4.0).clamp(-1.0, 1.0)) / 127.0;
        (out[24], out[25]) = (share(v.x), share(v.y));
        let d2 = |o: &Vec2| i64::from(o.x).pow(2) + i64::from(o.y).pow(2);
        let mut seen: List<Vec2> = pois.iter().map(|&q| q - p).filter(|o| d2(o) <= (13 * 1024i64).pow(2)).collect();
        seen.sort_by_key(|o| (d2(o), o.x, o.y));
        for o in seen.iter().take(80) {
            let (column, row) = (libm::round(u(o.x)) as i32, libm::round(u(o.y)) as i32);
            out[(26 + 27 * (row + 13) + column + 13) as usize] += 1.0;
        }
        for n in scene.neighbours.as_slice() {
            let (column, row) = (libm::round(u(n.offset.x) / 2.0) as i32, libm::round(u(n.offset.y) / 2.0) as i32);
            out[(755 + 19 * (row + 9) + column + 9) as usize] += 1.0;
        }
        out
    }

    fn dense(cells: &Cells) -> List<f64> {
        let mut out = vec![0.0; LEN];
        cells.active().iter().for_each(|&i| out[usize::from(i)] += 1.0);
        let [x, y] = cells.velocity();
        (out[VELOCITY], out[VELOCITY + 1]) = (f64::from(x) / 127.0, f64::from(y) / 127.0);
        out
    }

    fn near(range_u: i32) -> impl Strategy<Value = Vec2> {
        let t = range_u * TICKS_PER_U;
        // Halves too, so that distances repeat, limits are met exactly and roundings tie.
        let half = (-2 * range_u..=2 * range_u, -2 * range_u..=2 * range_u)
            .prop_map(|(x, y)| Vec2::from_ticks(x * TICKS_PER_U / 2, y * TICKS_PER_U / 2));
        prop_oneof![(-t..=t, -t..=t).prop_map(|(x, y)| Vec2::from_ticks(x, y)), half]
    }

    fn neighbour() -> impl Strategy<Value = Neighbour> {
        (any::<u16>(), near(20)).prop_map(|(id, offset)| Neighbour { id, offset, ..Neighbour::default() })
    }

    proptest! {
        #[test]
        fn cells_are_what_the_table_says(
            (x, y) in (-20_000..=300_000, -20_000..=300_000),
            velocity in near(5),
            id: u16,
            around in prop::collection::vec(neighbour(), 0..24),
            offsets in prop::collection::vec(near(15), 0..140),
        ) {
            let position = Vec2::from_ticks(x, y);
            let mut neighbours = Neighbours::new();
            around.iter().for_each(|&n| neighbours.insert(n));
            let scene =
                Scene { id, own: State { position, velocity }, tie: 3, half_side: 9, neighbours: &neighbours };
            let mut pois: List<_> = offsets.iter().map(|&o| position + o).collect();
            let cells = Cells::build(&scene, pois.iter().copied());
            prop_assert_eq!(dense(&cells), naive(&scene, &pois));
            // The order of the PoIs never shows.
            pois.reverse();
            prop_assert_eq!(cells, Cells::build(&scene, pois));
        }
    }

    #[test]
    fn what_is_no_one_is_left_out() {
        let many = [0, VELOCITY as u16, LEN as u16 - 1, LEN as u16, u16::MAX].into_iter().chain([7; 200]);
        let cells = Cells::new([-128, 127], many);
        assert_eq!((cells.velocity(), cells.active().len()), ([-127, 127], MAX_ACTIVE));
        assert_eq!(&cells.active()[..3], [0, LEN as u16 - 1, 7]);
        assert_eq!(LEN, 1116);
    }
}
