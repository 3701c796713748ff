//! MAVLink's command protocol: one COMMAND_LONG at a time, repeated until its COMMAND_ACK.

use crate::messages::{CommandLong, mav_cmd};

/// A command without a COMMAND_ACK is sent again after this, ms.
const ACK_TIMEOUT_MS: i64 = 1500;
/// … so many times.
const MAX_SENT: u8 = 8;
/// A refused command is sent again after this, ms: arming waits for pre-arm checks to pass.
const RETRY_MS: i64 = 2000;
/// … so many times.
const MAX_REFUSED: u8 = 20;
/// An accepted command has this long to show its effect, ms.
const EFFECT_MS: i64 = 4000;

/// MAV_RESULT values.
const ACCEPTED: u8 = 0;
const UNSUPPORTED: u8 = 3;
const IN_PROGRESS: u8 = 5;

/// A command under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PendingCommand {
    command: u16,
    params: [f32; 7],
    state: State,
    sent: u8,
    refused: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// To be sent at this time, ms.
    Due(i64),
    /// Sent at this time, ms.
    Sent(i64),
    /// Accepted at this time, ms.
    Accepted(i64),
}

/// How a command failed for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CommandFailure {
    /// No COMMAND_ACK after the last repetition.
    NoAck,
    /// It was refused at each repetition.
    Refused,
    /// MAV_RESULT_UNSUPPORTED: the autopilot does not implement it.
    Unsupported,
}

impl PendingCommand {
    /// A command to be sent at once.
    pub const fn new(command: u16, params: [f32; 7], now_ms: i64) -> Self {
        Self { command, params, state: State::Due(now_ms), sent: 0, refused: 0 }
    }

    /// Its MAV_CMD.
    pub const fn command(&self) -> u16 {
        self.command
    }

    /// Whether the autopilot accepted it.
    pub const fn is_accepted(&self) -> bool {
        matches!(self.state, State::Accepted(_))
    }

    /// Whether it was sent, and no answer came yet.
    pub const fn is_sent(&self) -> bool {
        matches!(self.state, State::Sent(_))
    }

    /// Whether it was sent at least once, whatever became of it.
    pub const fn was_sent(&self) -> bool {
        self.sent > 0 || self.refused > 0
    }

    /// When the autopilot accepted it, ms.
    pub const fn accepted_ms(self) -> Option<i64> {
        match self.state {
            State::Accepted(at) => Some(at),
            State::Due(_) | State::Sent(_) => None,
        }
    }

    /// Takes it for accepted: its effect shows.
    pub const fn accept(&mut self, now_ms: i64) {
        self.state = State::Accepted(now_ms);
    }

    /// Whether the last answer was a refusal.
    pub const fn is_refused(&self) -> bool {
        self.refused > 0
    }

    /// The same command from the beginning, to be sent at `due_ms`.
    pub const fn anew(self, due_ms: i64) -> Self {
        Self::new(self.command, self.params, due_ms)
    }

    /// Whether it is this command with these parameters.
    pub fn is(&self, command: u16, params: &[f32; 7]) -> bool {
        self.command == command && self.params == *params
    }

    /// The message to send now, if one is due.
    ///
    /// # Errors
    /// [`CommandFailure::NoAck`] after the last repetition.
    pub fn poll(&mut self, now_ms: i64) -> Result<Option<CommandLong>, CommandFailure> {
        let due = match self.state {
            State::Due(at) => now_ms >= at,
            State::Sent(at) => now_ms - at >= ACK_TIMEOUT_MS,
            // Accepted, and the vehicle did not do it in time: send it again.
            State::Accepted(at) => now_ms - at >= EFFECT_MS && self.command != mav_cmd::NAV_TAKEOFF,
        };
        if !due {
            return Ok(None);
        }
        if self.sent >= MAX_SENT {
            return Err(CommandFailure::NoAck);
        }
        let message = CommandLong { command: self.command, confirmation: self.sent, params: self.params };
        self.sent += 1;
        self.state = State::Sent(now_ms);
        Ok(Some(message))
    }

    /// Takes in the MAV_RESULT of its COMMAND_ACK. Returns whether the autopilot accepted it or is
    /// working on it; otherwise it will be sent again.
    ///
    /// # Errors
    /// The autopilot does not implement the command or refused it too often.
    pub const fn acknowledge(&mut self, result: u8, now_ms: i64) -> Result<bool, CommandFailure> {
        match result {
            ACCEPTED => self.state = State::Accepted(now_ms),
            // The final COMMAND_ACK is still to come.
            IN_PROGRESS => self.state = State::Sent(now_ms),
            UNSUPPORTED => return Err(CommandFailure::Unsupported),
            _ => {
                self.refused += 1;
                if self.refused >= MAX_REFUSED {
                    return Err(CommandFailure::Refused);
                }
                self.sent = 0;
                self.state = State::Due(now_ms + RETRY_MS);
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// A command in words.
pub(super) const fn command_name(command: u16) -> &'static str {
    match command {
        mav_cmd::COMPONENT_ARM_DISARM => "arming",
        mav_cmd::NAV_TAKEOFF => "takeoff",
        mav_cmd::DO_SET_MODE => "the change of mode",
        mav_cmd::SET_MESSAGE_INTERVAL => "a message rate",
        _ => "a command",
    }
}
