//! When things happen within a step.

/// Half the time that a ramp takes, and the delays of decision and vehicle, ms. Measured best for vehicles that
/// follow within 0.1 s as well as for those that need 0.65 s; 250 ms less or 500 ms more make no difference.
const LEAD_MS: u16 = 1500;

/// What the phases of a step wait for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// Each phase comes with the first position after its time, as in nodes that recorded no pace.
    Deadlines,
    /// A phase comes as soon as all that it awaits was heard, with a position or a neighbour's message, and at
    /// its time at the latest. A decision between two positions is flown at once.
    #[default]
    Heard,
    /// The same in a simulation that waits for an answer to every position: the answer waits for the
    /// decision, so that a flight is the same every time.
    LockStep,
}

impl Pace {
    /// All with their names, as recordings have them.
    const NAMES: [(Self, &'static str); 3] =
        [(Self::Deadlines, "deadlines"), (Self::Heard, "heard"), (Self::LockStep, "lockstep")];

    /// The name in recordings.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(pace, _)| *pace == self).map_or("", |(_, name)| name)
    }

    /// The pace of a name in a recording.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(_, known)| *known == name).map(|&(pace, _)| pace)
    }
}

/// The phases of a step, by the vehicle's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepTiming {
    /// What the phases wait for.
    pub pace: Pace,
    /// From a step's start until the UAV observes and encodes at the latest, ms.
    pub encode_ms: u16,
    /// From a step's start until it decides at the latest, ms.
    pub decide_ms: u16,
    /// Between two beacons, ms; with `None` there is one at the start of each step.
    pub beacon_ms: Option<u16>,
    /// Between two positions from the autopilot, ms.
    pub telemetry_ms: u16,
    /// A UAV counts as where its velocity takes it in this time, ms. In the scenario a velocity changes at
    /// once, a vehicle needs time for it: by so much it is behind, and gets there when it stops.
    pub lead_ms: u16,
}

impl Default for StepTiming {
    fn default() -> Self {
        Self { pace: Pace::Heard, encode_ms: 400, decide_ms: 800, beacon_ms: None, telemetry_ms: 200, lead_ms: LEAD_MS }
    }
}
