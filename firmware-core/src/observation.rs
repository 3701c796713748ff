//! What a UAV knows when it decides, as [`LEN`] numbers of one byte.
//!
//! | index | what | value |
//! |---|---|---|
//! | 0, 1 | own position, x and y | (p − side/2)/(side/2) |
//! | 2, 3 | own velocity | v / 4 u/step |
//! | 4 | own tie-breaker of the step | t / 127 |
//! | 5 | neighbours in range | n / 16 |
//! | 6 | PoIs in view | n / 48 |
//! | 7 | PoIs in view that no neighbour covers | n / 48 |
//! | 8 + 6 k | k-th nearest neighbour: present | 1 |
//! | … + 1, 2 | its offset | Δ / 18 u |
//! | … + 3, 4 | its velocity | v / 4 u/step |
//! | … + 5 | who yields: +1 when this UAV goes first, −1 when the neighbour does | ±1 |
//! | 44 + 4 k | k-th nearest PoI in view: present | 1 |
//! | … + 1, 2 | its offset | Δ / 13 u |
//! | … + 3 | covered by a neighbour | 0 or 1 |
//!
//! Each number is stored as `round(127 · value)` clamped to ±127; absent
//! neighbours and PoIs are zeros. This form has the id [`ID`], which the actor file
//! repeats: an actor never meets an observation it was not trained on.

use crate::geometry::{
    COMMUNICATION_RANGE_U, COVERAGE_RANGE_U, OBSERVATION_RANGE_U, SPEED_CAP_U, State, TICKS_PER_U, Vec2, div_round,
};
use heapless::Vec;

/// Identifies this form of the observation in actor files.
pub const ID: u16 = 1;
/// Neighbours a UAV keeps (the nearest), and aggregates over.
pub const MAX_NEIGHBOURS: usize = 16;
/// Neighbours described in the observation (the nearest).
pub const SEEN_NEIGHBOURS: usize = 6;
/// PoIs described in the observation (the nearest).
pub const SEEN_POIS: usize = 24;
/// Numbers about the UAV itself.
const OWN: usize = 8;
/// Numbers a neighbour.
const PER_NEIGHBOUR: usize = 6;
/// Numbers a PoI.
const PER_POI: usize = 4;
/// Length of an observation.
pub const LEN: usize = OWN + SEEN_NEIGHBOURS * PER_NEIGHBOUR + SEEN_POIS * PER_POI;

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
        let key = n.key();
        let at = self.0.iter().position(|o| key < o.key()).unwrap_or(self.0.len());
        if at == MAX_NEIGHBOURS {
            return;
        }
        if self.0.is_full() {
            self.0.pop();
        }
        // Not full and `at <= len`, so this always succeeds.
        let _ = self.0.insert(at, n);
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

/// Builds the observation of a scene with the PoIs at `pois` (positions, ticks;
/// those out of view are left out, their order does not matter).
#[must_use]
pub fn observe(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Observation {
    let mut out = [0i8; LEN];
    let neighbours = scene.neighbours.as_slice();
    let (nearest, in_view, unclaimed) = nearest_pois(scene, pois);
    let own = &scene.own;
    let half = scene.half_side.clamp(1, HALF_SIDE_LIMIT);
    let (head, rest) = out.split_at_mut(OWN);
    let values = [
        ratio_of(own.position.x.saturating_sub(half), half),
        ratio_of(own.position.y.saturating_sub(half), half),
        ratio::<{ SPEED_CAP_U * TICKS_PER_U }>(own.velocity.x),
        ratio::<{ SPEED_CAP_U * TICKS_PER_U }>(own.velocity.y),
        scene.tie.max(-127),
        ratio::<{ MAX_NEIGHBOURS as i32 }>(neighbours.len() as i32),
        ratio::<{ 2 * SEEN_POIS as i32 }>(in_view),
        ratio::<{ 2 * SEEN_POIS as i32 }>(unclaimed),
    ];
    head.copy_from_slice(&values);
    let (near, far) = rest.split_at_mut(SEEN_NEIGHBOURS * PER_NEIGHBOUR);
    for (slot, n) in near.chunks_exact_mut(PER_NEIGHBOUR).zip(neighbours) {
        let first = (scene.tie, scene.id) > (n.tie, n.id);
        slot.copy_from_slice(&[
            127,
            ratio::<RANGE>(n.offset.x),
            ratio::<RANGE>(n.offset.y),
            ratio::<{ SPEED_CAP_U * TICKS_PER_U }>(n.velocity.x),
            ratio::<{ SPEED_CAP_U * TICKS_PER_U }>(n.velocity.y),
            if first { 127 } else { -127 },
        ]);
    }
    for (slot, p) in far.chunks_exact_mut(PER_POI).zip(&nearest) {
        slot.copy_from_slice(&[
            127,
            ratio::<VIEW>(p.offset.x),
            ratio::<VIEW>(p.offset.y),
            if p.claimed { 127 } else { 0 },
        ]);
    }
    out
}

const VIEW: i32 = OBSERVATION_RANGE_U * TICKS_PER_U;

struct SeenPoi {
    d2: u32,
    offset: Vec2,
    claimed: bool,
}

/// The nearest PoIs in view, nearest first (equal distances by offset), the number in
/// view and the number of those that no neighbour covers.
fn nearest_pois(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> (Vec<SeenPoi, SEEN_POIS>, i32, i32) {
    let mut nearest = Vec::new();
    let (mut in_view, mut unclaimed) = (0, 0);
    for p in pois {
        let offset = p - scene.own.position;
        let Some(d2) = offset.within(VIEW) else { continue };
        let claimed = is_claimed(offset, scene.neighbours.as_slice());
        in_view += 1;
        unclaimed += i32::from(!claimed);
        insert_nearest(&mut nearest, SeenPoi { d2, offset, claimed });
    }
    (nearest, in_view, unclaimed)
}

fn is_claimed(poi: Vec2, neighbours: &[Neighbour]) -> bool {
    neighbours.iter().any(|n| (poi - n.offset).within(COVERAGE_RANGE_U * TICKS_PER_U).is_some())
}

fn insert_nearest(nearest: &mut Vec<SeenPoi, SEEN_POIS>, p: SeenPoi) {
    let before = |o: &SeenPoi| (p.d2, p.offset) < (o.d2, o.offset);
    if nearest.is_full() {
        match nearest.last() {
            Some(last) if before(last) => nearest.pop(),
            _ => return,
        };
    }
    let at = nearest.iter().rposition(|o| !before(o)).map_or(0, |i| i + 1);
    // Not full and `at <= len`, so this always succeeds.
    let _ = nearest.insert(at, p);
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
