//! Episodes as callers pass them.

use super::error::ReportError;
use serde::{Deserialize, Serialize};

/// A recorded episode, step by step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// Policy and world: `GCN, int8, world 10`.
    pub title: String,
    /// Side of the square map, u.
    pub side_u: f32,
    /// Coverage range, u.
    pub coverage_range_u: f32,
    /// Observation range, u.
    pub observation_range_u: f32,
    /// Communication range, u.
    pub communication_range_u: f32,
    /// Positions of the PoIs, (east, north) in u.
    pub pois: Vec<[f32; 2]>,
    /// What the action indices mean; may be empty.
    pub action_names: Vec<String>,
    /// The spawn state, then the state after each step.
    pub frames: Vec<Frame>,
}

/// The state after one step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Positions of the UAVs, (east, north) in u; NaN for one that is not there.
    pub uavs: Vec<[f32; 2]>,
    /// Edges of the communication graph: pairs of UAVs in range of each other.
    pub edges: Vec<[u16; 2]>,
    /// Whether each PoI is covered now.
    pub covered: Vec<bool>,
    /// Share of the PoIs covered now, 0 to 1.
    pub coverage: f32,
    /// The action each UAV took to get here, if known; empty otherwise.
    pub actions: Vec<u8>,
}

impl Episode {
    /// Steps flown: frames without the spawn state.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.frames.len().saturating_sub(1)
    }

    /// Coverage index of the first `steps` steps: the mean over the states after a
    /// step; the spawn state is not scored. 0 before the first step.
    #[must_use]
    pub fn coverage_so_far(&self, steps: usize) -> f32 {
        let scored = self.frames.get(1..).unwrap_or_default();
        let scored = &scored[..steps.min(scored.len())];
        if scored.is_empty() { 0.0 } else { scored.iter().map(|f| f.coverage).sum::<f32>() / scored.len() as f32 }
    }

    /// Checks that its numbers are finite and its lists agree in length.
    pub(super) fn check(&self) -> Result<(), ReportError> {
        let episode = || self.title.clone();
        let number = |what, positive| ReportError::Number { episode: episode(), what, positive };
        let lengths = [
            ("the side of the map", self.side_u),
            ("the coverage range", self.coverage_range_u),
            ("the observation range", self.observation_range_u),
            ("the communication range", self.communication_range_u),
        ];
        if let Some((what, _)) = lengths.iter().find(|(_, l)| !(l.is_finite() && *l > 0.0)) {
            return Err(number(what, true));
        }
        if !self.pois.iter().flatten().all(|c| c.is_finite()) {
            return Err(number("the position of every PoI", false));
        }
        let uavs = self.frames.first().ok_or_else(|| ReportError::NoFrames { episode: episode() })?.uavs.len();
        for (step, frame) in self.frames.iter().enumerate() {
            let length =
                |what, found, expected| ReportError::Length { episode: episode(), step, what, found, expected };
            if frame.uavs.len() != uavs {
                return Err(length("UAVs", frame.uavs.len(), uavs));
            }
            if frame.covered.len() != self.pois.len() {
                return Err(length("PoI states", frame.covered.len(), self.pois.len()));
            }
            if !frame.actions.is_empty() && frame.actions.len() != uavs {
                return Err(length("actions", frame.actions.len(), uavs));
            }
            if let Some(&edge) = frame.edges.iter().find(|l| l.iter().any(|&i| usize::from(i) >= uavs)) {
                return Err(ReportError::Edge { episode: episode(), step, edge, uavs });
            }
            if !frame.coverage.is_finite() {
                return Err(number("the coverage of every step", false));
            }
        }
        Ok(())
    }
}
