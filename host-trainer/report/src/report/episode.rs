//! Episodes as callers give them, and as the page carries them.

use serde::{Deserialize, Serialize};

use super::ReportError;

/// One flight, step by step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// What flies where: `GCN, int8, world 10`.
    pub title: String,
    /// Side of the square map, u.
    pub side_u: f32,
    /// A PoI this near a UAV is covered, u.
    pub coverage_range_u: f32,
    /// A PoI this near is seen, u.
    pub observation_range_u: f32,
    /// UAVs this near each other are linked, u.
    pub communication_range_u: f32,
    /// Places of the PoIs, u east and north.
    pub pois: Vec<[f32; 2]>,
    /// What the action indices mean; may be empty.
    pub action_names: Vec<String>,
    /// The spawn state, then the state after each step.
    pub frames: Vec<Frame>,
}

/// The state after one step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Places of the UAVs, u east and north; NaN for one that is not there.
    pub uavs: Vec<[f32; 2]>,
    /// Pairs of UAVs that hear each other.
    pub links: Vec<[u16; 2]>,
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

    /// Whether lists that belong together agree.
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
            return Err(number("the place of every PoI", false));
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
            if let Some(&link) = frame.links.iter().find(|l| l.iter().any(|&i| usize::from(i) >= uavs)) {
                return Err(ReportError::Link { episode: episode(), step, link, uavs });
            }
            if !frame.coverage.is_finite() {
                return Err(number("the coverage of every step", false));
            }
        }
        Ok(())
    }

    /// The episode in the page's short form.
    pub(super) fn compact(&self) -> Compact<'_> {
        let frame = |f: &Frame| CompactFrame {
            uavs: hundredths(&f.uavs),
            links: f.links.iter().flatten().copied().collect(),
            covered: bits(&f.covered),
            coverage: (f64::from(f.coverage) * 1e4).round() / 1e4,
            actions: f.actions.clone(),
        };
        Compact {
            title: &self.title,
            side: self.side_u,
            ranges: [self.coverage_range_u, self.observation_range_u, self.communication_range_u],
            pois: hundredths(&self.pois),
            actions: &self.action_names,
            frames: self.frames.iter().map(frame).collect(),
        }
    }
}

/// See `docs/report.md`, "Episodes in the page".
#[derive(Serialize)]
pub(super) struct Compact<'a> {
    title: &'a str,
    side: f32,
    ranges: [f32; 3],
    pois: Vec<Option<i32>>,
    actions: &'a [String],
    frames: Vec<CompactFrame>,
}

#[derive(Serialize)]
struct CompactFrame {
    #[serde(rename = "p")]
    uavs: Vec<Option<i32>>,
    #[serde(rename = "l")]
    links: Vec<u16>,
    #[serde(rename = "c")]
    covered: String,
    #[serde(rename = "v")]
    coverage: f64,
    #[serde(rename = "a", skip_serializing_if = "Vec::is_empty")]
    actions: Vec<u8>,
}

/// Coordinates in hundredths of a unit, x and y in turn; null where not finite.
fn hundredths(places: &[[f32; 2]]) -> Vec<Option<i32>> {
    places.iter().flatten().map(|c| c.is_finite().then_some((c * 100.0).round() as i32)).collect()
}

/// Four flags a hexadecimal digit, the first in the lowest bit.
fn bits(flags: &[bool]) -> String {
    let digit = |four: &[bool]| {
        let value = four.iter().enumerate().map(|(i, &on)| u32::from(on) << i).sum();
        char::from_digit(value, 16).unwrap_or('0')
    };
    flags.chunks(4).map(digit).collect()
}
