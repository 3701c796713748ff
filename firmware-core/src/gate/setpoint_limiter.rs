//! From the setpoint that is desired to the nearest one within all limits.

use super::approach::ApproachLimits;
use super::inputs::Measured;
use super::limits::Limits;
use super::vector::{Vector, clamp};
use super::verdict::{Limited, Setpoint};

/// Halvings in search of the farthest allowed change of velocity.
const HALVINGS: u32 = 12;
/// What rounding may add to a change of velocity, mm/s.
pub const ROUNDING_MM_S: u32 = 2;

/// The setpoint that the actor or the gate itself desires.
#[derive(Clone, Copy, Debug)]
pub(super) struct DesiredSetpoint {
    pub velocity: Vector,
    /// Nothing when it only matters that the velocity is reached.
    pub acceleration: Option<Vector>,
    pub altitude_mm: i32,
}

/// The setpoint before, where the change of velocity begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreviousSetpoint {
    pub velocity: Vector,
    /// How long ago that was, ms.
    pub passed_ms: u32,
}

/// The setpoint nearest to the desired one.
///
/// Of limits that contradict each other the fence comes first, then the speed, then the acceleration.
pub(super) fn limit_setpoint(
    desired: DesiredSetpoint,
    previous: PreviousSetpoint,
    state: &Measured,
    bounds: &ApproachLimits,
    limits: &Limits,
) -> Setpoint {
    let mut limited = Limited::default();
    let capped = desired.velocity.shortened_to(limits.max_speed_mm_s);
    limited.speed = capped != desired.velocity;
    let goal = bounds.clip(capped);

    let going_on = previous.velocity.shortened_to(limits.max_speed_mm_s);
    let start = bounds.clip(going_on);
    limited.fence = goal != capped || start != going_on;
    let change = u64::from(limits.max_acceleration_mm_s2) * u64::from(previous.passed_ms.min(1000)) / 1000;
    let change = u32::try_from(change).unwrap_or(u32::MAX).saturating_add(ROUNDING_MM_S);
    let velocity = nearest(start, goal, previous.velocity, change);
    limited.acceleration = velocity != goal;
    let velocity = velocity.shortened_to(limits.max_speed_mm_s);

    // Without an acceleration of its own: what reaches the goal in the reaction time.
    let reaction = limits.reaction_ms.max(1);
    let reaching = |target: Vector| (target - velocity).scaled(1000, reaction.into());
    let forward = desired.acceleration.unwrap_or_else(|| reaching(goal));
    let ahead = velocity + forward.clamped(ACCELERATION_LIMIT).scaled(reaction, 1000);
    let allowed = bounds.clip(ahead);
    let forward = if allowed == ahead {
        forward
    } else {
        limited.fence = true;
        reaching(allowed)
    };
    let acceleration = forward.shortened_to(limits.max_acceleration_mm_s2);
    limited.acceleration |= acceleration != forward && desired.acceleration.is_some();

    let (altitude_mm, climb_mm_s) = climb(desired.altitude_mm, state.altitude_mm, limits);
    limited.altitude = altitude_mm != desired.altitude_mm;
    Setpoint { velocity, climb_mm_s, acceleration, altitude_mm, limited }
}

/// Beyond any acceleration, mm/s²; keeps products in 32 bits.
const ACCELERATION_LIMIT: i32 = 1_000_000;

/// The altitude inside the band, and the vertical speed that leads there: a metre a second for every metre.
pub(super) fn climb(desired_mm: i32, altitude_mm: i32, limits: &Limits) -> (i32, i32) {
    let target = desired_mm.max(limits.altitude_floor_mm).min(limits.altitude_ceiling_mm);
    (target, clamp(target.saturating_sub(altitude_mm), limits.climb_mm_s.cast_signed()))
}

/// The point on the way from `start` to `goal` that is nearest to `goal` and within `change` of `origin`; `start` when
/// there is none.
fn nearest(start: Vector, goal: Vector, origin: Vector, change: u32) -> Vector {
    if (goal - origin).within(change) {
        return goal;
    }
    let way = goal - start;
    let mut best = start;
    let (mut low, mut high) = (0, 1 << HALVINGS);
    while high - low > 1 {
        let middle = (low + high) / 2;
        let candidate = start + way.scaled(middle, 1 << HALVINGS);
        if (candidate - origin).within(change) {
            (low, best) = (middle, candidate);
        } else {
            high = middle;
        }
    }
    best
}
