//! What the operator asks of a node.

use super::ending::Ending;
use super::operator::OperatorCommand;
use super::state_machine::Node;
use crate::autopilot::{Autopilot, Notice};
use crate::frame::Rejected;
use firmware_core::gate::{Phase, Request};

impl Node<'_> {
    /// Carries out a command of the operator.
    pub fn command(&mut self, command: OperatorCommand) {
        match command {
            OperatorCommand::Start => self.start(),
            OperatorCommand::Release => self.release(false),
            OperatorCommand::Return => self.order(Autopilot::return_home),
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
        self.place_told = false;
        self.muster.restart(self.swarm_link.counts().get(Rejected::IdCollision));
        self.gate.set_request(Request::Start);
        self.autopilot.restart(may_take);
    }

    /// Releases control of the vehicle. In flight it is braked first, until it stands still or for 3 s;
    /// see [`Node::is_ending`]. With `land` it is commanded to land instead.
    pub fn release(&mut self, land: bool) {
        if land {
            self.order(Autopilot::land);
        } else {
            self.end(self.gate.is_flying());
        }
    }

    /// Orders a return or a landing of a vehicle that nobody else flies.
    fn order(&mut self, order: fn(&mut Autopilot, i64)) {
        self.end(false);
        if self.autopilot.takes_orders() {
            self.gate.set_request(Request::Return);
            order(&mut self.autopilot, self.timebase.now_ms());
        } else {
            let (mode, armed) = (self.autopilot.mode_name(), if self.autopilot.is_armed() { "" } else { "dis" });
            let text = format!("not commanded: the vehicle is {armed}armed, in {mode}, and not this node's");
            self.answers.push(Notice::warning(text));
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
