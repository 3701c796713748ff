//! The operator's orders that end a flight: a return, or a landing.

use super::client::{Autopilot, set_mode_params};
use super::command::PendingCommand;
use super::notice::Notice;
use super::order::{Order, Ordered};
use crate::messages::{CommandLong, mav_cmd};

/// An order that failed is given again after this, ms.
const REPEAT_ORDER_MS: i64 = 2000;
/// So long after its COMMAND_ACK an order whose effect does not show is given again, ms: the answer may have
/// been to another change of mode.
const EFFECT_MS: i64 = 1500;
/// An order that came before the effect of a command under way waits so long for a heartbeat, ms.
const WAIT_MS: i64 = 3000;

impl Autopilot {
    /// Carries out an order, unless somebody else has the vehicle.
    pub fn order(&mut self, order: Order, now_ms: i64) -> Ordered {
        self.waiting_order = None;
        if self.takes_orders() {
            self.end_flight(order, now_ms);
            return Ordered::Commanded;
        }
        let until = match self.firmware {
            None if self.target.is_none() => None,
            // Its effect may be that the vehicle is ours.
            Some(_) if self.has_pending_bring_up() => Some(now_ms + WAIT_MS),
            _ => return Ordered::Refused,
        };
        self.waiting_order = Some((order, until));
        // No command of the bring-up follows.
        self.drop_bring_up();
        Ordered::Waits
    }

    /// Commands the return to launch.
    pub fn return_home(&mut self, now_ms: i64) {
        self.end_flight(Order::Return, now_ms);
    }

    fn end_flight(&mut self, order: Order, now_ms: i64) {
        let Some(firmware) = self.firmware else { return };
        let mode = match order {
            Order::Return => firmware.return_home(),
            Order::Land => firmware.land(),
        };
        let params = set_mode_params(mode);
        if self.order.is_none() && self.control.is_in(firmware.custom_mode(mode)) {
            // It does so already.
            return;
        }
        if !self.order.is_some_and(|order| order.is(mav_cmd::DO_SET_MODE, &params)) {
            self.order = Some(PendingCommand::new(mav_cmd::DO_SET_MODE, params, now_ms));
            self.control.order(firmware.custom_mode(mode));
        }
        // No command of the bring-up follows.
        self.drop_bring_up();
    }

    fn has_pending_bring_up(&self) -> bool {
        self.command.is_some_and(|command| command.command() != mav_cmd::SET_MESSAGE_INTERVAL && command.was_sent())
    }

    fn drop_bring_up(&mut self) {
        self.command = self.command.filter(|command| command.command() == mav_cmd::SET_MESSAGE_INTERVAL);
    }

    /// The return or landing to send now. It is repeated until the autopilot is in that mode or somebody else
    /// has it, whatever its answer.
    pub(super) fn poll_order(&mut self, now_ms: i64, notices: &mut Vec<Notice>) -> Option<CommandLong> {
        let order = self.order.as_mut()?;
        if order.accepted_ms().is_some_and(|at| now_ms - at >= EFFECT_MS) {
            *order = order.anew(now_ms);
        }
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

    /// After a heartbeat: drops an order that was carried out, or whose vehicle somebody else flies by now, and
    /// commands one that waited.
    pub(super) fn check_order(&mut self, now_ms: i64, notices: &mut Vec<Notice>) {
        if !self.takes_orders() || self.control.has_obeyed() {
            self.order = None;
        }
        let Some((order, until)) = self.waiting_order else { return };
        if self.takes_orders() {
            self.waiting_order = None;
            self.end_flight(order, now_ms);
        } else if until.is_none_or(|until| now_ms >= until) {
            self.waiting_order = None;
            notices.push(self.refusal());
        }
    }

    /// Why an order is not commanded.
    pub fn refusal(&self) -> Notice {
        let (mode, armed) = (self.mode_name(), if self.is_armed() { "" } else { "dis" });
        Notice::warning(format!("not commanded: the vehicle is {armed}armed, in {mode}, and not this node's"))
    }

    /// Whether a return or a landing may be commanded: the vehicle is armed, and in the mode that follows
    /// setpoints or in one that commands from here led to.
    #[must_use]
    pub fn takes_orders(&self) -> bool {
        self.control.takes_orders()
    }

    /// Whether a return or a landing is under way.
    #[must_use]
    pub const fn has_order(&self) -> bool {
        self.order.is_some()
    }

    /// Whether the vehicle climbs by the takeoff that was commanded here, and no order ended that.
    #[must_use]
    pub fn climbs(&self) -> bool {
        self.takes_orders()
            && self.order.is_none()
            && !self.control.has_obeyed()
            && self.bring_up.is_climbing(&self.state)
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
