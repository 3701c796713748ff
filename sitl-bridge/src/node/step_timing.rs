//! When things happen within a step.

/// The phases of a step, by the vehicle's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepTiming {
    /// From a step's start until the UAV observes and encodes, ms.
    pub encode_ms: u16,
    /// From a step's start until it decides, ms.
    pub decide_ms: u16,
    /// Between two beacons, ms; with `None` there is one at the start of each step.
    pub beacon_ms: Option<u16>,
    /// Between two positions from the autopilot, ms.
    pub telemetry_ms: u16,
}

impl Default for StepTiming {
    fn default() -> Self {
        Self { encode_ms: 400, decide_ms: 800, beacon_ms: None, telemetry_ms: 200 }
    }
}
