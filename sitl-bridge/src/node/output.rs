//! What a node returns: frames to send and what to report.

use super::decision::{Decision, StepStart};
use crate::autopilot::Notice;
use crate::frame::Frame;

/// What a node wants sent and reported. Whoever did it clears this.
#[derive(Debug, Default)]
pub struct NodeOutput {
    /// Frames for the swarm. They are to be sent before those for the autopilot: a simulator in
    /// lock-step goes on once those have arrived.
    pub to_swarm: Vec<Frame>,
    /// Frames for the autopilot.
    pub to_autopilot: Vec<Frame>,
    /// Authentic frames that were received, for a recording.
    pub received: Vec<Frame>,
    /// Notices for the operator.
    pub notices: Vec<Notice>,
    /// Steps that began.
    pub steps: Vec<StepStart>,
    /// Decisions that were made.
    pub decisions: Vec<Decision>,
}

impl NodeOutput {
    /// Empties it.
    pub fn clear(&mut self) {
        self.to_swarm.clear();
        self.to_autopilot.clear();
        self.received.clear();
        self.notices.clear();
        self.steps.clear();
        self.decisions.clear();
    }
}
