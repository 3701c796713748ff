//! Monitors the inputs for everything that can be wrong with the vehicle, its connection and its telemetry.

use super::clock::age_ms;
use super::debounce::Debounce;
use super::geofence::Geofence;
use super::inputs::{FlightMode, Inputs, Measured};
use super::limits::{Limits, SwarmLoss};
use super::reason::Reason;
use super::vector::{POSITION_LIMIT_MM, RATE_LIMIT, Vector};

/// A vehicle that moves or should move at this speed cannot stay in one place, mm/s.
const MOVING_MM_S: u32 = 500;
/// Farther than this from where it was, it has moved, mm: more than the grain of any telemetry (11 mm).
const MOVED_MM: u32 = 50;

/// What the monitor looks at in one tick.
pub(super) struct MonitorInputs<'a> {
    pub inputs: &'a Inputs,
    pub now_ms: u32,
    /// For how long the vehicle's clock has stood still by the own computer's clock, ms.
    pub silence_ms: u32,
    /// Velocity that was last sent and still counts, mm/s.
    pub commanded: Vector,
    pub limits: &'a Limits,
    pub fence: &'a Geofence,
}

/// Every condition that is monitored.
#[derive(Clone, Debug)]
pub(super) struct Monitor {
    link: Debounce,
    heartbeat: Debounce,
    stale: Debounce,
    refused: Debounce,
    ekf: Debounce,
    gps: Debounce,
    sources: Debounce,
    frozen: Debounce,
    jumped: Debounce,
    altitude: Debounce,
    battery: Debounce,
    grounded: Debounce,
    outside: Option<u32>,
    fence_stuck: bool,
    height_doubted: bool,
    off_layer: bool,
    undecided: bool,
    swarm_incomplete: bool,
    swarm_lost: bool,
    last: Option<Measured>,
    /// Where the measured position began to stand still, and when.
    anchor: Option<(Vector, u32)>,
    standing: bool,
}

impl Monitor {
    /// Nothing is known to be well yet.
    pub const fn new() -> Self {
        Self {
            link: Debounce::RAISED,
            heartbeat: Debounce::RAISED,
            stale: Debounce::RAISED,
            refused: Debounce::CLEAR,
            ekf: Debounce::RAISED,
            gps: Debounce::RAISED,
            sources: Debounce::CLEAR,
            frozen: Debounce::CLEAR,
            jumped: Debounce::CLEAR,
            altitude: Debounce::CLEAR,
            battery: Debounce::CLEAR,
            grounded: Debounce::CLEAR,
            outside: None,
            fence_stuck: false,
            height_doubted: false,
            off_layer: false,
            undecided: true,
            swarm_incomplete: false,
            swarm_lost: false,
            last: None,
            anchor: None,
            standing: false,
        }
    }

    /// Takes in a tick.
    pub fn update(&mut self, tick: &MonitorInputs<'_>) {
        let MonitorInputs { inputs, now_ms: now, limits, .. } = *tick;
        let (confirm, clear) = (limits.confirm_ms, limits.clear_ms);
        let state = inputs.state.filter(is_in_range);
        let no_gps = limits.least_gps_fix > 0 && inputs.gps_fix.is_none_or(|fix| fix < limits.least_gps_fix);
        let low = inputs.battery_permille.is_some_and(|left| left <= limits.battery_permille);

        self.link.update(tick.silence_ms >= limits.link_wall_ms, now, 0, clear);
        self.heartbeat.update(is_older(inputs.heartbeat_ms, now, limits.heartbeat_ms), now, 0, clear);
        let measured_ms = state.map(|state| state.time_ms);
        let early = measured_ms.is_some_and(|then| age_ms(then, now) > limits.reorder_ms);
        self.stale.update(early || is_older(measured_ms, now, limits.stale_ms), now, 0, clear);
        self.refused.update(inputs.refused || state != inputs.state, now, 0, clear);
        self.ekf.update(!inputs.ekf_ok, now, confirm, clear);
        self.gps.update(no_gps, now, confirm, clear);
        self.sources.update(inputs.sources_disagree, now, confirm, clear);
        self.battery.update(low, now, limits.battery_confirm_ms, clear);
        self.grounded.update(!inputs.airborne, now, confirm, 0);
        (self.height_doubted, self.swarm_incomplete) = (inputs.height_doubted, inputs.swarm_incomplete);
        let decided = inputs.proposal.map(|proposal| proposal.decided_ms);
        self.undecided = is_older(decided, now, limits.decision_ms);
        self.swarm_lost = limits.swarm_loss == SwarmLoss::Hold && is_older(inputs.swarm_ms, now, limits.swarm_ms);
        if let Some(state) = state {
            self.check_motion(&state, tick);
        }
    }

    /// What is wrong with where the vehicle is.
    fn check_motion(&mut self, state: &Measured, tick: &MonitorInputs<'_>) {
        let MonitorInputs { now_ms: now, limits, .. } = *tick;
        self.jumped.update(self.jumped_too_far(state, limits), now, 0, limits.clear_ms);
        self.last = Some(*state);

        let standing = self.is_frozen(state, tick);
        self.frozen.update(standing, now, 0, limits.clear_ms);

        let depth = tick.fence.depth_mm(state.position);
        // Back inside by half the margin, so that a gust on the line does not make it chatter.
        let back = (limits.fence_margin_mm / 2).cast_signed();
        self.outside = match self.outside {
            _ if depth < 0 => Some(self.outside.unwrap_or(now)),
            Some(since) if depth < back => Some(since),
            _ => None,
        };
        self.fence_stuck = self.outside.is_some_and(|since| age_ms(now, since) >= limits.fence_stuck_ms);

        let slack = limits.altitude_slack_mm.cast_signed();
        let low = limits.altitude_floor_mm.saturating_sub(slack);
        let high = limits.altitude_ceiling_mm.saturating_add(slack);
        self.altitude.update(!(low..=high).contains(&state.altitude_mm), now, limits.confirm_ms, 0);
        // Back on it by half the distance, so that a gust does not make it chatter.
        let reach = if self.off_layer { limits.layer_mm / 2 } else { limits.layer_mm };
        self.off_layer = tick.inputs.proposal.is_some_and(|proposal| {
            let layer_mm = proposal.altitude_mm.max(limits.altitude_floor_mm).min(limits.altitude_ceiling_mm);
            state.altitude_mm.abs_diff(layer_mm) > reach
        });
    }

