//! Stages of a node's work with its autopilot.

/// How far a node has come with its autopilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// No HEARTBEAT of an autopilot was received yet.
    Silent,
    /// Message intervals are being requested with MAV_CMD_SET_MESSAGE_INTERVAL.
    Subscribing,
    /// Telemetry arrives; the vehicle is on the ground or flown by its pilot.
    Idle,
    /// Mode change, arming or takeoff is under way.
    BringUp,
    /// In the air and in the mode that follows setpoints.
    Flying,
    /// The bring-up failed, or the vehicle is not supported.
    Failed,
}

impl Stage {
    /// The stage in one word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::Subscribing => "subscribing",
            Self::Idle => "idle",
            Self::BringUp => "bring-up",
            Self::Flying => "flying",
            Self::Failed => "failed",
        }
    }
}
