//! What a UAV knows when it decides, as [`LEN`] numbers of one byte.
//!
//! | index | what | value |
//! |---|---|---|
//! | 0, 1 | own position, x and y | (p − side/2)/(side/2) |
//! | 2, 3 | own velocity | v / 4 u/step |
//! | 4 | own tie-breaker of the step | t / 127 |
//! | 5 | neighbours in range | n / 16 |
//! | 6 | free PoIs in view: those that no neighbour which goes first covers | n / 48 |
//! | 7, 8 | mean offset of the free PoIs in view | Δ / 13 u |
//! | 9, 10 | push away from neighbours: −Σ Δ·(1 − d²/18²) | / 18 u |
//! | 11 | free PoIs in coverage range | n / 24 |
//! | 12 + k | free PoIs in coverage range of the place 4 u away along direction k = 0..7 | n / 24 |
//! | 20 + k | the same 8 u away | n / 24 |
//! | 28 + 6 k | k-th nearest neighbour: present | 1 |
//! | … + 1, 2 | its offset | Δ / 18 u |
//! | … + 3, 4 | its velocity | v / 4 u/step |
//! | … + 5 | who yields: +1 when this UAV goes first, −1 when the neighbour does | ±1 |
//! | 64 + 4 k | k-th nearest PoI in view: present | 1 |
//! | … + 1, 2 | its offset | Δ / 13 u |
//! | … + 3 | covered by a neighbour that goes first | 0 or 1 |
//!
//! Each number is stored as `round(127 · value)` clamped to ±127; absent
//! neighbours and PoIs are zeros. Directions are those of the action table. This form has the id [`ID`], which the actor file
//! repeats: an actor never meets an observation it was not trained on.

use crate::geometry::{
    COMMUNICATION_RANGE_U, COVERAGE_RANGE_U, OBSERVATION_RANGE_U, SPEED_CAP_U, State, TICKS_PER_U, Vec2, div_round,
};
use heapless::Vec;
use places::{Free, SPOTS, push};

mod places;

/// Identifies this form of the observation in actor files.
pub const ID: u16 = 1;
/// Neighbours a UAV keeps (the nearest), and aggregates over.
pub const MAX_NEIGHBOURS: usize = 16;
/// Neighbours described in the observation (the nearest).
pub const SEEN_NEIGHBOURS: usize = 6;
/// PoIs described in the observation (the nearest).
pub const SEEN_POIS: usize = 24;
/// Numbers about the UAV itself.
const OWN: usize = 7;
/// Numbers about places to go.
const PLACES: usize = 4 + SPOTS;
/// Numbers a neighbour.
const PER_NEIGHBOUR: usize = 6;
/// Numbers a PoI.
const PER_POI: usize = 4;
/// Length of an observation.
pub const LEN: usize = OWN + PLACES + SEEN_NEIGHBOURS * PER_NEIGHBOUR + SEEN_POIS * PER_POI;

/// One observation.
pub type Observation = [i8; LEN];

/// A neighbour as seen from a UAV.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Neighbour {
    /// Its id.
    pub id: u16,
    /// Where it is, relative to the observer, ticks.
    pub offset: Vec2,
    /// Its velocity, ticks per step.
    pub velocity: Vec2,
    /// Its tie-breaker of the step.
    pub tie: i8,
}

impl Neighbour {
    /// Nearest first; equal distances by id. This order decides who is kept when
    /// there are more than [`MAX_NEIGHBOURS`].
    fn key(&self) -> (u32, u16) {
        // Only called for neighbours in range, where `within` is `Some`.
        (self.offset.within(RANGE).unwrap_or(u32::MAX), self.id)
    }
}

const RANGE: i32 = COMMUNICATION_RANGE_U * TICKS_PER_U;

/// Up to [`MAX_NEIGHBOURS`] neighbours, the nearest, nearest first.
#[derive(Clone, Debug, Default)]
pub struct Neighbours(Vec<Neighbour, MAX_NEIGHBOURS>);

