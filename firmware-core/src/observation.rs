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
//! | 11 | what the place where it is is worth | PoI-steps / 192 |
//! | 12 + k | the eight places around it, 4 u away on either axis | PoI-steps / 192 |
//! | 20 + k | the same 8 u away | PoI-steps / 192 |
//! | 28 | what the best place is worth, unseen PoIs and its lying ahead included | PoI-steps / 192 |
//! | 29, 30 | its offset | Δ / 18 u |
//! | 31, 32 | the same refined | Δ / 18 u |
//! | 33, 34 | change of velocity that flies there | / 8 u/step |
//! | 35 | what is covered there | n / 22 |
//! | 36 + 6 k | k-th nearest neighbour: present | 1 |
//! | … + 1, 2 | its offset | Δ / 18 u |
//! | … + 3, 4 | its velocity | v / 4 u/step |
//! | … + 5 | who yields: +1 when this UAV goes first, −1 when the neighbour does | ±1 |
//! | 72 + 4 k | k-th nearest PoI in view: present | 1 |
//! | … + 1, 2 | its offset | Δ / 13 u |
//! | … + 3 | covered by a neighbour that goes first, or only by ones that yield | 1 or ½ |
//!
//! Each number is stored as `round(127 · value)` clamped to ±127; absent
//! neighbours and PoIs are zeros. Directions are those of the action table. This form has the id [`ID`], which the actor file
//! repeats: an actor never meets an observation it was not trained on.

use crate::geometry::{
    COMMUNICATION_RANGE_U, COVERAGE_RANGE_U, OBSERVATION_RANGE_U, SPEED_CAP_U, State, TICKS_PER_U, Vec2, div_round,
};
use best::{WORTH, best, rings, worth};
use explore::outlooks;
use heapless::Vec;
use surroundings::{Free, push};

mod best;
pub mod cells;
mod explore;
mod form;
mod surroundings;

pub use form::Form;

/// Identifies this form of the observation in actor files.
pub const ID: u16 = 2;
/// Neighbours a UAV keeps (the nearest), and aggregates over.
pub const MAX_NEIGHBOURS: usize = 16;
/// Neighbours described in the observation (the nearest).
pub const SEEN_NEIGHBOURS: usize = 6;
/// PoIs described in the observation (the nearest).
pub const SEEN_POIS: usize = 22;
/// Numbers about the UAV itself.
const OWN: usize = 7;
/// Numbers about places to go.
const PLACES: usize = 4 + SPOTS + BEST;
/// Numbers about the best place.
const BEST: usize = 8;
/// Places whose worth is told.
const SPOTS: usize = 17;
/// Numbers a neighbour.
const PER_NEIGHBOUR: usize = 6;
/// Numbers a PoI.
const PER_POI: usize = 4;
/// Index of the wanted change of velocity, x and y, of 8 u/step.
pub const WANTED: usize = OWN + 4 + SPOTS + 5;
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
        ratio::<48>(seen.free.count),
    ]);
    let (places, rest) = rest.split_at_mut(PLACES);
    let (mean, push) = (seen.free.mean(), push(neighbours));
    let (drift, places) = places.split_at_mut(4);
    drift.copy_from_slice(&[
        ratio::<VIEW>(mean.x),
        ratio::<VIEW>(mean.y),
        ratio::<RANGE>(push.x),
        ratio::<RANGE>(push.y),
    ]);
    let worth = worth(&seen.nearest);
    let out_there = outlooks(own.position, half, &seen.nearest, scene.neighbours, |n| scene.goes_before(n));
    let best = best(&seen.nearest, &worth, &out_there, own.velocity);
    let (around, chosen) = places.split_at_mut(SPOTS);
    for (slot, worth) in around.iter_mut().zip(rings(&worth)) {
        *slot = ratio::<WORTH>(worth.into());
    }
    chosen.copy_from_slice(&[
        ratio::<WORTH>(best.worth),
        ratio::<RANGE>(best.coarse.x),
        ratio::<RANGE>(best.coarse.y),
        ratio::<RANGE>(best.fine.x),
        ratio::<RANGE>(best.fine.y),
        ratio::<{ 2 * SPEED_CAP_U * TICKS_PER_U }>(best.acceleration.x),
        ratio::<{ 2 * SPEED_CAP_U * TICKS_PER_U }>(best.acceleration.y),
        ratio::<{ 20 * SEEN_POIS as i32 }>(best.count),
    ]);
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
        slot.copy_from_slice(&[127, ratio::<VIEW>(offset.x), ratio::<VIEW>(offset.y), p.claim().code()]);
    }
    out
}

const VIEW: i32 = OBSERVATION_RANGE_U * TICKS_PER_U;

/// A PoI in view, packed so that one comparison orders by distance and then by offset:
/// d² (28 bits), Δx + 2¹⁴ and Δy + 2¹⁴ (15 bits each), claim (2 bits).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct SeenPoi(u64);

impl SeenPoi {
    const AXIS_BITS: u32 = 15;
    const BIAS: i32 = 1 << (Self::AXIS_BITS - 1);

    /// `offset` lies within the view and `d2` is its squared length.
    fn new(offset: Vec2, d2: u32, claim: Claim) -> Self {
        // |Δ| ≤ 13·1,024 < 2¹⁴, so both fit their bits, and d² < 2²⁸.
        let axis = |t: i32| u64::from((t + Self::BIAS).unsigned_abs());
        let order = (u64::from(d2) << Self::AXIS_BITS) | axis(offset.x);
        Self((((order << Self::AXIS_BITS) | axis(offset.y)) << 2) | claim as u64)
    }

    fn claim(self) -> Claim {
        match self.0 & 3 {
            0 => Claim::Nobody,
            1 => Claim::Junior,
            _ => Claim::Senior,
        }
    }

    fn offset(self) -> Vec2 {
        let axis = |shift: u32| ((self.0 >> shift) & ((1 << Self::AXIS_BITS) - 1)) as i32 - Self::BIAS;
        Vec2 { x: axis(2 + Self::AXIS_BITS), y: axis(2) }
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
        let claim = claim(offset, scene);
        if claim != Claim::Senior {
            seen.free.add(offset);
        }
        keep(&mut seen.nearest, SeenPoi::new(offset, d2, claim), SeenPoi::lt);
    }
    seen
}

const COVER: i32 = COVERAGE_RANGE_U * TICKS_PER_U;

/// Who else covers a PoI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Claim {
    /// No neighbour.
    Nobody = 0,
    /// A neighbour that yields.
    Junior = 1,
    /// A neighbour that goes first.
    Senior = 2,
}

impl Claim {
    /// The number in the observation.
    const fn code(self) -> i8 {
        match self {
            Self::Nobody => 0,
            Self::Junior => 64,
            Self::Senior => 127,
        }
    }
}

/// Who covers the PoI at this offset, which lies within the view.
fn claim(poi: Vec2, scene: &Scene<'_>) -> Claim {
    let mut claim = Claim::Nobody;
    for n in scene.neighbours.as_slice() {
        // On each axis at most (13 + 18)·1,024 = 31,744 ticks, so the sum of squares stays below 2³¹.
        let (x, y) = (poi.x - n.offset.x, poi.y - n.offset.y);
        if x * x + y * y <= COVER * COVER {
            if !scene.goes_before(n) {
                return Claim::Senior;
            }
            claim = Claim::Junior;
        }
    }
    claim
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
mod tests;
