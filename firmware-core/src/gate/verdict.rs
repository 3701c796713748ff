//! What comes out of the gate at a tick.

use super::reason::Reason;
use super::vector::Vector;

/// What may be sent at this tick. Nothing else may.
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// No setpoint and no command.
    Silent(Reason),
    /// No flight yet: mode, arming and takeoff commands may be sent. With a setpoint (it asks for standing still)
    /// that is to be streamed, as PX4 wants before it takes OFFBOARD.
    BringUp(Option<Setpoint>),
    /// Send the actor's setpoint, as limited.
    Stream(Setpoint),
    /// Send this setpoint instead of the actor's: it brakes, or leads back inside the fence.
    Hold(Reason, Setpoint),
    /// Send one command to return home (RTL), and no setpoint.
    Return(Reason),
}

impl Verdict {
    /// The setpoint to be sent, if any.
    #[must_use]
    pub const fn setpoint(&self) -> Option<Setpoint> {
        match *self {
            Self::BringUp(setpoint) => setpoint,
            Self::Stream(setpoint) | Self::Hold(_, setpoint) => Some(setpoint),
            Self::Silent(_) | Self::Return(_) => None,
        }
    }

    /// Why the actor does not fly now; nothing while it does or is being brought up.
    #[must_use]
    pub const fn reason(&self) -> Option<Reason> {
        match *self {
            Self::Silent(reason) | Self::Hold(reason, _) | Self::Return(reason) => Some(reason),
            Self::BringUp(_) | Self::Stream(_) => None,
        }
    }

    /// One word: `silent`, `bring_up`, `stream`, `hold` or `return`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Silent(_) => "silent",
            Self::BringUp(_) => "bring_up",
            Self::Stream(_) => "stream",
            Self::Hold(..) => "hold",
            Self::Return(_) => "return",
        }
    }
}

/// A setpoint within all limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Setpoint {
    /// Velocity, mm/s.
    pub velocity: Vector,
    /// Vertical speed, mm/s, up.
    pub climb_mm_s: i32,
    /// Acceleration to feed forward, mm/s².
    pub acceleration: Vector,
    /// The altitude that the vertical speed leads to, mm above the mission's origin.
    pub altitude_mm: i32,
    /// What the gate changed.
    pub limited: Limited,
}

/// Which limits changed what was proposed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limited {
    /// It was too fast.
    pub speed: bool,
    /// Its acceleration was too great, or its velocity too far from the last one.
    pub acceleration: bool,
    /// It would have left the fence.
    pub fence: bool,
    /// Its altitude was outside the band.
    pub altitude: bool,
}

impl Limited {
    /// Whether anything was changed.
    #[must_use]
    pub const fn any(self) -> bool {
        self.speed || self.acceleration || self.fence || self.altitude
    }
}
