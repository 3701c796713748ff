//! What a running node is given: its links, and what controls it from outside.

use crate::connection::Connection;
use crate::node::operator::OperatorCommand;
use crate::swarm_link::SwarmSocket;
use crate::tlog::TlogWriter;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64};
use std::sync::mpsc::Receiver;

/// A node's links.
#[derive(Debug)]
pub struct Links {
    /// The link to the autopilot.
    pub autopilot: Connection,
    /// The link to the swarm; a UAV can fly alone.
    pub swarm: Option<SwarmSocket>,
    /// A recording of both.
    pub tlog: Option<TlogWriter>,
}

/// Controls a running node from other threads.
#[derive(Debug)]
pub struct RunControl {
    /// Ends the flight once it is set.
    pub stop: Arc<AtomicBool>,
    /// Whether the vehicle is commanded to land at the end.
    pub land: bool,
    /// Whether it is braked at the end before it is let go. A simulation that ends with its vehicles needs
    /// no braking.
    pub brake: bool,
    /// When step 0 starts, Unix time in ms: [`RunControl::OWN_EPOCH`] for the mission's epoch,
    /// [`RunControl::NO_EPOCH`] for never.
    pub epoch_ms: Arc<AtomicI64>,
    /// The operator's commands.
    pub commands: Option<Receiver<OperatorCommand>>,
}

impl RunControl {
    /// The mission's own epoch.
    pub const OWN_EPOCH: i64 = i64::MIN;
    /// No steps yet.
    pub const NO_EPOCH: i64 = i64::MAX;

    /// A control that ends the flight with `stop`, with the mission's own epoch and no operator.
    #[must_use]
    pub fn new(stop: Arc<AtomicBool>, land: bool) -> Self {
        Self { stop, land, brake: true, epoch_ms: Arc::new(AtomicI64::new(Self::OWN_EPOCH)), commands: None }
    }
}
