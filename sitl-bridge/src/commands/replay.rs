//! `replay`: a recorded flight, decided again.

use super::actor_file::flight_ready;
use super::args::{ActorArgs, TimingArgs};
use super::console::end_on_signals;
use super::mission;
use super::output::print;
use super::recorded::{Recorded, check_mission};
use crate::frame::Source;
use crate::mission::PoiMap;
use crate::node::{Node, Settings, gate_limits};
use crate::outlet::say;
use crate::replay::{RecordingError, RecordingInfo, Replay, ReplayCheck, ReplayReport, foreign};
use crate::signing::{LinkSigning, Session};
use crate::tlog::TlogReader;
use miette::{IntoDiagnostic as _, Result, WrapErr as _, miette};
use std::fs::File;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Differences told one by one; of more only the number is.
const TOLD: usize = 20;
/// Exit status when there is no answer, as of `diff`.
const TROUBLE: u8 = 2;

/// Arguments of `replay`. It ends with 0 when every decision is the same, with 1 when one
/// differs, and with 2 when the recording cannot be replayed.
#[derive(clap::Args)]
pub(crate) struct ReplayTlog {
    /// The recording, from `fly --tlog` or `swarm --tlog`.
    file: PathBuf,
    /// The mission that was flown; `swarm --sim --tlog` puts it beside the recordings.
    #[arg(long)]
    mission: PathBuf,
    /// The UAV's id, where the recording leaves a doubt.
    #[arg(long)]
    id: Option<u16>,
    /// The node's MAVLink system id, where the recording leaves a doubt.
    #[arg(long)]
    system: Option<u8>,
    /// The flight had this option too. Recordings say so themselves; those of earlier versions do not.
    #[arg(long)]
    simulated: bool,
    /// The flight had this option too.
    #[arg(long, conflicts_with = "simulated")]
    ideal: bool,
    /// Decide by this mission although the recording names another.
    #[arg(long)]
    other_mission: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    actor: ActorArgs,
    #[command(flatten)]
    timing: TimingArgs,
}

impl ReplayTlog {
    /// Replays, and says what came of it.
    pub fn run(self) -> ExitCode {
        match self.replay() {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::FAILURE,
            Err(report) => {
                say(&format!("Error: {report:?}"));
                ExitCode::from(TROUBLE)
            }
        }
    }

    fn replay(&self) -> Result<bool> {
        end_on_signals(format!("stopped replaying {}; it is as it was", self.file.display()))?;
        let (bytes, name) = self.actor.read().into_diagnostic()?;
        let actor = flight_ready(&bytes, &name).into_diagnostic()?;
        let mission = Arc::new(mission::read(&self.mission)?);
        let file = || format!("{} cannot be replayed", self.file.display());
        let open = || TlogReader::open(&self.file).into_diagnostic().wrap_err_with(file);
        let kind = File::open(&self.file).and_then(foreign).into_diagnostic().wrap_err_with(file)?;
        if let Some(kind) = kind {
            return Err(RecordingError::Foreign(kind)).into_diagnostic().wrap_err_with(file);
        }
        let info = RecordingInfo::of(&mut open()?, self.id, self.system).into_diagnostic().wrap_err_with(file)?;
        check_mission(&info, &mission, &self.mission, self.other_mission).wrap_err_with(file)?;
        let kind = if self.ideal { Some("ideal") } else { self.simulated.then_some("simulation") };
        let recorded = Recorded::of(&info, kind, &self.timing, mission.scale.step_ms).wrap_err_with(file)?;
        let feed_forward = recorded.feed_forward;
        let settings = Settings {
            id: info.id,
            system: info.system,
            vehicle_system: info.vehicle,
            actor,
            pois: Arc::new(PoiMap::new(&mission.pois)),
            timing: recorded.timing,
            limits: gate_limits(recorded.limits, &mission),
            feed_forward,
            take_off: info.took_off,
            wait_for: recorded.wait_for.unwrap_or(1),
            strict: info.flight.as_ref().and_then(|flight| flight.number::<u8>("strict")).is_some_and(|n| n != 0),
            rate_hz: recorded.rate_hz,
            source: Source::Datagrams,
            // Only what was believed is in the log.
            autopilot_signing: LinkSigning::off(),
            swarm_signing: LinkSigning::off(),
            record: false,
            advice: String::new(),
            mission: Arc::clone(&mission),
        };
        let mut node = Node::new(settings, Session::new()).into_diagnostic()?;
        if recorded.wait_for.is_none() {
            node.skip_start_checks();
        }
        let mut replay = Replay::new(node, info.clone(), ReplayCheck::new(info.id, mission.scale, feed_forward));
        for record in open()? {
            replay.feed(&record.into_diagnostic().wrap_err_with(file)?);
        }
        let report = replay.finish();
        if let Some(flown) = report.flown_actor.filter(|&flown| flown != actor.message_hash()) {
            say(&format!(
                "warning: actor {flown:08x} was flown, and {} is {:08x}: name the other with --actor",
                name.display(),
                actor.message_hash()
            ));
        }
        if info.flight.is_none() && report.counts_otherwise() {
            return Err(miette!(
                "{}: the recording counts its steps from another time than {}, whose step 0 begins at Unix time {} ms: is it the \
                 mission that was flown?",
                self.file.display(),
                self.mission.display(),
                mission.epoch_unix_ms
            ));
        }
        self.tell(&info, &report)?;
        if report.decisions == 0 && report.is_equal() {
            return Err(miette!(
                "no decision was made: mission {} begins step 0 at Unix time {} ms, and the recording has no position \
                 in the air after that; is it the mission that was flown?",
                self.mission.display(),
                mission.epoch_unix_ms
            ));
        }
        Ok(report.is_equal())
    }

    fn tell(&self, info: &RecordingInfo, report: &ReplayReport) -> Result<()> {
        if info.skipped > 0 {
            say(&format!(
                "warning: {}: {} bytes belong to no record: it is damaged, and frames are missing",
                self.file.display(),
                info.skipped
            ));
        }
        if info.cut {
            say(&format!(
                "warning: {}: it ends in the middle of a record, as after a power cut; what came before is used",
                self.file.display()
            ));
        }
        if self.json {
            let object = serde_json::json!({
                "file": self.file.to_string_lossy(), "uav": info.id, "records": info.records, "skipped_bytes": info.skipped,
                "cut": info.cut, "mission_named": info.flight.is_some(), "equal_in_all": report.is_equal(), "account": report,
            });
            return print(&format!("{}\n", serde_json::to_string_pretty(&object).into_diagnostic()?));
        }
        let mut text = format!(
            "UAV {}: {} frames, {} decisions: {} of {} as they were flown, {} without a setpoint\n",
            info.id, info.records, report.decisions, report.equal, report.compared, report.without_setpoint
        );
        text.extend(report.differences.iter().take(TOLD).map(|difference| format!("{difference}\n")));
        if report.differences.len() > TOLD {
            text += &format!("and {} more\n", report.differences.len() - TOLD);
        }
        print(&text)
    }
}
