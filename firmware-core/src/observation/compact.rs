//! Builds the compact observation.

use super::candidates::{MAX_VALUE, candidate_values, ring_values};
use super::exploration::exploration_values;
use super::form::BuildObservation;
use super::layout::{CANDIDATES, ID, LEN, OWN, Observation, PER_NEIGHBOUR, PER_POI, PLACES};
use super::layout::{DESCRIBED_NEIGHBOURS, DESCRIBED_POIS, SUMS};
use super::neighbours::{COMMUNICATION_RANGE, MAX_NEIGHBOURS};
use super::poi::{OBSERVATION_RANGE, VisiblePois};
use super::scale::{scaled, scaled_by};
use super::scene::{HALF_SIDE_LIMIT, Scene};
use super::separation::separation;
use super::target::Target;
use crate::geometry::{SPEED_CAP_U, TICKS_PER_U, Vec2};

/// The speed cap, ticks per step.
const SPEED_CAP: i32 = SPEED_CAP_U * TICKS_PER_U;

/// Builds the observation of a scene with the PoIs at `pois` (positions, ticks;
/// those out of view are left out, their order does not matter).
#[must_use]
pub fn observe(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Observation {
    let mut out = [0i8; LEN];
    let neighbours = scene.neighbours.as_slice();
    let visible = VisiblePois::new(scene, pois);
    let own = &scene.own;
    let half = scene.half_side.clamp(1, HALF_SIDE_LIMIT);
    let (head, rest) = out.split_at_mut(OWN);
    head.copy_from_slice(&[
        scaled_by(own.position.x.saturating_sub(half), half),
        scaled_by(own.position.y.saturating_sub(half), half),
        scaled::<SPEED_CAP>(own.velocity.x),
        scaled::<SPEED_CAP>(own.velocity.y),
        scene.tie.max(-127),
        scaled::<{ MAX_NEIGHBOURS as i32 }>(neighbours.len() as i32),
        scaled::<48>(visible.available.count),
    ]);
    let (places, rest) = rest.split_at_mut(PLACES);
    let (mean, away) = (visible.available.mean_offset(), separation(neighbours));
    let (sums, places) = places.split_at_mut(SUMS);
    sums.copy_from_slice(&[
        scaled::<OBSERVATION_RANGE>(mean.x),
        scaled::<OBSERVATION_RANGE>(mean.y),
        scaled::<COMMUNICATION_RANGE>(away.x),
        scaled::<COMMUNICATION_RANGE>(away.y),
    ]);
    let values = candidate_values(&visible.nearest);
    let exploration = exploration_values(scene, half, &visible.nearest);
    let target = Target::choose(&visible.nearest, &values, &exploration, own.velocity);
    let (around, chosen) = places.split_at_mut(CANDIDATES);
    for (slot, value) in around.iter_mut().zip(ring_values(&values)) {
        *slot = scaled::<MAX_VALUE>(value.into());
    }
    chosen.copy_from_slice(&[
        scaled::<MAX_VALUE>(target.value),
        scaled::<COMMUNICATION_RANGE>(target.coarse.x),
        scaled::<COMMUNICATION_RANGE>(target.coarse.y),
        scaled::<COMMUNICATION_RANGE>(target.fine.x),
        scaled::<COMMUNICATION_RANGE>(target.fine.y),
        scaled::<{ 2 * SPEED_CAP }>(target.velocity_change.x),
        scaled::<{ 2 * SPEED_CAP }>(target.velocity_change.y),
        scaled::<{ 20 * DESCRIBED_POIS as i32 }>(target.covered),
    ]);
    let (near, far) = rest.split_at_mut(DESCRIBED_NEIGHBOURS * PER_NEIGHBOUR);
    for (slot, n) in near.chunks_exact_mut(PER_NEIGHBOUR).zip(neighbours) {
        let has_priority = scene.has_priority_over(n);
        slot.copy_from_slice(&[
            127,
            scaled::<COMMUNICATION_RANGE>(n.offset.x),
            scaled::<COMMUNICATION_RANGE>(n.offset.y),
            scaled::<SPEED_CAP>(n.velocity.x),
            scaled::<SPEED_CAP>(n.velocity.y),
            if has_priority { 127 } else { -127 },
        ]);
    }
    for (slot, p) in far.chunks_exact_mut(PER_POI).zip(&visible.nearest) {
        let offset = p.offset();
        slot.copy_from_slice(&[
            127,
            scaled::<OBSERVATION_RANGE>(offset.x),
            scaled::<OBSERVATION_RANGE>(offset.y),
            p.covered_by().code(),
        ]);
    }
    out
}

impl BuildObservation for Observation {
    const ID: u16 = ID;
    const LEN: usize = LEN;
    const ZERO: Self = [0; LEN];

    fn build(scene: &Scene<'_>, pois: impl IntoIterator<Item = Vec2>) -> Self {
        observe(scene, pois)
    }
}
