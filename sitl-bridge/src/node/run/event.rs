//! What a running node reports.

use crate::autopilot::{Notice, Stage};
use crate::node::counters::Counters;
use crate::node::decision::{Decision, StepStart};
use crate::node::status::Status;

/// An event of a running node.
#[derive(Clone, Debug)]
pub enum NodeEvent {
    /// A notice for the operator.
    Notice(Notice),
    /// It entered another stage.
    Stage(Stage),
    /// The common clock, Unix time in ms, with each [`NodeEvent::Stage`] and [`NodeEvent::Status`].
    Clock(i64),
    /// A step started.
    StepStarted(StepStart),
    /// A decision was made.
    Decision(Decision),
    /// The status, twice a second.
    Status(Box<Status>),
    /// The node has ended, with these counts.
    Ended(Box<Counters>),
}
