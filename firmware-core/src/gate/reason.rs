//! Why the actor does not fly. `docs/safety.md` shows this as a table, and a test compares the two.

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
    /// The measured height is in doubt.
    HeightDoubted,
    /// The vehicle is not on its altitude layer.
    OffLayer,
    /// The actor has not decided for too long.
    NoDecision,
    /// The UAVs that start together are not all in the air yet.
    SwarmIncomplete,
    /// No other UAV was heard for long, and the settings say to hold then.
    SwarmLost,
}

impl Reason {
    /// Every cause, in order of precedence.
    pub const ALL: [Self; 28] = [
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
        Self::HeightDoubted,
        Self::OffLayer,
        Self::NoDecision,
        Self::SwarmIncomplete,
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
            Self::HeightDoubted => "height_doubted",
            Self::OffLayer => "off_layer",
            Self::NoDecision => "no_decision",
            Self::SwarmIncomplete => "swarm_incomplete",
            Self::SwarmLost => "swarm_lost",
        }
    }
}
