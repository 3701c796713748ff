//! When the safety gate is asked, and which of its setpoints are sent.

use super::counters::Counters;
use super::host_time::HostTime;
use crate::autopilot::{Clearance, Notice};
use firmware_core::gate::{FailsafeAction, Gate, Inputs, Phase, Reason, Request, Setpoint, Verdict};

/// Without positions the gate is asked this often, ms: by the vehicle's clock, and in real time by
/// the host's.
const PERIOD_MS: u32 = 200;
/// The first time it is asked later: a position of the same tick may be on its way behind another
/// message that moved the clock.
const FIRST_MS: u32 = 300;
/// By the host's clock where the vehicle's may run at any speed, or wait for others, ms.
const SIMULATION_MS: u64 = 2000;
/// … and a setpoint is sent on its own no sooner than this after the last, ms of the host's clock.
const SETPOINT_MS: u64 = 200;
/// In lock-step an answer waits for other UAVs' messages for so long, ms of the host's clock: less than the
/// simulation waits for the answer.
const OWED_MS: u64 = 1000;

/// Which setpoints are sent after the gate was asked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum SetpointFilter {
    /// Any: a position arrived.
    Any,
    /// Those that brake or hold, and any with a new verdict. The actor's are answers to positions.
    Braking,
    /// Only those with a new verdict.
    NewVerdict,
}

/// What the gate wants done.
#[derive(Debug)]
pub(super) struct GateOutput {
    /// For the operator, when the verdict is another one.
    pub notice: Option<Notice>,
    /// The autopilot is to be commanded to return to launch.
    pub return_home: bool,
    /// The setpoint to send.
    pub setpoint: Option<Setpoint>,
}

/// The safety gate with its timing.
#[derive(Debug)]
pub(super) struct GateDriver {
    gate: Gate,
    verdict: Verdict,
    /// The operator's request, until it is handed to the gate.
    request: Option<Request>,
    /// When the gate was last asked, by the vehicle's and by the host's clock.
    asked_boot_ms: u32,
    asked_wall_ms: u64,
    /// It was last asked without a new position.
    overdue: bool,
    /// When a setpoint was last sent, by the host's clock.
    setpoint_wall_ms: u64,
    streaming: bool,
    /// Since when a position waits for its answer, by the host's clock.
    owed_wall_ms: Option<u64>,
    counters: Counters,
}

impl GateDriver {
    pub fn new(gate: Gate) -> Self {
        Self {
            gate,
            verdict: Verdict::Silent(Reason::NotStarted),
            request: None,
            asked_boot_ms: 0,
            asked_wall_ms: 0,
            overdue: false,
            setpoint_wall_ms: 0,
            streaming: false,
            owed_wall_ms: None,
            counters: Counters::default(),
        }
    }

    /// The operator's request, for the gate's next turn.
    pub const fn set_request(&mut self, request: Request) {
        self.request = Some(request);
    }

    /// Whether setpoints fly the vehicle.
    pub const fn is_flying(&self) -> bool {
        matches!(self.gate.phase(), Phase::Flight) && self.verdict.setpoint().is_some()
    }

    /// Whether a cause whose action is the return keeps the gate silent in bring-up.
    pub const fn gives_up_bring_up(&self) -> bool {
        let Verdict::Silent(reason) = self.verdict else { return false };
        matches!((self.gate.phase(), reason.action()), (Phase::BringUp, FailsafeAction::Return))
    }

    /// Takes the operator's request, to hand it to the gate.
    pub const fn take_request(&mut self) -> Option<Request> {
        self.request.take()
    }

    pub const fn verdict(&self) -> Verdict {
        self.verdict
    }

    pub const fn phase(&self) -> Phase {
        self.gate.phase()
    }

    /// Counts of setpoints.
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// What the autopilot's client may do.
    pub const fn clearance(&self) -> Clearance {
        // A verdict from before the operator's request no longer counts.
        let bring_up = matches!(self.verdict, Verdict::BringUp(_)) && self.request.is_none();
        Clearance { bring_up, streaming: self.streaming }
    }

