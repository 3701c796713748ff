//! What the operator asks of a node.

use super::ending::Ending;
use super::operator::OperatorCommand;
use super::state_machine::Node;
use crate::autopilot::{Notice, Order, Ordered};
use crate::frame::Rejected;
use firmware_core::gate::{Phase, Request};

impl Node<'_> {
    /// Carries out a command of the operator.
    pub fn command(&mut self, command: OperatorCommand) {
        match command {
            OperatorCommand::Start => self.start(),
            OperatorCommand::Release => self.release(false),
            OperatorCommand::Return => self.order(Order::Return),
            OperatorCommand::Land => self.release(true),
        }
    }

    /// Starts the mission: takes control of the vehicle, with takeoff if need be.
    pub fn start(&mut self) {
        let in_flight = self.gate.phase() == Phase::Flight;
        self.begin(true);
        if in_flight {
            // Then it means: as it is.
            self.muster.waive();
            self.height_check.waive();
        }
    }

    /// Starts; only with `may_take` with a vehicle that is armed and in another mode.
    pub(super) fn begin(&mut self, may_take: bool) {
        self.started = true;
        self.ending = None;
        if self.gate.phase() == Phase::BringUp && self.autopilot.goes_on(may_take) {
            return;
        }
        self.place_told = false;
        self.muster.restart(self.swarm_link.counts().get(Rejected::IdCollision));
        self.gate.set_request(Request::Start);
        self.autopilot.restart(may_take);
    }

    /// Releases control of the vehicle. In flight it is braked first, until it stands still or for 3 s;
    /// see [`Node::is_ending`]. With `land` it is commanded to land instead.
    pub fn release(&mut self, land: bool) {
        if land {
            self.order(Order::Land);
        } else {
            self.end(self.gate.is_flying());
        }
    }

    /// Orders a return or a landing of a vehicle that nobody else flies.
    fn order(&mut self, order: Order) {
        self.end(false);
        match self.autopilot.order(order, self.timebase.now_ms()) {
            Ordered::Commanded => self.gate.set_request(Request::Return),
            Ordered::Waits => self.answers.push(Notice::info("commanded as soon as the vehicle is this node's")),
            Ordered::Refused => self.answers.push(self.autopilot.refusal()),
        }
    }

    /// Releases control at once or, with `brake`, once the vehicle stands still.
    pub(super) fn end(&mut self, brake: bool) {
        // Nothing starts by itself after an order of the operator.
        self.started = true;
        if !brake {
            self.ending = None;
            self.gate.set_request(Request::Release);
        } else if self.ending.is_none() {
            self.ending = Some(Ending::new(self.timebase.now_ms()));
            self.answers.push(Notice::info("braking before the vehicle is let go"));
        }
    }

    /// Whether the end of the flight is still under way: the vehicle is being braked, or a command waits
    /// for the autopilot's COMMAND_ACK.
    #[must_use]
    pub fn is_ending(&self) -> bool {
        self.ending.is_some() || self.autopilot.awaits_ack()
    }
}