impl Neighbours {
    /// No neighbours.
    #[must_use]
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Forgets them all.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Takes a neighbour in, if it is in communication range and among the nearest.
    pub fn offer(&mut self, n: Neighbour) {
        if n.offset.within(RANGE).is_none() {
            return;
        }
        let before = |a: &Neighbour, b: &Neighbour| a.key() < b.key();
        keep(&mut self.0, n, before);
    }

    /// The neighbours, nearest first.
    #[must_use]
    pub fn as_slice(&self) -> &[Neighbour] {
        &self.0
    }
}

/// What an observation is made of.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Own id: breaks equal tie-breakers.
    pub id: u16,
    /// Own measured state.
    pub own: State,
    /// Own tie-breaker of the step (see [`crate::random::tie_breaker`]).
    pub tie: i8,
    /// Half the side of the map, ticks; the map's corner is the origin.
    pub half_side: i32,
    /// Neighbours in range.
    pub neighbours: &'a Neighbours,
}

impl Scene<'_> {
    /// Whether this UAV goes before a neighbour: by the higher tie-breaker, and by the
    /// higher id where those are equal.
    fn goes_before(&self, n: &Neighbour) -> bool {
        (self.tie, self.id) > (n.tie, n.id)
    }
}

/// Builds the observation of a scene with the PoIs at `pois` (positions, ticks;
/// those out of view are left out, their order does not matter).
#[must_use]
pub fn observe(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Observation {
    let mut out = [0i8; LEN];
    let neighbours = scene.neighbours.as_slice();
    let seen = look(scene, pois);
    let own = &scene.own;
    let half = scene.half_side.clamp(1, HALF_SIDE_LIMIT);
    let (head, rest) = out.split_at_mut(OWN);
    head.copy_from_slice(&[
        ratio_of(own.position.x.saturating_sub(half), half),
        ratio_of(own.position.y.saturating_sub(half), half),
        ratio::<{ SPEED_CAP_U * TICKS_PER_U }>(own.velocity.x),
        ratio::<{ SPEED_CAP_U * TICKS_PER_U }>(own.velocity.y),
        scene.tie.max(-127),
        ratio::<{ MAX_NEIGHBOURS as i32 }>(neighbours.len() as i32),
        ratio::<{ 2 * SEEN_POIS as i32 }>(seen.free.count),
    ]);
    let (places, rest) = rest.split_at_mut(PLACES);
    let (mean, push) = (seen.free.mean(), push(neighbours));
    let (drift, gains) = places.split_at_mut(4);
    drift.copy_from_slice(&[
        ratio::<VIEW>(mean.x),
        ratio::<VIEW>(mean.y),
        ratio::<RANGE>(push.x),
        ratio::<RANGE>(push.y),
    ]);
    for (slot, &count) in gains.iter_mut().zip(&seen.free.gains) {
        *slot = ratio::<{ SEEN_POIS as i32 }>(count);
    }
    let (near, far) = rest.split_at_mut(SEEN_NEIGHBOURS * PER_NEIGHBOUR);
    for (slot, n) in near.chunks_exact_mut(PER_NEIGHBOUR).zip(neighbours) {
        let first = scene.goes_before(n);
        slot.copy_from_slice(&[
            127,
            ratio::<RANGE>(n.offset.x),
            ratio::<RANGE>(n.offset.y),
            ratio::<{ SPEED_CAP_U * TICKS_PER_U }>(n.velocity.x),
            ratio::<{ SPEED_CAP_U * TICKS_PER_U }>(n.velocity.y),
            if first { 127 } else { -127 },
        ]);
    }
    for (slot, p) in far.chunks_exact_mut(PER_POI).zip(&seen.nearest) {
        let offset = p.offset();
        slot.copy_from_slice(&[
            127,
            ratio::<VIEW>(offset.x),
            ratio::<VIEW>(offset.y),
            if p.claimed() { 127 } else { 0 },
        ]);
    }
    out
}

const VIEW: i32 = OBSERVATION_RANGE_U * TICKS_PER_U;

/// A PoI in view, packed so that one comparison orders by distance and then by offset:
/// d² (28 bits), Δx + 2¹⁴ and Δy + 2¹⁴ (15 bits each), claimed (1 bit).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct SeenPoi(u64);

impl SeenPoi {
    const AXIS_BITS: u32 = 15;
    const BIAS: i32 = 1 << (Self::AXIS_BITS - 1);

    /// `offset` lies within the view and `d2` is its squared length.
    fn new(offset: Vec2, d2: u32, claimed: bool) -> Self {
        // |Δ| ≤ 13·1,024 < 2¹⁴, so both fit their bits, and d² < 2²⁸.
        let axis = |t: i32| u64::from((t + Self::BIAS).unsigned_abs());
        let order = (u64::from(d2) << Self::AXIS_BITS) | axis(offset.x);
        Self((((order << Self::AXIS_BITS) | axis(offset.y)) << 1) | u64::from(claimed))
    }

    fn claimed(self) -> bool {
        self.0 & 1 == 1
    }

    fn offset(self) -> Vec2 {
        let axis = |shift: u32| ((self.0 >> shift) & ((1 << Self::AXIS_BITS) - 1)) as i32 - Self::BIAS;
        Vec2 { x: axis(1 + Self::AXIS_BITS), y: axis(1) }
    }
}

/// What a UAV makes of the PoIs in view.
struct Seen {
    /// The nearest, nearest first (equal distances by offset).
    nearest: Vec<SeenPoi, SEEN_POIS>,
    free: Free,
}

fn look(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Seen {
    let mut seen = Seen { nearest: Vec::new(), free: Free::default() };
    for p in pois {
        let offset = p - scene.own.position;
        let Some(d2) = offset.within(VIEW) else { continue };
        let claimed = is_claimed(offset, scene);
        if !claimed {
            seen.free.add(offset);
        }
        keep(&mut seen.nearest, SeenPoi::new(offset, d2, claimed), SeenPoi::lt);
    }
    seen
}

const COVER: i32 = COVERAGE_RANGE_U * TICKS_PER_U;

/// Whether a neighbour that goes first covers the PoI at this offset, which lies within the view.
fn is_claimed(poi: Vec2, scene: &Scene<'_>) -> bool {
    scene.neighbours.as_slice().iter().any(|n| {
        // On each axis at most (13 + 18)·1,024 = 31,744 ticks, so the sum of squares
        // stays below 2³¹.
        let (x, y) = (poi.x - n.offset.x, poi.y - n.offset.y);
        // Few are near enough, so who goes first is asked last.
        x * x + y * y <= COVER * COVER && !scene.goes_before(n)
    })
}

/// Takes `item` into `kept`, which is in order, behind those it is not before. When there is
/// no room the last of all drops out.
fn keep<T, const N: usize>(kept: &mut Vec<T, N>, item: T, before: impl Fn(&T, &T) -> bool) {
    if kept.is_full() {
        match kept.last() {
            Some(last) if before(&item, last) => kept.pop(),
            _ => return,
        };
    }
    // Not full, so this always succeeds. `Vec::insert` would do the rest, but for its panic branch.
    let _ = kept.push(item);
    for end in (2..=kept.len()).rev() {
        match kept.get_mut(..end) {
            Some([.., a, b]) if before(b, a) => core::mem::swap(a, b),
            _ => return,
        }
    }
}

/// `round(127·a/SCALE)` clamped to ±127, for |a| below 2^24 or so.
fn ratio<const SCALE: i32>(a: i32) -> i8 {
    let a = a.clamp(-SCALE, SCALE);
    div_round(a * 127, SCALE) as i8
}

/// [`ratio`] with a scale known at run time only, 1 to [`HALF_SIDE_LIMIT`].
fn ratio_of(a: i32, scale: i32) -> i8 {
    // |a·127| < 2^30.
    div_round(a.clamp(-scale, scale) * 127, scale) as i8
}

/// Greatest half side of a map, ticks (8,192 u); larger ones are taken as this.
pub const HALF_SIDE_LIMIT: i32 = 1 << 23;

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::geometry::MAP_SIDE_U;
    use proptest::prelude::*;
    use std::vec::Vec as List;

    const SIDE: i32 = MAP_SIDE_U as i32 * TICKS_PER_U;

    /// The module's table, word for word, in wide and floating numbers.
    fn naive(scene: &Scene<'_>, pois: &[Vec2]) -> List<i8> {
        let scaled = |v: i64, scale: i64| {
            let r = (v.abs() * 127 + scale / 2) / scale * v.signum();
            r.clamp(-127, 127) as i8
        };
        let d2 = |v: Vec2| i64::from(v.x).pow(2) + i64::from(v.y).pow(2);
        let u = |n: i32| i64::from(n) * i64::from(TICKS_PER_U);
        let neighbours = scene.neighbours.as_slice();
        let first = |n: &Neighbour| scene.tie > n.tie || scene.tie == n.tie && scene.id > n.id;
        let seniors: List<&Neighbour> = neighbours.iter().filter(|n| !first(n)).collect();
        let mut seen: List<(i64, Vec2, bool)> = pois
            .iter()
            .map(|&p| p - scene.own.position)
            .filter(|&o| d2(o) <= u(13).pow(2))
            .map(|o| (d2(o), o, seniors.iter().any(|n| d2(o - n.offset) <= u(10).pow(2))))
            .collect();
        seen.sort();
        let free: List<Vec2> = seen.iter().filter(|p| !p.2).map(|p| p.1).collect();
        let half = i64::from(scene.half_side);
        let (own, v) = (scene.own.position, scene.own.velocity);
        let mut out = List::from([
            scaled(i64::from(own.x) - half, half),
            scaled(i64::from(own.y) - half, half),
            scaled(v.x.into(), u(4)),
            scaled(v.y.into(), u(4)),
            scene.tie.max(-127),
            scaled(neighbours.len() as i64, 16),
            scaled(free.len() as i64, 48),
        ]);
        let mean = |axis: fn(&Vec2) -> i32| match free.len() as i64 {
            0 => 0,
            n => {
                let sum: i64 = free.iter().map(|o| i64::from(axis(o))).sum();
                scaled((sum.abs() + n / 2) / n * sum.signum(), u(13))
            }
        };
        out.extend([mean(|o| o.x), mean(|o| o.y)]);
        let push = |axis: fn(&Vec2) -> i32| {
            let part = |n: &Neighbour| {
                let share = ((u(18).pow(2) - d2(n.offset)) >> 20).clamp(0, 324);
                i64::from(axis(&n.offset)) * share
            };
            let sum: i64 = -neighbours.iter().map(part).sum::<i64>();
            scaled((sum.abs() + 162) / 324 * sum.signum(), u(18))
        };
        out.extend([push(|o| o.x), push(|o| o.y)]);
        let directions = [(10, 0), (7, -7), (0, -10), (-7, -7), (-10, 0), (-7, 7), (0, 10), (7, 7)];
        let along = |reach: i32| {
            directions.map(|(x, y)| {
                // Diagonals are √½ of the reach, in whole ticks.
                let diagonal = (reach * 7241 + 5120) / 10240;
                let t = |c: i32| match c.abs() {
                    10 => reach * c.signum(),
                    7 => diagonal * c.signum(),
                    _ => 0,
                };
                Vec2 { x: t(x), y: t(y) }
            })
        };
        let spots = [Vec2::default()].into_iter().chain(along(4096)).chain(along(8192));
        out.extend(spots.map(|s| scaled(free.iter().filter(|&&o| d2(o - s) <= u(10).pow(2)).count() as i64, 24)));
        for n in neighbours.iter().take(6) {
            let (o, v) = (n.offset, n.velocity);
            out.extend([127, scaled(o.x.into(), u(18)), scaled(o.y.into(), u(18))]);
            out.extend([scaled(v.x.into(), u(4)), scaled(v.y.into(), u(4)), if first(n) { 127 } else { -127 }]);
        }
        out.resize(64, 0);
        for &(_, o, claimed) in seen.iter().take(24) {
            out.extend([127, scaled(o.x.into(), u(13)), scaled(o.y.into(), u(13)), if claimed { 127 } else { 0 }]);
        }
        out.resize(LEN, 0);
        out
    }

    fn near(range_u: i32) -> impl Strategy<Value = Vec2> {
        let t = range_u * TICKS_PER_U;
        // Whole units too, so that distances repeat and limits are met exactly.
        let whole = (-range_u..=range_u, -range_u..=range_u)
            .prop_map(|(x, y)| Vec2::from_ticks(x * TICKS_PER_U, y * TICKS_PER_U));
        prop_oneof![(-t..=t, -t..=t).prop_map(|(x, y)| Vec2::from_ticks(x, y)), whole]
    }

    fn neighbour() -> impl Strategy<Value = Neighbour> {
        (0u16..30, near(20), near(4), any::<i8>()).prop_map(|(id, offset, velocity, tie)| Neighbour {
            id,
            offset,
            velocity,
            tie,
        })
    }

    proptest! {
        #[test]
        fn an_observation_is_what_the_table_says(
            (x, y) in (0..=SIDE, 0..=SIDE),
            velocity in near(5),
            (id, tie) in (0u16..30, any::<i8>()),
            around in prop::collection::vec(neighbour(), 0..24),
            offsets in prop::collection::vec(near(15), 0..70),
            turn in any::<prop::sample::Index>(),
        ) {
            let position = Vec2::from_ticks(x, y);
            let mut neighbours = Neighbours::new();
            around.iter().for_each(|&n| neighbours.offer(n));
            let own = State { position, velocity };
            let scene = Scene { id, own, tie, half_side: SIDE / 2, neighbours: &neighbours };
            let mut pois: List<_> = offsets.iter().map(|&o| position + o).collect();
            let got = observe(&scene, pois.iter().copied());
            prop_assert_eq!(&got[..], &naive(&scene, &pois)[..]);
            // Neither the order of the PoIs nor that of the neighbours shows.
            pois.reverse();
            let at = if pois.is_empty() { 0 } else { turn.index(pois.len()) };
            pois.rotate_left(at);
            prop_assert_eq!(got, observe(&scene, pois.iter().copied()));
            let mut again = Neighbours::new();
            around.iter().rev().for_each(|&n| again.offer(n));
            let distinct: std::collections::BTreeSet<_> = around.iter().map(Neighbour::key).collect();
            prop_assume!(distinct.len() == around.len());
            prop_assert_eq!(neighbours.as_slice(), again.as_slice());
        }

        #[test]
        fn the_nearest_neighbours_in_range_are_kept(around in prop::collection::vec(neighbour(), 0..40)) {
            let mut neighbours = Neighbours::new();
            around.iter().for_each(|&n| neighbours.offer(n));
            let mut expected = around;
            expected.retain(|n| n.offset.within(RANGE).is_some());
            expected.sort_by_key(Neighbour::key);
            expected.truncate(MAX_NEIGHBOURS);
            let keys = |l: &[Neighbour]| l.iter().map(Neighbour::key).collect::<List<_>>();
            prop_assert_eq!(keys(neighbours.as_slice()), keys(&expected));
        }

        #[test]
        fn packing_a_poi_loses_nothing(offset in near(13), claimed: bool) {
            prop_assume!(offset.within(VIEW).is_some());
            let p = SeenPoi::new(offset, offset.within(VIEW).unwrap_or(0), claimed);
            prop_assert_eq!((p.offset(), p.claimed()), (offset, claimed));
        }
    }
}
