//! The gate: phases of a flight, and the verdict at every tick.

use super::approach::{self, ApproachLimits};
use super::clock::{ClockStep, VehicleClock, age_ms};
use super::failsafe::FailsafeAction;
use super::geofence::Geofence;
use super::inputs::{FlightMode, Inputs, Measured, Request};
use super::limits::{Limits, LimitsError};
use super::monitor::{Monitor, MonitorInputs, is_guided};
use super::phase::Phase;
use super::reason::Reason;
use super::setpoint_limiter::{DesiredSetpoint, PreviousSetpoint, limit_setpoint};
use super::vector::Vector;
use super::verdict::{Setpoint, Verdict};

/// After this time without a setpoint the next one starts from the measured velocity, ms.
const STREAM_GAP_MS: u32 = 1000;

/// The gate of one UAV.
#[derive(Clone, Debug)]
pub struct Gate {
    limits: Limits,
    fence: Geofence,
    /// Deceleration to count on toward the fence, mm/s².
    braking: u32,
    clock: VehicleClock,
    monitor: Monitor,
    phase: Phase,
    /// When the phase began, on the vehicle's clock; nothing before that is heard.
    since_ms: Option<u32>,
    /// What the heartbeats have said since the operator asked.
    heartbeats: Heartbeats,
    /// Since when the vehicle is being stopped, on both clocks.
    stopping: Option<(u32, u32)>,
    /// Commands to return home that were given, and when the last one was.
    returns: (u8, u32),
    /// The last setpoint, and when it was given.
    sent: Option<(Setpoint, u32)>,
}

/// What the heartbeats have said since the operator asked.
#[derive(Clone, Copy, Debug, Default)]
struct Heartbeats {
    guided: bool,
    armed: bool,
}

impl Gate {
    /// A gate that waits for the operator.
    ///
    /// # Errors
    /// A setting out of its bounds, or a circular fence too small for the speed.
    pub fn new(limits: Limits, fence: Geofence) -> Result<Self, LimitsError> {
        limits.check()?;
        let braking = approach::braking(&limits, &fence)?;
        Ok(Self {
            limits,
            fence,
            braking,
            clock: VehicleClock::default(),
            monitor: Monitor::new(),
            phase: Phase::Idle(Reason::NotStarted),
            since_ms: None,
            heartbeats: Heartbeats::default(),
            stopping: None,
            returns: (0, 0),
            sent: None,
        })
    }

    /// Its settings.
    #[must_use]
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Its fence.
    #[must_use]
    pub const fn fence(&self) -> &Geofence {
        &self.fence
    }

    /// Where the flight stands.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// What may be sent now. To be asked at every telemetry message that moves the vehicle's clock, and at least every
    /// [`Limits::tick_ms`] by the own computer's clock when none comes.
    pub fn tick(&mut self, inputs: &Inputs) -> Verdict {
        let step = self.clock.advance(inputs.now_ms, inputs.wall_ms, &self.limits);
        if step != ClockStep::Steady {
            self.monitor = Monitor::new();
            self.sent = None;
        }
        self.apply(inputs.operator);
        let now = self.clock.now_ms(inputs.wall_ms, &self.limits);
        if let Some(now) = now {
            self.monitor.update(&MonitorInputs {
                inputs,
                now_ms: now,
                silence_ms: self.clock.silence_ms(inputs.wall_ms),
                commanded: self.commanded(now),
                limits: &self.limits,
                fence: &self.fence,
            });
        }
        // After the operator's request, which cannot have meant another vehicle.
        match step {
            ClockStep::Steady => {}
            ClockStep::Back => self.release(Reason::VehicleRestarted),
            ClockStep::Ahead => self.release(Reason::ClockJumped),
        }
        let verdict = now.map_or(self.unheard(), |now| self.decide(inputs, now));
        let now = now.unwrap_or(0);
        self.sent = match verdict.setpoint() {
            Some(setpoint) => Some((setpoint, now)),
            None => self.sent.filter(|(_, then)| age_ms(now, *then) <= STREAM_GAP_MS),
        };
        verdict
    }

