//! The operator's orders that end a flight: a return, or a landing.

use super::client::{Autopilot, set_mode_params};
use super::command::PendingCommand;
use super::firmware::{Firmware, Mode};
use super::notice::Notice;
use crate::messages::{CommandLong, mav_cmd};

/// An order that failed is given again after this, ms.
const REPEAT_ORDER_MS: i64 = 2000;

impl Autopilot {
    /// Commands the return to launch.
    pub fn return_home(&mut self, now_ms: i64) {
        self.end_flight(Firmware::return_home, now_ms);
    }

    /// Commands a landing at the present position.
    pub fn land(&mut self, now_ms: i64) {
        self.end_flight(Firmware::land, now_ms);
    }

    pub(super) fn end_flight(&mut self, mode: fn(Firmware) -> [f32; 2], now_ms: i64) {
        let Some([main, sub]) = self.firmware.map(mode) else { return };
        let params = set_mode_params([main, sub]);
        if !self.order.is_some_and(|order| order.is(mav_cmd::DO_SET_MODE, &params)) {
            self.order = Some(PendingCommand::new(mav_cmd::DO_SET_MODE, params, now_ms));
        }
        // No command of the bring-up follows.
        self.command = self.command.filter(|command| command.command() == mav_cmd::SET_MESSAGE_INTERVAL);
    }

    /// The return or landing to send now. It is repeated until the autopilot has left the mode that follows
    /// setpoints, whatever its answer.
    pub(super) fn poll_order(&mut self, now_ms: i64, notices: &mut Vec<Notice>) -> Option<CommandLong> {
        let order = self.order.as_mut()?;
        let polled = order.poll(now_ms);
        match polled {
            Ok(message) => message,
            Err(_) => {
                self.repeat_order(now_ms, "no answer from the autopilot", notices);
                None
            }
        }
    }

    /// Begins anew with an order that failed.
    pub(super) fn repeat_order(&mut self, now_ms: i64, why: &str, notices: &mut Vec<Notice>) {
        self.order = self.order.map(|order| order.anew(now_ms + REPEAT_ORDER_MS));
        notices.push(Notice::warning(format!("the return or landing failed: {why}; trying on")));
    }

    /// Drops an order that was carried out, or whose vehicle somebody else flies by now.
    pub(super) fn check_order(&mut self) {
        if !self.takes_orders() {
            self.order = None;
        }
    }

    /// Whether a return or a landing may be commanded: the vehicle is armed, and in the mode that follows
    /// setpoints or in the takeoff that was commanded here.
    #[must_use]
    pub fn takes_orders(&self) -> bool {
        let climbs = self.mode() == Some(Mode::TakeoffOrHold) && self.bring_up.has_begun();
        self.is_armed() && (self.mode() == Some(Mode::Guided) || climbs)
    }

    /// Whether a return or a landing is under way.
    #[must_use]
    pub const fn has_order(&self) -> bool {
        self.order.is_some()
    }

    /// A vehicle that climbs has taken off, whatever became of the COMMAND_ACK.
    pub(super) fn note_climb(&mut self, now_ms: i64) {
        if let Some(command) = self.command.as_mut().filter(|c| c.command() == mav_cmd::NAV_TAKEOFF)
            && !command.is_accepted()
            && self.bring_up.is_climbing(&self.state)
        {
            command.accept(now_ms);
        }
    }
}
