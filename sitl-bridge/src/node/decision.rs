//! Records of a node's steps and decisions.

use firmware_core::geometry::State;
use firmware_core::hash::Fnv1a;
use firmware_core::observation::{MAX_NEIGHBOURS, Observation};

/// A step that began, and the state that was measured then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepStart {
    /// Number of the step.
    pub step: u32,
    /// Position and velocity at the first odometry of the step, ticks and ticks/step.
    pub state: State,
    /// The common clock then: Unix time, ms.
    pub common_ms: i64,
}

/// A decision and what it rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// Number of the step.
    pub step: u32,
    /// `time_boot_ms` of the odometry at which it was made.
    pub boot_ms: u32,
    /// Time since the step's start by the common clock, ms.
    pub phase_ms: u32,
    /// The observed state, ticks and ticks/step: the one measured at the step's start, ahead by
    /// [`super::StepTiming::lead_ms`].
    pub state: State,
    /// [`observation_hash`] of the observation.
    pub observation: u64,
    neighbours: [u16; MAX_NEIGHBOURS],
    count: u8,
    /// Number of neighbours whose features were aggregated.
    pub features: u8,
    /// Index of the action, 0 to 16.
    pub action: u8,
    /// Whether it was made more than a telemetry period after [`super::StepTiming::decide_ms`].
    pub late: bool,
}

impl Decision {
    /// A decision to coast, without neighbours; to be filled in.
    pub(super) const fn new(step: u32, state: State, observation: u64) -> Self {
        let neighbours = [0; MAX_NEIGHBOURS];
        let (boot_ms, phase_ms, count, features, action, late) = (0, 0, 0, 0, 16, false);
        Self { step, boot_ms, phase_ms, state, observation, neighbours, count, features, action, late }
    }

    pub(super) fn set_neighbours(&mut self, ids: impl Iterator<Item = u16>) {
        self.count = 0;
        for (slot, id) in self.neighbours.iter_mut().zip(ids) {
            *slot = id;
            self.count += 1;
        }
    }

    /// Ids of the observed neighbours, nearest first.
    #[must_use]
    pub fn neighbours(&self) -> &[u16] {
        &self.neighbours[..usize::from(self.count)]
    }
}

/// FNV-1a over an observation: the same on every computer, and enough to tell two observations apart.
#[must_use]
pub fn observation_hash(observation: &Observation) -> u64 {
    let mut hash = Fnv1a::new();
    observation.iter().for_each(|v| hash.write(&v.to_le_bytes()));
    hash.finish()
}
