//! The safety gate between the actor and the autopilot.
//!
//! At every tick the gate sees the vehicle's telemetry and what the actor wants ([`Inputs`]) and says what may be sent
//! ([`Verdict`]): the actor's setpoint within all limits, a setpoint that holds, a command to return home, or nothing.
//! It takes the vehicle only when the operator asks for it, and once the pilot or a failsafe took over it is silent
//! until the operator asks anew. `docs/safety.md` has every cause with its action and its time.
//!
//! Pure and integer: the same inputs give the same verdicts on every target. All lengths are mm, speeds mm/s,
//! accelerations mm/s², times wrapping ms.
//!
//! ```
//! use firmware_core::gate::{Fence, Gate, Inputs, Limits, Reason, Vector, Verdict};
//!
//! let fence = Fence::rectangle(Vector::new(-20_000, -20_000), Vector::new(520_000, 520_000))?;
//! let mut gate = Gate::new(Limits::default(), fence)?;
//! assert_eq!(gate.tick(&Inputs::default()), Verdict::Silent(Reason::NotStarted));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod bounds;
mod clock;
mod fence;
mod fingerprint;
mod inputs;
mod limits;
mod monitor;
mod reason;
mod shape;
pub mod telemetry;
mod vector;
mod watch;

pub use fence::{Circle, Fence, FenceError, MAX_CORNERS};
pub use fingerprint::{FINGERPRINT_TICKS, fingerprint};
pub use inputs::{Inputs, Limited, Measured, Mode, Proposal, Request, Setpoint, Verdict};
pub use limits::{Limits, LimitsError, SwarmLoss};
pub use reason::{Action, Clears, Clock, Reason};
pub use shape::ROUNDING_MM_S;
pub use vector::{POSITION_LIMIT_MM, RATE_LIMIT, Vector};

use bounds::Bounds;
use clock::{Passage, VehicleClock, age_ms};
use monitor::{Monitor, Tick, is_guided};
use shape::{From, Wanted, shape};

/// After this time without a setpoint the next one starts from the measured velocity, ms.
const STREAM_GAP_MS: u32 = 1000;

/// Where a flight stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The vehicle is not ours, and why; only the operator's [`Request::Start`] changes that.
    Idle(Reason),
    /// The operator asked for a flight, and the vehicle is not yet in the air and in GUIDED.
    BringUp,
    /// In the air.
    Flight,
    /// Told to return home, and why.
    Returning(Reason),
}

/// The gate of one UAV.
#[derive(Clone, Debug)]
pub struct Gate {
    limits: Limits,
    fence: Fence,
    /// Deceleration to count on toward the fence, mm/s².
    braking: u32,
    clock: VehicleClock,
    monitor: Monitor,
    phase: Phase,
    /// When the phase began, on the vehicle's clock; nothing before that is heard.
    since_ms: Option<u32>,
    /// What the heartbeats told since the operator asked.
    seen: Seen,
    /// Since when the vehicle is being stopped, on both clocks.
    stopping: Option<(u32, u32)>,
    /// Commands to return home that were given, and when the last one was.
    returns: (u8, u32),
    /// The last setpoint, and when it was given.
    sent: Option<(Setpoint, u32)>,
}

/// What the heartbeats told since the operator asked.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    guided: bool,
    armed: bool,
}

