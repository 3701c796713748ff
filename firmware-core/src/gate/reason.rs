//! Why the actor does not fly, what is done about it, and how soon. `docs/safety.md` shows this as a table, and a
//! test compares the two.

use super::limits::Limits;

/// A cause. The order is that of precedence: of several the first counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Reason {
    /// The operator has not asked for a flight yet.
    NotStarted,
    /// The operator let the vehicle go.
    OperatorReleased,
    /// The actor's self-test did not pass.
    SelfTestFailed,
    /// The vehicle's clock went back: it booted anew, or it is another vehicle.
    VehicleRestarted,
    /// The vehicle's clock went forward by more than the time that passed, or was not heard for long.
    ClockJumped,
    /// The autopilot left GUIDED (OFFBOARD): the pilot or a failsafe took over.
    ModeLeft,
    /// The vehicle was disarmed.
    Disarmed,
    /// The vehicle is on the ground again.
    Landed,
    /// The vehicle was not in the air and in GUIDED in time.
    BringUpExpired,
    /// The operator asked for the return.
    OperatorReturn,
    /// The battery is low.
    BatteryLow,
    /// The vehicle did not come back inside the fence in time.
    FenceStuck,
    /// Nothing is heard from the autopilot: its clock stands still.
    LinkLost,
    /// The autopilot's heartbeat does not come, though other messages do.
    HeartbeatLost,
    /// No fresh own state.
    StateStale,
    /// The telemetry had a number that is not finite or out of range.
    NumberRefused,
    /// The estimator is unhealthy.
    EkfUnhealthy,
    /// No sufficient GPS fix.
    GpsLost,
    /// Two sources of the own position disagree.
    SourcesDisagree,
    /// The measured position stands still although the vehicle should be moving.
    StateFrozen,
    /// The measured position jumped farther than the vehicle can fly.
    PositionJumped,
    /// The vehicle is outside the fence.
    OutsideFence,
    /// The vehicle is above or below its altitude band.
    OutsideAltitude,
    /// The actor has not decided for too long.
    NoDecision,
    /// No other UAV was heard for long, and the settings say to hold then.
    SwarmLost,
}

/// What is done about a cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
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
pub enum Clears {
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
    /// Every cause, in order of precedence.
    pub const ALL: [Self; 25] = [
        Self::NotStarted,
        Self::OperatorReleased,
        Self::SelfTestFailed,
        Self::VehicleRestarted,
        Self::ClockJumped,
        Self::ModeLeft,
        Self::Disarmed,
        Self::Landed,
        Self::BringUpExpired,
        Self::OperatorReturn,
        Self::BatteryLow,
        Self::FenceStuck,
        Self::LinkLost,
        Self::HeartbeatLost,
        Self::StateStale,
        Self::NumberRefused,
        Self::EkfUnhealthy,
        Self::GpsLost,
        Self::SourcesDisagree,
        Self::StateFrozen,
        Self::PositionJumped,
        Self::OutsideFence,
        Self::OutsideAltitude,
        Self::NoDecision,
        Self::SwarmLost,
    ];

    /// Its name in logs and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotStarted => "not_started",
            Self::OperatorReleased => "operator_released",
            Self::SelfTestFailed => "self_test_failed",
            Self::VehicleRestarted => "vehicle_restarted",
            Self::ClockJumped => "clock_jumped",
            Self::ModeLeft => "mode_left",
            Self::Disarmed => "disarmed",
            Self::Landed => "landed",
            Self::BringUpExpired => "bring_up_expired",
            Self::OperatorReturn => "operator_return",
            Self::BatteryLow => "battery_low",
            Self::FenceStuck => "fence_stuck",
            Self::LinkLost => "link_lost",
            Self::HeartbeatLost => "heartbeat_lost",
            Self::StateStale => "state_stale",
            Self::NumberRefused => "number_refused",
            Self::EkfUnhealthy => "ekf_unhealthy",
            Self::GpsLost => "gps_lost",
            Self::SourcesDisagree => "sources_disagree",
            Self::StateFrozen => "state_frozen",
            Self::PositionJumped => "position_jumped",
            Self::OutsideFence => "outside_fence",
            Self::OutsideAltitude => "outside_altitude",
            Self::NoDecision => "no_decision",
            Self::SwarmLost => "swarm_lost",
        }
    }

    /// What is done about it in flight.
    #[must_use]
    pub const fn action(self) -> Action {
        match self {
            Self::NotStarted
            | Self::OperatorReleased
            | Self::SelfTestFailed
            | Self::VehicleRestarted
            | Self::ClockJumped
            | Self::ModeLeft
            | Self::Disarmed
            | Self::Landed
            | Self::BringUpExpired => Action::Silent,
            Self::OperatorReturn | Self::BatteryLow | Self::FenceStuck => Action::Return,
            Self::LinkLost
            | Self::HeartbeatLost
            | Self::StateStale
            | Self::NumberRefused
            | Self::EkfUnhealthy
            | Self::GpsLost
            | Self::SourcesDisagree
            | Self::StateFrozen => Action::Stop,
            Self::PositionJumped | Self::OutsideFence | Self::OutsideAltitude | Self::NoDecision | Self::SwarmLost => {
                Action::Hold
            }
        }
    }

    /// How it comes to its end.
    #[must_use]
    pub const fn clears(self) -> Clears {
        match self.action() {
            Action::Silent | Action::Return => Clears::Operator,
            Action::Stop => Clears::Lasting,
            Action::Hold => match self {
                Self::PositionJumped => Clears::Settled,
                _ => Clears::AtOnce,
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

impl Action {
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

impl Clears {
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
