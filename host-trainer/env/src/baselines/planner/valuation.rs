//! What covering a PoI or exploring a cell is worth to a UAV.

use super::inputs::{PlannerInputs, Weights};
use super::known::Claim;
use crate::plane::{distance, squared_distance};
use firmware_core::geometry::{COVERAGE_RANGE_U, SPEED_CAP_U};

/// Full speed, u/step.
pub(super) const SPEED: f64 = SPEED_CAP_U as f64;
/// Coverage range, u.
pub(super) const COVERAGE_U: f64 = COVERAGE_RANGE_U as f64;
/// An unseen cell counts for targets within this distance of its centre, u.
pub(super) const EXPLORATION_U: f64 = 11.0;
/// A claim secures the PoIs within this distance of its target, u: a little less than the coverage range, since no UAV
/// arrives exactly.
pub(super) const CLAIM_U: f64 = COVERAGE_U - 0.3;
/// Time constant with which the weight of an old claim decays, steps.
const CLAIM_DECAY_STEPS: f64 = 180.0;

/// Something whose steps of coverage count: a known PoI or an unseen cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ValueSource {
    /// Position, u.
    pub at: (f64, f64),
    /// Value of a step of being near.
    pub weight: f64,
    /// Steps that other UAVs' claims secure.
    pub claimed: f64,
}

/// Steps of coverage that a claim secures, weighted by its age and its UAV's priority.
pub(super) fn secured_steps(claim: &Claim, inputs: &PlannerInputs<'_>, weights: &Weights) -> f64 {
    let priority = if claim.yields { weights.yielding_claim } else { 1.0 };
    priority * libm::exp(-claim.age / CLAIM_DECAY_STEPS) * (inputs.horizon - claim.flight).max(0.0)
}

/// Most steps that a claim secures at a position; `claims` are their secured steps and targets, and they reach `range`.
pub(super) fn claimed_steps(claims: &[(f64, (f64, f64))], at: (f64, f64), range: f64) -> f64 {
    let within = claims.iter().filter(|(_, target)| squared_distance(*target, at) <= range * range);
    within.fold(0.0f64, |most, (steps, _)| most.max(*steps))
}

/// Steps of the horizon that remain at a target after the flight there.
pub(super) fn remaining_steps(inputs: &PlannerInputs<'_>, target: (f64, f64)) -> f64 {
    inputs.horizon - distance(target, inputs.at) / SPEED
}

/// Factor of a target for lying ahead. A UAV that hovers and sees nothing has a direction of its own, by its id, so
/// that a crowd spreads.
pub(super) fn heading_factor(inputs: &PlannerInputs<'_>, weights: &Weights, target: (f64, f64)) -> f64 {
    let (vx, vy) = inputs.velocity;
    let moving = vx * vx + vy * vy > 0.25;
    let far = distance(target, inputs.at);
    if weights.inertia == 0.0 || far <= 4.0 || !(moving || inputs.pois.is_empty()) {
        return 1.0;
    }
    let (ux, uy) = if moving {
        (vx / SPEED, vy / SPEED)
    } else {
        // Multiples of the golden angle spread evenly.
        let angle = 2.399_96 * inputs.id as f64;
        (libm::cos(angle), libm::sin(angle))
    };
    1.0 + weights.inertia * ((target.0 - inputs.at.0) * ux + (target.1 - inputs.at.1) * uy) / far
}

/// A number, or 0 below 0.
#[inline]
pub(super) fn positive(v: f64) -> f64 {
    if v > 0.0 { v } else { 0.0 }
}
