//! What is done about a cause, how soon, and how it ends. `docs/safety.md` shows this as a table, and a test
//! compares the two.

use super::limits::Limits;
use super::reason::Reason;

/// What is done about a cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FailsafeAction {
    /// No setpoint from this tick on; the autopilot's own timeout acts.
    Silent,
    /// Setpoints of zero velocity for [`Limits::stop_ms`], then none; the autopilot keeps the vehicle where it
    /// stopped.
    Stop,
    /// Setpoints that brake, hold the place and lead back inside the fence and the altitude band.
    Hold,
    /// A command to return home, then silence.
    Return,
}

/// How a cause comes to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Recovery {
    /// Only by the operator's new request, and once it no longer holds.
    Operator,
    /// When it has not held for [`Limits::clear_ms`]; but after [`Limits::release_ms`] only by the operator.
    Lasting,
    /// When it has not held for [`Limits::clear_ms`].
    Settled,
    /// At the first tick at which it does not hold.
    AtOnce,
}

/// The clock by which a time runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Clock {
    /// The vehicle's.
    Vehicle,
    /// The own computer's, because the vehicle's stands still.
    Wall,
}

impl Reason {
    /// What is done about it in flight.
    #[must_use]
    pub const fn action(self) -> FailsafeAction {
        match self {
            Self::NotStarted
            | Self::OperatorReleased
            | Self::SelfTestFailed
            | Self::VehicleRestarted
            | Self::ClockJumped
            | Self::ModeLeft
            | Self::Disarmed
            | Self::Landed
            | Self::BringUpExpired => FailsafeAction::Silent,
            Self::OperatorReturn | Self::BatteryLow | Self::FenceStuck => FailsafeAction::Return,
            Self::LinkLost
            | Self::HeartbeatLost
            | Self::StateStale
            | Self::NumberRefused
            | Self::EkfUnhealthy
            | Self::GpsLost
            | Self::SourcesDisagree
            | Self::StateFrozen => FailsafeAction::Stop,
            Self::PositionJumped
            | Self::OutsideFence
            | Self::OutsideAltitude
            | Self::HeightDoubted
            | Self::OffLayer
            | Self::NoDecision
            | Self::SwarmIncomplete
            | Self::SwarmLost => FailsafeAction::Hold,
        }
    }

    /// How it comes to its end.
    #[must_use]
    pub const fn recovery(self) -> Recovery {
        match self.action() {
            FailsafeAction::Silent | FailsafeAction::Return => Recovery::Operator,
            FailsafeAction::Stop => Recovery::Lasting,
            FailsafeAction::Hold => match self {
                Self::PositionJumped => Recovery::Settled,
                _ => Recovery::AtOnce,
            },
        }
    }

    /// How long after the cause begins the action begins at the latest, ms, when the gate is asked at least every
    /// [`Limits::tick_ms`]. Where the cause is the absence of something, it begins with the last of it.
    #[must_use]
    pub const fn deadline_ms(self, limits: &Limits) -> u32 {
        let detection = match self {
            // What must last is counted from the tick that first sees it.
            Self::Landed | Self::EkfUnhealthy | Self::GpsLost | Self::SourcesDisagree | Self::OutsideAltitude => {
                limits.confirm_ms + limits.tick_ms
            }
            Self::BatteryLow => limits.battery_confirm_ms + limits.tick_ms,
            Self::FenceStuck => limits.fence_stuck_ms + limits.tick_ms,
            Self::BringUpExpired => limits.bring_up_ms,
            Self::LinkLost => limits.link_wall_ms,
            Self::HeartbeatLost => limits.heartbeat_ms,
            Self::StateStale => limits.stale_ms,
            Self::StateFrozen => match limits.frozen_ms {
                Some(ms) => ms,
                None => 0,
            },
            Self::NoDecision => limits.decision_ms,
            Self::SwarmLost => limits.swarm_ms,
            _ => 0,
        };
        detection.saturating_add(limits.tick_ms)
    }

    /// The clock of [`Self::deadline_ms`].
    #[must_use]
    pub const fn clock(self) -> Clock {
        match self {
            Self::LinkLost => Clock::Wall,
            _ => Clock::Vehicle,
        }
    }
}

impl FailsafeAction {
    /// One word: `silent`, `stop`, `hold` or `return`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::Stop => "stop",
            Self::Hold => "hold",
            Self::Return => "return",
        }
    }
}

impl Recovery {
    /// One word or two: `operator`, `lasting`, `settled` or `at once`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Operator => "operator",
            Self::Lasting => "lasting",
            Self::Settled => "settled",
            Self::AtOnce => "at once",
        }
    }
}
