//! Episodes in the short form that the page carries; see `docs/report.md`, "Episodes in the page".

use super::episode::{Episode, Frame};
use serde::Serialize;

/// An episode of the page.
#[derive(Serialize)]
pub(super) struct EpisodeJson<'a> {
    title: &'a str,
    side: f32,
    ranges: [f32; 3],
    pois: Vec<Option<i32>>,
    actions: &'a [String],
    frames: Vec<FrameJson>,
}

#[derive(Serialize)]
struct FrameJson {
    #[serde(rename = "p")]
    uavs: Vec<Option<i32>>,
    #[serde(rename = "l")]
    edges: Vec<u16>,
    #[serde(rename = "c")]
    covered: String,
    #[serde(rename = "v")]
    coverage: f64,
    #[serde(rename = "a", skip_serializing_if = "Vec::is_empty")]
    actions: Vec<u8>,
}

impl<'a> From<&'a Episode> for EpisodeJson<'a> {
    fn from(episode: &'a Episode) -> Self {
        Self {
            title: &episode.title,
            side: episode.side_u,
            ranges: [episode.coverage_range_u, episode.observation_range_u, episode.communication_range_u],
            pois: hundredths(&episode.pois),
            actions: &episode.action_names,
            frames: episode.frames.iter().map(FrameJson::from).collect(),
        }
    }
}

impl From<&Frame> for FrameJson {
    fn from(frame: &Frame) -> Self {
        Self {
            uavs: hundredths(&frame.uavs),
            edges: frame.edges.iter().flatten().copied().collect(),
            covered: bits(&frame.covered),
            coverage: (f64::from(frame.coverage) * 1e4).round() / 1e4,
            actions: frame.actions.clone(),
        }
    }
}

/// Coordinates in hundredths of a unit, x and y in turn; null where not finite.
fn hundredths(positions: &[[f32; 2]]) -> Vec<Option<i32>> {
    positions.iter().flatten().map(|c| c.is_finite().then_some((c * 100.0).round() as i32)).collect()
}

/// Four flags a hexadecimal digit, the first in the lowest bit.
fn bits(flags: &[bool]) -> String {
    let digit = |four: &[bool]| {
        let value = four.iter().enumerate().map(|(i, &on)| u32::from(on) << i).sum();
        char::from_digit(value, 16).unwrap_or('0')
    };
    flags.chunks(4).map(digit).collect()
}
