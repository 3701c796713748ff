//! A node's status for people.

use crate::autopilot::Stage;
use firmware_core::gate::Reason;
use firmware_core::geometry::State;

/// The status of a node, for a table or a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// The UAV's id.
    pub id: u16,
    /// How far the work with the autopilot has come.
    pub stage: Stage,
    /// Name of the flight mode, as users know it.
    pub mode: String,
    /// Name of the safety gate's last verdict.
    pub gate: &'static str,
    /// The verdict's reason, where it has one.
    pub reason: Option<Reason>,
    /// Position and velocity on the map, ticks and ticks/step.
    pub state: Option<State>,
    /// Altitude above the mission's origin, m.
    pub altitude_m: Option<f64>,
    /// Number of the step under way.
    pub step: Option<u32>,
    /// Age of the autopilot's last message by the host's clock, ms.
    pub link_ms: Option<u64>,
    /// Age of the last message taken from another UAV by the host's clock, ms.
    pub swarm_ms: Option<u64>,
    /// Number of neighbours in the table, and of those in range when last observed.
    pub neighbours: (usize, usize),
    /// Remaining charge, percent.
    pub battery: Option<u8>,
}