    /// Carries out what the operator asks for.
    fn apply(&mut self, request: Option<Request>) {
        match request {
            None => {}
            Some(Request::Start) => {
                self.enter(Phase::BringUp);
                self.heartbeats = Heartbeats::default();
                self.monitor.forget_motion();
            }
            Some(Request::Release) => self.enter(Phase::Idle(Reason::OperatorReleased)),
            Some(Request::Return) => self.start_return(Reason::OperatorReturn),
        }
    }

    /// Ends a flight; one that never began goes on waiting.
    fn release(&mut self, reason: Reason) {
        if !matches!(self.phase, Phase::Idle(_)) {
            self.enter(Phase::Idle(reason));
        }
    }

    fn start_return(&mut self, reason: Reason) {
        if matches!(self.phase, Phase::BringUp | Phase::Flight) {
            self.enter(Phase::Returning(reason));
            self.returns = (0, 0);
        }
    }

    fn enter(&mut self, phase: Phase) {
        (self.phase, self.since_ms, self.stopping) = (phase, None, None);
    }

    /// The verdict before anything was heard from the vehicle.
    const fn unheard(&self) -> Verdict {
        match self.phase {
            Phase::Idle(reason) | Phase::Returning(reason) => Verdict::Silent(reason),
            Phase::BringUp | Phase::Flight => Verdict::Silent(Reason::LinkLost),
        }
    }

    fn decide(&mut self, inputs: &Inputs, now: u32) -> Verdict {
        let since = *self.since_ms.get_or_insert(now);
        if let Some(reason) = self.lost_vehicle(inputs, age_ms(now, since)) {
            self.release(reason);
        }
        match self.phase {
            Phase::Idle(reason) => Verdict::Silent(reason),
            Phase::BringUp => self.bring_up(inputs, now),
            Phase::Flight => self.fly(inputs, now),
            Phase::Returning(reason) => self.send_home(reason, inputs, now),
        }
    }

    /// Why the gate no longer has the vehicle, if so.
    fn lost_vehicle(&mut self, inputs: &Inputs, phase_ms: u32) -> Option<Reason> {
        let (guided, other) = (is_guided(inputs.mode), inputs.mode == FlightMode::Other);
        let (was_guided, was_armed) = (self.heartbeats.guided, self.heartbeats.armed);
        self.heartbeats.guided |= guided;
        self.heartbeats.armed |= inputs.armed;
        match self.phase {
            Phase::Idle(_) => None,
            _ if !inputs.self_test => Some(Reason::SelfTestFailed),
            // The vehicle leaves for the return, as it was commanded to.
            Phase::Returning(reason) if other => Some(reason),
            _ if was_guided && other => Some(Reason::ModeLeft),
            _ if was_armed && !inputs.armed => Some(Reason::Disarmed),
            Phase::Flight if self.monitor.landed() => Some(Reason::Landed),
            Phase::BringUp if phase_ms >= self.limits.bring_up_ms => Some(Reason::BringUpExpired),
            _ => None,
        }
    }

    fn bring_up(&mut self, inputs: &Inputs, now: u32) -> Verdict {
        let (guided, airborne) = (is_guided(inputs.mode), inputs.armed && inputs.airborne);
        match self.monitor.grounding() {
            Some(reason) if reason.action() == FailsafeAction::Return && guided && airborne => {
                self.start_return(reason);
                self.send_home(reason, inputs, now)
            }
            Some(reason) => Verdict::Silent(reason),
            None if guided && airborne => {
                self.enter(Phase::Flight);
                self.since_ms = Some(now);
                self.fly(inputs, now)
            }
            None => {
                let altitude_mm = inputs.state.map_or(0, |state| state.altitude_mm);
                let still = Setpoint { altitude_mm, ..Setpoint::default() };
                Verdict::BringUp((self.limits.stream_before_mode && airborne).then_some(still))
            }
        }
    }