    /// Whether the vehicle moved farther since the last measurement than it can fly.
    fn jumped_too_far(&self, state: &Measured, limits: &Limits) -> bool {
        let (Some(last), Some(slack)) = (self.last, limits.jump_mm) else { return false };
        let passed_ms = u64::from(age_ms(state.time_ms, last.time_ms));
        // Half more than its greatest speed, for wind and overshoot.
        let flown = u64::from(limits.max_speed_mm_s) * 3 / 2 * passed_ms / 1000;
        let reach = u32::try_from(flown + u64::from(slack)).unwrap_or(u32::MAX);
        !(state.position - last.position).within(reach) || state.altitude_mm.abs_diff(last.altitude_mm) > reach
    }

    /// Whether the position has stood still for too long, by the times of the measurements: one that is only old
    /// tells nothing about that. Once it does, only moving shows the opposite.
    fn is_frozen(&mut self, state: &Measured, tick: &MonitorInputs<'_>) -> bool {
        let Some(frozen_ms) = tick.limits.frozen_ms else { return false };
        let (place, since) = *self.anchor.get_or_insert((state.position, state.time_ms));
        let moved = !(state.position - place).within(MOVED_MM);
        let moving = !state.velocity.within(MOVING_MM_S - 1) || !tick.commanded.within(MOVING_MM_S - 1);
        if moved || !(moving || self.standing) || !tick.inputs.airborne {
            (self.anchor, self.standing) = (Some((state.position, state.time_ms)), false);
        } else if age_ms(state.time_ms, since) >= frozen_ms {
            self.standing = true;
        }
        self.standing
    }

    /// The first cause to stop for.
    pub fn stop(&self) -> Option<Reason> {
        first([
            (self.link.is_raised(), Reason::LinkLost),
            (self.heartbeat.is_raised(), Reason::HeartbeatLost),
            (self.stale.is_raised(), Reason::StateStale),
            (self.refused.is_raised(), Reason::NumberRefused),
            (self.ekf.is_raised(), Reason::EkfUnhealthy),
            (self.gps.is_raised(), Reason::GpsLost),
            (self.sources.is_raised(), Reason::SourcesDisagree),
            (self.frozen.is_raised(), Reason::StateFrozen),
        ])
    }

    /// The first cause to hold for.
    pub fn hold(&self) -> Option<Reason> {
        first([
            (self.jumped.is_raised(), Reason::PositionJumped),
            (self.outside.is_some(), Reason::OutsideFence),
            (self.altitude.is_raised(), Reason::OutsideAltitude),
            (self.height_doubted, Reason::HeightDoubted),
            (self.off_layer, Reason::OffLayer),
            (self.undecided, Reason::NoDecision),
            (self.swarm_incomplete, Reason::SwarmIncomplete),
            (self.swarm_lost, Reason::SwarmLost),
        ])
    }

    /// The first cause to return home for.
    pub fn give_up(&self) -> Option<Reason> {
        first([(self.battery.is_raised(), Reason::BatteryLow), (self.fence_stuck, Reason::FenceStuck)])
    }

    /// What keeps the vehicle from being brought up.
    pub fn grounding(&self) -> Option<Reason> {
        let place =
            first([(self.jumped.is_raised(), Reason::PositionJumped), (self.outside.is_some(), Reason::OutsideFence)]);
        first([(self.battery.is_raised(), Reason::BatteryLow)]).or(self.stop()).or(place)
    }

    /// Whether the vehicle is on the ground for certain.
    pub const fn landed(&self) -> bool {
        self.grounded.is_raised()
    }

    /// Forgets how the vehicle moved: the next measurement is the first.
    pub const fn forget_motion(&mut self) {
        (self.last, self.anchor, self.standing) = (None, None, false);
        (self.outside, self.fence_stuck, self.off_layer) = (None, false, false);
    }
}

/// Whether the heartbeat tells of a mode that takes setpoints.
pub(super) const fn is_guided(mode: FlightMode) -> bool {
    matches!(mode, FlightMode::Guided)
}

fn first<const N: usize>(causes: [(bool, Reason); N]) -> Option<Reason> {
    causes.into_iter().find_map(|(holds, reason)| holds.then_some(reason))
}

/// Whether something came never, or longer ago than `limit_ms`.
fn is_older(then_ms: Option<u32>, now_ms: u32, limit_ms: u32) -> bool {
    then_ms.is_none_or(|then| age_ms(now_ms, then) > limit_ms)
}

/// Whether every number is one that the gate computes with.
fn is_in_range(state: &Measured) -> bool {
    state.position.clamped(POSITION_LIMIT_MM) == state.position
        && state.velocity.clamped(RATE_LIMIT) == state.velocity
        && state.altitude_mm.unsigned_abs() <= POSITION_LIMIT_MM.unsigned_abs()
        && state.climb_mm_s.unsigned_abs() <= RATE_LIMIT.unsigned_abs()
}
