//! One command at a time, sent again until it is answered.

use super::outgoing::{Outgoing, command};

/// A command without an answer is sent again after this, ms.
const ANSWER_MS: i64 = 1500;
/// … so many times.
const MAX_SENT: u8 = 8;
/// A refused command is tried again after this, ms: arming waits for checks to pass.
const RETRY_MS: i64 = 2000;
/// … so many times.
const MAX_REFUSED: u8 = 20;
/// An accepted command has this long to show its effect, ms.
const EFFECT_MS: i64 = 4000;

/// A command under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Whether it ends a flight, and so may be sent when nothing else may.
    pub ends_flight: bool,
    command: u16,
    params: [f32; 7],
    state: State,
    sent: u8,
    refused: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// To be sent at this time.
    Due(i64),
    /// Sent at this time.
    Asked(i64),
    /// Accepted at this time.
    Accepted(i64),
}

/// How a request went wrong for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// It was never answered.
    Unanswered,
    /// It was refused again and again.
    Refused,
    /// The autopilot does not know it.
    Unsupported,
}

impl Request {
    /// A command to be sent at once.
    #[must_use]
    pub const fn new(command: u16, params: [f32; 7], now_ms: i64) -> Self {
        Self { ends_flight: false, command, params, state: State::Due(now_ms), sent: 0, refused: 0 }
    }

    /// Which command.
    #[must_use]
    pub const fn command(&self) -> u16 {
        self.command
    }

    /// Whether it was accepted.
    #[must_use]
    pub const fn is_accepted(&self) -> bool {
        matches!(self.state, State::Accepted(_))
    }

    /// Whether it is the same command with the same parameters.
    #[must_use]
    pub fn asks(&self, command: u16, params: &[f32; 7]) -> bool {
        self.command == command && self.params == *params
    }

    /// What is to be sent now, if anything.
    ///
    /// # Errors
    /// When it was sent in vain too often.
    pub fn poll(&mut self, now_ms: i64) -> Result<Option<Outgoing>, Failure> {
        let due = match self.state {
            State::Due(at) => now_ms >= at,
            State::Asked(at) => now_ms - at >= ANSWER_MS,
            // It had its time and changed nothing: again.
            State::Accepted(at) => now_ms - at >= EFFECT_MS && self.command != command::TAKEOFF,
        };
        if !due {
            return Ok(None);
        }
        if self.sent >= MAX_SENT {
            return Err(Failure::Unanswered);
        }
        let outgoing = Outgoing::Command { command: self.command, confirmation: self.sent, params: self.params };
        self.sent += 1;
        self.state = State::Asked(now_ms);
        Ok(Some(outgoing))
    }

    /// Takes in an answer (MAV_RESULT) to its command.
    ///
    /// # Errors
    /// When the autopilot does not know the command or refused it too often.
    pub const fn answer(&mut self, result: u8, now_ms: i64) -> Result<(), Failure> {
        match result {
            0 => self.state = State::Accepted(now_ms),
            // In progress: the answer proper is still to come.
            5 => self.state = State::Asked(now_ms),
            3 => return Err(Failure::Unsupported),
            _ => {
                self.refused += 1;
                if self.refused >= MAX_REFUSED {
                    return Err(Failure::Refused);
                }
                self.sent = 0;
                self.state = State::Due(now_ms + RETRY_MS);
            }
        }
        Ok(())
    }
}
