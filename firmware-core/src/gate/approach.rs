//! How fast the vehicle may approach the geofence.
//!
//! Each edge (and the circle) allows at distance `d` the approach speed `v` from which the vehicle, after its
//! reaction time `τ`, still stops before it: `v·τ + v²/2a = d`, so `v = √((aτ)² + 2ad) − aτ`. What is allowed by one
//! is a half-plane of velocities, what is allowed by all is convex. So a mix of two allowed velocities is allowed.

use super::boundary::{GeofenceView, MAX_BOUNDARIES};
use super::geofence::Geofence;
use super::inputs::Measured;
use super::limits::{Limits, LimitsError};
use super::vector::{Unit, Vector};
use heapless::Vec;

/// Passes over all bounds before the rest is scaled down.
const PASSES: usize = 4;

/// Deceleration to count on toward a boundary of this fence, mm/s².
///
/// In a corner two boundaries brake at once, which takes more by the sine of half its angle; along a circle a part goes
/// into the turn.
///
/// # Errors
/// The circle leaves less than half of the vehicle's deceleration.
pub(super) fn braking(limits: &Limits, fence: &Geofence) -> Result<u32, LimitsError> {
    let whole = limits.braking_mm_s2;
    let in_corner = (u64::from(whole) * u64::from(fence.half_angle())) >> 15;
    let mut braking = u32::try_from(in_corner).unwrap_or(whole).min(whole);
    if let Some(circle) = fence.outer_circle() {
        let speed = u64::from(limits.max_speed_mm_s);
        // v²/r <= a/2.
        let least = speed * speed * 2 / u64::from(whole.max(1)) + 1;
        let too_small = LimitsError::CircleTooSmall {
            radius_mm: circle.radius_mm,
            least_mm: u32::try_from(least).unwrap_or(u32::MAX),
        };
        let turning = (speed * speed).checked_div(circle.radius_mm.into()).ok_or(too_small)?;
        if u64::from(circle.radius_mm) < least {
            return Err(too_small);
        }
        braking = braking.min(whole.saturating_sub(u32::try_from(turning).unwrap_or(u32::MAX)));
    }
    Ok(braking.max(1))
}

/// The velocities that the fence allows at a place.
#[derive(Clone, Debug)]
pub(super) struct ApproachLimits {
    /// Directions and the greatest speed along each, mm/s; below 0 it must go the other way.
    boundaries: Vec<(Unit, i64), MAX_BOUNDARIES>,
}

impl ApproachLimits {
    /// At the measured state, `age_ms` later.
    pub fn new(fence: &Geofence, state: &Measured, age_ms: u32, braking: u32, limits: &Limits) -> Self {
        // The vehicle went on, and may have accelerated: ½at².
        let age = u64::from(age_ms.min(limits.stale_ms));
        let place = state.position + state.velocity.scaled(age as u32, 1000);
        let doubt_mm = (u64::from(limits.max_acceleration_mm_s2) * age * age / 2_000_000) as i64;
        let view = fence.view(place);
        let mut bounds = Self { boundaries: Vec::new() };
        if !view.inside {
            bounds.lead_back(&view, limits);
            return bounds;
        }
        for boundary in &view.boundaries {
            let room = boundary.distance_mm - i64::from(limits.fence_margin_mm) - doubt_mm;
            let bound = if room < 0 {
                // A metre too near: back at a metre a second.
                -(-room).min(i64::from(limits.inward_mm_s))
            } else {
                // What it is too fast already takes away from the room while it reacts.
                let speed = approach(room, braking, limits);
                let excess = (boundary.toward.along(state.velocity) - speed).max(0);
                approach((room - excess * i64::from(limits.reaction_ms) / 1000).max(0), braking, limits)
            };
            // There is room for every boundary.
            let _ = bounds.boundaries.push((boundary.toward, bound));
        }
        bounds
    }

    fn lead_back(&mut self, view: &GeofenceView, limits: &Limits) {
        if let Some(boundary) = view.nearest {
            let _ = self.boundaries.push((boundary.toward.reversed(), -i64::from(limits.inward_mm_s)));
        }
    }

    /// The velocity nearest to `velocity` that is allowed, or near to that. Zero where nothing else helps.
    pub fn clip(&self, velocity: Vector) -> Vector {
        let mut clipped = velocity;
        for _ in 0..PASSES {
            let before = clipped;
            for (toward, bound) in &self.boundaries {
                let excess = toward.along(clipped) - bound;
                if excess > 0 {
                    clipped = clipped - toward.times(excess + 1);
                }
            }
            if clipped == before {
                return clipped;
            }
        }
        self.scale_down(clipped)
    }

    /// Shortens a velocity until it is allowed. Standing still is, unless the vehicle is to go back.
    fn scale_down(&self, velocity: Vector) -> Vector {
        let mut scaled = velocity;
        for (toward, bound) in &self.boundaries {
            let speed = toward.along(scaled);
            if speed > *bound {
                let bound = u32::try_from(*bound).unwrap_or(0);
                scaled = scaled.scaled(bound, speed.unsigned_abs());
            }
        }
        scaled
    }
}

/// The approach speed from which the vehicle stops within `room` mm (0 or more) after its reaction time, mm/s.
fn approach(room: i64, braking: u32, limits: &Limits) -> i64 {
    let braking = u64::from(braking);
    let reacting = braking * u64::from(limits.reaction_ms) / 1000;
    let speed = (reacting * reacting + 2 * braking * room.unsigned_abs()).isqrt() - reacting;
    speed as i64
}
