//! What the autopilot answers to commands, and what the operator is told of it.

use super::client::Autopilot;
use super::command::{CommandFailure, command_name};
use super::message_rates::message_rates;
use super::notice::Notice;
use super::stage::Stage;
use crate::messages::mav_cmd;

/// What a start waits for is repeated to the operator this often, ms.
const REMIND_MS: i64 = 10_000;
/// A STATUSTEXT explains a refusal for this long, ms.
const TEXT_MS: i64 = 10_000;

impl Autopilot {
    pub(super) fn acknowledge(&mut self, command: u16, result: u8, now_ms: i64, notices: &mut Vec<Notice>) {
        if let Some(order) = self.order.as_mut().filter(|c| c.command() == command && !c.is_accepted()) {
            if order.acknowledge(result, now_ms).is_err() || order.is_refused() {
                let why = format!("refused by the autopilot{}", self.explanation(now_ms));
                self.repeat_order(now_ms, &why, notices);
            }
            return;
        }
        let Some(pending) = self.command.as_mut().filter(|c| c.command() == command && !c.is_accepted()) else {
            return;
        };
        match pending.acknowledge(result, now_ms) {
            Ok(true) if command == mav_cmd::COMPONENT_ARM_DISARM => self.control.arm(),
            Ok(true) => {}
            Ok(false) => {
                let (what, why) = (command_name(command), self.explanation(now_ms));
                self.remind(now_ms, notices, || format!("{what} refused by the autopilot{why}; trying again"));
            }
            Err(failure) => self.fail(failure, now_ms, notices),
        }
    }

    pub(super) fn fail(&mut self, failure: CommandFailure, now_ms: i64, notices: &mut Vec<Notice>) {
        let Some(pending) = self.command.take() else { return };
        let what = command_name(pending.command());
        if pending.command() == mav_cmd::SET_MESSAGE_INTERVAL {
            // Some autopilots send the message without a request.
            let id = message_rates(self.firmware, self.rate_hz).get(self.next_rate).map_or(0, |&(id, _)| id);
            notices.push(Notice::warning(format!(
                "the autopilot does not take a rate for message {id}; going on without"
            )));
            self.next_rate += 1;
            return;
        }
        let reason = match failure {
            CommandFailure::NoAck => format!("{what}: no answer from the autopilot"),
            CommandFailure::Refused => format!("{what} refused by the autopilot{}", self.explanation(now_ms)),
            CommandFailure::Unsupported => format!("{what}: the autopilot does not know this command"),
        };
        self.give_up(&reason, notices);
    }

    pub(crate) fn give_up(&mut self, reason: &str, notices: &mut Vec<Notice>) {
        notices.push(Notice::warning(format!("not flying: {reason}")));
        (self.command, self.stage) = (None, Stage::Failed);
    }

    /// The autopilot's last STATUSTEXT, if it is recent enough to explain a refusal.
    pub(super) fn explanation(&self, now_ms: i64) -> String {
        match &self.last_text {
            Some((text, at)) if now_ms - at <= TEXT_MS => format!(": {text}"),
            _ => String::new(),
        }
    }

    pub(crate) fn remind(&mut self, now_ms: i64, notices: &mut Vec<Notice>, text: impl FnOnce() -> String) {
        if now_ms - self.reminded_ms >= REMIND_MS {
            self.reminded_ms = now_ms;
            notices.push(Notice::info(text()));
        }
    }
}
