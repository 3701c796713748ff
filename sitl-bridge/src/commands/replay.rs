//! `replay`: a recorded flight, decided again.

use super::actor_file::flight_ready;
use super::args::{ActorArgs, TimingArgs};
use crate::frame::Source;
use crate::mission::{Mission, PoiMap};
use crate::node::{FeedForward, Node, Settings, gate_limits};
use crate::replay::{RecordingInfo, Replay, ReplayCheck, ReplayReport};
use crate::signing::{LinkSigning, Session};
use crate::tlog::TlogReader;
use firmware_core::gate::Limits;
use miette::{IntoDiagnostic as _, Result, WrapErr as _, miette};
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
    /// The flight had this option too.
    #[arg(long)]
    simulated: bool,
    /// The flight had this option too.
    #[arg(long, conflicts_with = "simulated")]
    ideal: bool,
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
                eprintln!("Error: {report:?}");
                ExitCode::from(TROUBLE)
            }
        }
    }

    fn replay(&self) -> Result<bool> {
        let (bytes, name) = self.actor.read().into_diagnostic()?;
        let actor = flight_ready(&bytes, &name).into_diagnostic()?;
        let mission = Arc::new(Mission::read(&self.mission).into_diagnostic()?);
        let file = || format!("{} cannot be replayed", self.file.display());
        let open = || TlogReader::open(&self.file).into_diagnostic().wrap_err_with(file);
        let info = RecordingInfo::of(&mut open()?, self.id, self.system).into_diagnostic().wrap_err_with(file)?;
        let base = if self.ideal {
            Limits::ideal()
        } else if self.simulated {
            Limits::simulation()
        } else {
            Limits::default()
        };
        let feed_forward = if self.ideal { FeedForward::Action } else { FeedForward::Ramp };
        let settings = Settings {
            id: info.id,
            system: info.system,
            vehicle_system: info.vehicle,
            actor,
            pois: Arc::new(PoiMap::new(&mission.pois)),
            timing: self.timing.timing(mission.scale.step_ms)?,
            limits: gate_limits(base, &mission),
            feed_forward,
            take_off: info.took_off,
            rate_hz: f64::from(self.timing.rate_hz()),
            source: Source::Datagrams,
            // Only what was believed is in the log.
            autopilot_signing: LinkSigning::off(),
            swarm_signing: LinkSigning::off(),
            record: false,
            advice: String::new(),
            mission: Arc::clone(&mission),
        };
        let node = Node::new(settings, Session::new()).into_diagnostic()?;
        let mut replay = Replay::new(node, info, ReplayCheck::new(info.id, mission.scale, feed_forward));
        for record in open()? {
            replay.feed(&record.into_diagnostic().wrap_err_with(file)?);
        }
        let report = replay.finish();
        if let Some(flown) = report.flown_actor.filter(|&flown| flown != actor.message_hash()) {
            eprintln!(
                "warning: actor {flown:08x} was flown, and {} is {:08x}: name the other with --actor",
                name.display(),
                actor.message_hash()
            );
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
            eprintln!(
                "warning: {}: {} bytes belong to no record: it is damaged, and frames are missing",
                self.file.display(),
                info.skipped
            );
        }
        if info.cut {
            eprintln!(
                "warning: {}: it ends in the middle of a record, as after a power cut; what came before is used",
                self.file.display()
            );
        }
        if self.json {
            let object = serde_json::json!({
                "file": self.file, "uav": info.id, "records": info.records, "skipped_bytes": info.skipped,
                "cut": info.cut, "equal_in_all": report.is_equal(), "account": report,
            });
            println!("{}", serde_json::to_string_pretty(&object).into_diagnostic()?);
            return Ok(());
        }
        println!(
            "UAV {}: {} frames, {} decisions: {} of {} as they were flown, {} without a setpoint",
            info.id, info.records, report.decisions, report.equal, report.compared, report.without_setpoint
        );
        report.differences.iter().take(TOLD).for_each(|difference| println!("{difference}"));
        if report.differences.len() > TOLD {
            println!("and {} more", report.differences.len() - TOLD);
        }
        Ok(())
    }
}
