//! The settings of a recorded flight: from the recording where it has them, else from the options.

use super::args::TimingArgs;
use super::mission::hexadecimal;
use crate::mission::Mission;
use crate::node::{FeedForward, Pace, StepTiming};
use crate::outlet::say;
use crate::replay::RecordingInfo;
use crate::tlog::Flight;
use firmware_core::gate::Limits;
use miette::{Result, miette};
use std::path::Path;

/// Settings that decisions and setpoints depend on.
#[derive(Debug)]
pub(super) struct Recorded {
    pub limits: Limits,
    pub feed_forward: FeedForward,
    pub timing: StepTiming,
    pub rate_hz: f64,
    /// Nothing in recordings from before there were start checks.
    pub wait_for: Option<u16>,
}

impl Recorded {
    /// `kind` is what the options say: `simulation`, `ideal` or nothing.
    ///
    /// # Errors
    /// The options contradict the recording, or each other.
    pub(super) fn of(info: &RecordingInfo, kind: Option<&str>, timing: &TimingArgs, step_ms: u16) -> Result<Self> {
        let Some(flight) = &info.flight else {
            let (limits, feed_forward) = by_name(kind.unwrap_or("flight"));
            let rate_hz = f64::from(timing.rate_hz());
            let timing = StepTiming { pace: Pace::Deadlines, lead_ms: 0, ..timing.timing(step_ms)? };
            return Ok(Self { limits, feed_forward, timing, rate_hz, wait_for: None });
        };
        let flown = flight.get("limits").unwrap_or("flight");
        if let Some(kind) = kind.filter(|&kind| kind != flown) {
            return Err(miette!(
                "the recording says that it was flown as {flown}, and the options say {kind}: leave them out"
            ));
        }
        let recorded = recorded_timing(flight)
            .ok_or_else(|| miette!("the recording's own settings lack a time; is it from a later version?"))?;
        let rate_hz = flight.number("rate_hz").unwrap_or_else(|| f64::from(timing.rate_hz()));
        let named = StepTiming { pace: recorded.pace, ..timing.timing(step_ms)? };
        if !timing.is_default() && (named != recorded || f64::from(timing.rate_hz()) != rate_hz) {
            return Err(miette!(
                "the recording says --encode-ms {} --decide-ms {} --lead-ms {} --rate-hz {rate_hz}{}, and the options say \
                 otherwise: leave them out",
                recorded.encode_ms,
                recorded.decide_ms,
                recorded.lead_ms,
                recorded.beacon_ms.map(|ms| format!(" and a beacon every {ms} ms")).unwrap_or_default()
            ));
        }
        let (limits, feed_forward) = by_name(flown);
        let wait_for = flight.number("wait_for");
        Ok(Self { limits, feed_forward, timing: recorded, rate_hz, wait_for })
    }
}

fn by_name(kind: &str) -> (Limits, FeedForward) {
    match kind {
        "ideal" => (Limits::ideal(), FeedForward::Action),
        "simulation" => (Limits::simulation(), FeedForward::Ramp),
        _ => (Limits::default(), FeedForward::Ramp),
    }
}

fn recorded_timing(flight: &Flight) -> Option<StepTiming> {
    // Earlier versions, which say nothing of it, decided at positions after the deadlines.
    let pace = flight.get("pace").map_or(Some(Pace::Deadlines), Pace::of_name)?;
    let beacon_ms = flight.number("beacon_ms").filter(|&ms| ms > 0);
    let lead_ms = flight.number("lead_ms").unwrap_or(0);
    let (encode_ms, decide_ms) = (flight.number("encode_ms")?, flight.number("decide_ms")?);
    Some(StepTiming { pace, lead_ms, encode_ms, decide_ms, beacon_ms, telemetry_ms: flight.number("telemetry_ms")? })
}

/// Refuses a mission that was not flown; without a word in the recording it is taken at its word.
///
/// # Errors
/// It is another mission, or it begins at another time.
pub(super) fn check_mission(info: &RecordingInfo, mission: &Mission, path: &Path, other: bool) -> Result<()> {
    let path = path.display();
    let Some(flown) = info.flight.as_ref().and_then(|flight| flight.get("mission")) else {
        say(&format!(
            "warning: the recording, of an earlier version, does not say which mission was flown; {path} is taken for it"
        ));
        return Ok(());
    };
    let ours = hexadecimal(&mission.hash());
    if other {
        if flown != ours {
            say(&format!("warning: mission {} was flown, and {path} is {}", short(flown), short(&ours)));
        }
        return Ok(());
    }
    if flown != ours {
        return Err(miette!(
            "mission {} was flown, and {path} is mission {}: name the one that was flown (`sitl-bridge mission check FILE` prints \
             a mission's hash, and `swarm --sim --tlog` puts it beside the recordings), or see what would be decided by this one \
             with --other-mission",
            short(flown),
            short(&ours)
        ));
    }
    match info.epoch_ms {
        Some(epoch_ms) if epoch_ms != mission.epoch_unix_ms => Err(miette!(
            "step 0 began at Unix time {epoch_ms} ms, and in {path} at {} ms: is it the mission that was flown? With \
             --other-mission steps are counted as they were flown",
            mission.epoch_unix_ms
        )),
        _ => Ok(()),
    }
}

/// Enough of a hash to tell two apart.
fn short(hash: &str) -> &str {
    hash.get(..12).unwrap_or(hash)
}
