//! How far a vehicle is, and what is told of it.

use std::fmt;

/// Something to tell the operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Whether it needs attention.
    pub warning: bool,
    /// In plain words.
    pub text: String,
}

impl Notice {
    /// All is well.
    pub fn info(text: impl Into<String>) -> Self {
        Self { warning: false, text: text.into() }
    }

    /// Something needs attention.
    pub fn warning(text: impl Into<String>) -> Self {
        Self { warning: true, text: text.into() }
    }
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// How far the vehicle is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// No autopilot was heard.
    Silent,
    /// Message rates are being asked for.
    Subscribing,
    /// On the ground or in somebody else's hands.
    Idle,
    /// Under way into flight.
    BringUp,
    /// In the air and in the mode that takes setpoints.
    Flying,
    /// It could not be brought into flight, or it is none that can be flown.
    Failed,
}

impl Stage {
    /// One word.
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

/// What the node lets happen at a poll.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leave {
    /// Mode, arming and takeoff commands may be sent: the gate is open for a start.
    pub may_start: bool,
    /// Setpoints are being streamed.
    pub streaming: bool,
}