impl Gate {
    /// A gate that waits for the operator.
    ///
    /// # Errors
    /// A setting out of its bounds, or a circular fence too small for the speed.
    pub fn new(limits: Limits, fence: Fence) -> Result<Self, LimitsError> {
        limits.check()?;
        let braking = bounds::braking(&limits, &fence)?;
        Ok(Self {
            limits,
            fence,
            braking,
            clock: VehicleClock::default(),
            monitor: Monitor::new(),
            phase: Phase::Idle(Reason::NotStarted),
            since_ms: None,
            seen: Seen::default(),
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
    pub const fn fence(&self) -> &Fence {
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
        let passage = self.clock.advance(inputs.now_ms, inputs.wall_ms, &self.limits);
        if passage != Passage::Steady {
            self.monitor = Monitor::new();
            self.sent = None;
        }
        self.obey(inputs.operator);
        let now = self.clock.now_ms(inputs.wall_ms, &self.limits);
        if let Some(now) = now {
            self.monitor.update(&Tick {
                inputs,
                now_ms: now,
                silence_ms: self.clock.silence_ms(inputs.wall_ms),
                commanded: self.commanded(now),
                limits: &self.limits,
                fence: &self.fence,
            });
        }
        // After the operator's request, which cannot have meant another vehicle.
        match passage {
            Passage::Steady => {}
            Passage::Back => self.let_go(Reason::VehicleRestarted),
            Passage::Ahead => self.let_go(Reason::ClockJumped),
        }
        let verdict = now.map_or(self.unheard(), |now| self.judge(inputs, now));
        let now = now.unwrap_or(0);
        self.sent = match verdict.setpoint() {
            Some(setpoint) => Some((setpoint, now)),
            None => self.sent.filter(|(_, then)| age_ms(now, *then) <= STREAM_GAP_MS),
        };
        verdict
    }

    /// What the operator asks for.
    fn obey(&mut self, request: Option<Request>) {
        match request {
            None => {}
            Some(Request::Start) => {
                self.enter(Phase::BringUp);
                self.seen = Seen::default();
                self.monitor.forget_motion();
            }
            Some(Request::Release) => self.enter(Phase::Idle(Reason::OperatorReleased)),
            Some(Request::Return) => self.come_home(Reason::OperatorReturn),
        }
    }

    /// Ends a flight; one that never began goes on waiting.
    fn let_go(&mut self, reason: Reason) {
        if !matches!(self.phase, Phase::Idle(_)) {
            self.enter(Phase::Idle(reason));
        }
    }

    fn come_home(&mut self, reason: Reason) {
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

    fn judge(&mut self, inputs: &Inputs, now: u32) -> Verdict {
        let since = *self.since_ms.get_or_insert(now);
        if let Some(reason) = self.lost(inputs, age_ms(now, since)) {
            self.let_go(reason);
        }
        match self.phase {
            Phase::Idle(reason) => Verdict::Silent(reason),
            Phase::BringUp => self.bring_up(inputs, now),
            Phase::Flight => self.fly(inputs, now),
            Phase::Returning(reason) => self.send_home(reason, inputs, now),
        }
    }

    /// Why the vehicle is no longer ours, if so.
    fn lost(&mut self, inputs: &Inputs, phase_ms: u32) -> Option<Reason> {
        let (guided, other) = (is_guided(inputs.mode), inputs.mode == Mode::Other);
        let (was_guided, was_armed) = (self.seen.guided, self.seen.armed);
        self.seen.guided |= guided;
        self.seen.armed |= inputs.armed;
        match self.phase {
            Phase::Idle(_) => None,
            _ if !inputs.self_test => Some(Reason::SelfTestFailed),
            // The mode that it was told to leave for is the return.
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
            Some(reason) if reason.action() == Action::Return && guided && airborne => {
                self.come_home(reason);
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
            self.come_home(reason);
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
            (None, Some(proposal)) => Verdict::Stream(self.shaped(
                Wanted {
                    velocity: proposal.velocity,
                    acceleration: Some(proposal.acceleration),
                    altitude_mm: proposal.altitude_mm,
                },
                &state,
                now,
            )),
            (cause, proposal) => {
                let altitude_mm = proposal.map_or(state.altitude_mm, |proposal| proposal.altitude_mm);
                let still = Wanted { velocity: Vector::ZERO, acceleration: None, altitude_mm };
                Verdict::Hold(cause.unwrap_or(Reason::NoDecision), self.shaped(still, &state, now))
            }
        }
    }

    /// Zero velocity for a while, then silence, and in the end the vehicle is let go.
    fn stop(&mut self, reason: Reason, inputs: &Inputs, now: u32) -> Verdict {
        let (since, since_wall) = *self.stopping.get_or_insert((now, inputs.wall_ms));
        let passed_ms = age_ms(now, since).max(age_ms(inputs.wall_ms, since_wall));
        if passed_ms > self.limits.release_ms {
            self.let_go(reason);
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

    fn shaped(&self, wanted: Wanted, state: &Measured, now: u32) -> Setpoint {
        let bounds = Bounds::of(&self.fence, state, age_ms(now, state.time_ms), self.braking, &self.limits);
        let from = match self.sent {
            Some((setpoint, then)) if age_ms(now, then) <= STREAM_GAP_MS => {
                From { velocity: setpoint.velocity, passed_ms: age_ms(now, then) }
            }
            _ => From { velocity: state.velocity, passed_ms: self.limits.tick_ms },
        };
        shape(wanted, from, state, &bounds, &self.limits)
    }

    /// Velocity that was sent lately, mm/s.
    fn commanded(&self, now: u32) -> Vector {
        match self.sent {
            Some((setpoint, then)) if age_ms(now, then) <= STREAM_GAP_MS => setpoint.velocity,
            _ => Vector::ZERO,
        }
    }
}

/// Altitude of a UAV's layer, mm: `base + (id mod layers) · spacing`. No layers count as one. Training lets UAVs pass
/// through each other; in flight their altitudes keep them apart.
#[must_use]
pub fn layer_mm(id: u16, base_mm: i32, spacing_mm: u32, layers: u16) -> i32 {
    let layer = i64::from(id.checked_rem(layers).unwrap_or(0));
    let altitude = i64::from(base_mm) + layer * i64::from(spacing_mm);
    i32::try_from(altitude).unwrap_or(i32::MAX)
}