    /// A position arrived, to be answered with a setpoint.
    pub const fn position_arrived(&mut self, now: HostTime) {
        self.owed_wall_ms = Some(now.wall_ms);
    }

    /// The gate was asked with the newest position: the wait for the next one begins.
    pub const fn position_answered(&mut self) {
        (self.owed_wall_ms, self.overdue) = (None, false);
    }

    /// Whether the newest position was not answered yet.
    pub const fn owes_answer(&self) -> bool {
        self.owed_wall_ms.is_some()
    }

    /// Whether the newest position was not answered for so long that it has to be.
    pub fn owes_answer_since(&self, now: HostTime) -> bool {
        self.owed_wall_ms.is_some_and(|since_ms| now.wall_ms.saturating_sub(since_ms) >= OWED_MS)
    }

    /// Whether the gate has to be asked without a position, at `boot_ms` of the vehicle's clock, and
    /// which setpoints then count.
    pub fn overdue(&mut self, boot_ms: u32, now: HostTime) -> Option<SetpointFilter> {
        let period_ms = if self.overdue { PERIOD_MS } else { FIRST_MS };
        let period_wall_ms = if self.gate.limits().real_time { u64::from(period_ms) } else { SIMULATION_MS };
        let passed_ms = boot_ms.wrapping_sub(self.asked_boot_ms);
        let passed_wall_ms = now.wall_ms.saturating_sub(self.asked_wall_ms);
        if passed_ms < period_ms && passed_wall_ms < period_wall_ms {
            return None;
        }
        self.overdue = true;
        let since_ms = now.wall_ms.saturating_sub(self.setpoint_wall_ms);
        Some(if since_ms >= SETPOINT_MS { SetpointFilter::Braking } else { SetpointFilter::NewVerdict })
    }

    /// Asks the gate. With `early` setpoints go out in bring-up too: PX4 requires a stream of them before
    /// OFFBOARD.
    pub fn tick(&mut self, inputs: &Inputs, now: HostTime, filter: SetpointFilter, early: bool) -> GateOutput {
        let before = self.verdict;
        self.verdict = self.gate.tick(inputs);
        (self.asked_boot_ms, self.asked_wall_ms) = (inputs.now_ms.unwrap_or(0), now.wall_ms);
        let is_new = before.name() != self.verdict.name() || before.reason() != self.verdict.reason();
        let too_early = matches!(self.verdict, Verdict::BringUp(_)) && !early;
        let setpoint = self.verdict.setpoint().filter(|_| !too_early);
        self.streaming = setpoint.is_some();
        let wanted = match filter {
            SetpointFilter::Any => true,
            SetpointFilter::Braking => is_new || !matches!(self.verdict, Verdict::Stream(_)),
            SetpointFilter::NewVerdict => is_new,
        };
        let setpoint = setpoint.filter(|_| wanted);
        if let Some(setpoint) = &setpoint {
            self.setpoint_wall_ms = now.wall_ms;
            self.counters.count_setpoint(setpoint.limited);
        }
        GateOutput {
            notice: is_new.then(|| verdict_notice(before, self.verdict)),
            return_home: matches!(self.verdict, Verdict::Return(_)),
            setpoint,
        }
    }
}

/// What a new verdict means for the flight, in words.
fn verdict_notice(before: Verdict, verdict: Verdict) -> Notice {
    let flew = matches!(before, Verdict::Stream(_));
    let (text, warning) = match verdict {
        Verdict::Silent(reason) => (format!("no setpoints: {}", reason.name()), flew),
        Verdict::BringUp(_) => ("ready to start".into(), false),
        Verdict::Stream(_) => ("the actor flies".into(), false),
        Verdict::Hold(reason, _) => (format!("holding the place: {}", reason.name()), flew),
        Verdict::Return(reason) => (format!("asking the autopilot to return home: {}", reason.name()), true),
    };
    Notice { warning, text }
}