    fn fly(&mut self, inputs: &Inputs, now: u32) -> Verdict {
        if let Some(reason) = self.monitor.give_up() {
            self.start_return(reason);
            return self.send_home(reason, inputs, now);
        }
        // A stop needs no state; anything else does.
        let cause = self.monitor.stop().or(inputs.state.is_none().then_some(Reason::StateStale));
        let (Some(state), None) = (inputs.state, cause) else {
            return self.stop(cause.unwrap_or(Reason::StateStale), inputs, now);
        };
        self.stopping = None;
        if !is_guided(inputs.mode) {
            // The heartbeat does not tell the mode: nothing is known to have been taken over.
            return Verdict::Silent(Reason::HeartbeatLost);
        }
        match (self.monitor.hold(), inputs.proposal) {
            (None, Some(proposal)) => Verdict::Stream(self.limited(
                DesiredSetpoint {
                    velocity: proposal.velocity,
                    acceleration: Some(proposal.acceleration),
                    altitude_mm: proposal.altitude_mm,
                },
                &state,
                now,
            )),
            (cause, proposal) => {
                let altitude_mm = proposal.map_or(state.altitude_mm, |proposal| proposal.altitude_mm);
                let still = DesiredSetpoint { velocity: Vector::ZERO, acceleration: None, altitude_mm };
                let mut setpoint = self.limited(still, &state, now);
                if cause == Some(Reason::PositionJumped) {
                    // A height that jumped is not flown after before it has settled.
                    setpoint.climb_mm_s = 0;
                }
                Verdict::Hold(cause.unwrap_or(Reason::NoDecision), setpoint)
            }
        }
    }

    /// Zero velocity for a while, then silence, and in the end the vehicle is let go.
    fn stop(&mut self, reason: Reason, inputs: &Inputs, now: u32) -> Verdict {
        let (since, since_wall) = *self.stopping.get_or_insert((now, inputs.wall_ms));
        let passed_ms = age_ms(now, since).max(age_ms(inputs.wall_ms, since_wall));
        if passed_ms > self.limits.release_ms {
            self.release(reason);
        }
        if passed_ms >= self.limits.stop_ms || !is_guided(inputs.mode) {
            return Verdict::Silent(reason);
        }
        let altitude_mm = self.sent.map_or(0, |(setpoint, _)| setpoint.altitude_mm);
        Verdict::Hold(reason, Setpoint { altitude_mm, ..Setpoint::default() })
    }

    fn send_home(&mut self, reason: Reason, inputs: &Inputs, now: u32) -> Verdict {
        let (given, last_ms) = self.returns;
        let due = given == 0 || age_ms(now, last_ms) >= self.limits.return_retry_ms;
        if is_guided(inputs.mode) && due && given < self.limits.return_attempts {
            self.returns = (given + 1, now);
            return Verdict::Return(reason);
        }
        Verdict::Silent(reason)
    }

    fn limited(&self, desired: DesiredSetpoint, state: &Measured, now: u32) -> Setpoint {
        let bounds = ApproachLimits::new(&self.fence, state, age_ms(now, state.time_ms), self.braking, &self.limits);
        let previous = match self.sent {
            Some((setpoint, then)) if age_ms(now, then) <= STREAM_GAP_MS => {
                PreviousSetpoint { velocity: setpoint.velocity, passed_ms: age_ms(now, then) }
            }
            _ => PreviousSetpoint { velocity: state.velocity, passed_ms: self.limits.tick_ms },
        };
        limit_setpoint(desired, previous, state, &bounds, &self.limits)
    }

    /// Velocity that was sent lately, mm/s.
    fn commanded(&self, now: u32) -> Vector {
        match self.sent {
            Some((setpoint, then)) if age_ms(now, then) <= STREAM_GAP_MS => setpoint.velocity,
            _ => Vector::ZERO,
        }
    }
}
