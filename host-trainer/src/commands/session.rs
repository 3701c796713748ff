//! A run in training: rounds, metrics, checkpoints, and at the end the actor file and the report.

use super::hold::Hold;
use super::interrupt::Stop;
use super::meter::Meter;
use super::output::{say_out, tell};
use crate::eval::{EvalConfig, EvalPolicy, EvalRow, EvaluationFile, ReferencePolicy, Watch, table};
use crate::export::{ExportedActor, export_actor_watched, export_agent_steps};
use crate::run::{Checkpoint, RunFolder, RunLock, report};
use crate::settings::{Settings, word_of};
use crate::train::{RoundMetrics, Trainer, Workers};
use covey_report::atomic;
use covey_report::metrics::MetricsLog;
use covey_report::progress::{Mode, Progress, Status};
use covey_report::tensorboard::EventWriter;
use miette::{IntoDiagnostic, Result};
use std::time::{Instant, SystemTime};

/// Hand-written policies that a trained one is measured beside.
const BASELINES: [ReferencePolicy; 4] =
    [ReferencePolicy::Centroid, ReferencePolicy::Greedy, ReferencePolicy::Hover, ReferencePolicy::Random];

/// A run with its files open, between [`Session::open`] and [`Session::finish`].
pub struct Session {
    folder: RunFolder,
    trainer: Trainer,
    metrics: MetricsLog,
    events: EventWriter,
    progress: Progress,
    quiet: bool,
    hold: Hold,
    /// No other process may write there.
    _lock: RunLock,
}

fn now() -> f64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64())
}

impl Session {
    /// Opens the files of a new run or, `resumed`, of one that goes on.
    pub fn open(folder: RunFolder, lock: RunLock, trainer: Trainer, resumed: bool, mode: Mode) -> Result<Self> {
        let hold = Hold::from_environment()?;
        let rounds = u64::from(trainer.rounds());
        let metrics = if resumed {
            atomic::remove_leftovers(folder.path()).into_diagnostic()?;
            atomic::remove_leftovers(folder.checkpoints()).into_diagnostic()?;
            MetricsLog::resume(folder.metrics(), rounds)
        } else {
            MetricsLog::create(folder.metrics())
        }
        .into_diagnostic()?;
        let mut events = EventWriter::create(folder.events(), now()).into_diagnostic()?;
        let s = trainer.settings();
        let done = rounds * u64::from(s.num_envs);
        if rounds > 0 {
            events.resumed_at(done + 1, now()).into_diagnostic()?;
        }
        let total = u64::from(s.rounds()) * u64::from(s.num_envs);
        let progress = Progress::new(mode, total).resumed_at(done);
        Ok(Self { folder, trainer, metrics, events, progress, quiet: mode == Mode::Quiet, hold, _lock: lock })
    }

    /// Locks a run folder against other processes; do so before its checkpoint is read.
    pub fn lock(folder: &RunFolder) -> Result<RunLock> {
        RunLock::take(folder.path(), |warning| tell!("{warning}")).into_diagnostic()
    }

    /// Its folder.
    pub const fn folder(&self) -> &RunFolder {
        &self.folder
    }

    /// Episodes trained so far.
    pub fn episodes(&self) -> u64 {
        u64::from(self.trainer.rounds()) * u64::from(self.trainer.settings().num_envs)
    }

    /// A line above the progress, unless the command is quiet.
    pub fn say(&mut self, message: &str) {
        if !self.quiet {
            self.progress.line(message);
        }
    }

    /// Trains until all is done (true) or `stop` is set (false); `watch` sees every round.
    pub fn train(&mut self, workers: &Workers, stop: &Stop, mut watch: impl FnMut(&RoundMetrics)) -> Result<bool> {
        let s = self.trainer.settings().clone();
        self.say(&format!(
            "training {} for {} episodes in {} ({}, {} threads)",
            word_of(s.graph),
            s.episodes,
            self.folder.path().display(),
            self.trainer.device(),
            workers.threads()
        ));
        if self.episodes() == 0 {
            self.checkpoint()?;
        }
        let (start, before) = (Instant::now(), s.agent_steps(self.trainer.rounds()));
        let mut saved = self.episodes();
        while !self.trainer.done() && !stop.asked() {
            let row = self.trainer.round(workers).into_diagnostic()?;
            self.record(&row)?;
            let agent_steps = row.agent_steps - before;
            self.progress.update(&Status {
                done: row.episodes,
                elapsed: start.elapsed(),
                agent_steps_per_s: agent_steps as f64 / start.elapsed().as_secs_f64(),
                coverage: Some(row.coverage),
                reward: Some(row.reward),
            });
            watch(&row);
            self.hold.at_round(self.trainer.rounds());
            if row.episodes - saved >= u64::from(s.checkpoint_every) {
                self.checkpoint()?;
                saved = row.episodes;
            }
        }
        if self.episodes() > saved {
            self.checkpoint()?;
        }
        self.progress.finish();
        Ok(self.trainer.done())
    }

    fn record(&mut self, row: &RoundMetrics) -> Result<()> {
        self.metrics.append(row).into_diagnostic()?;
        for (tag, value) in row.curves() {
            self.events.scalar(tag, row.episodes, now(), value as f32).into_diagnostic()?;
        }
        self.events.flush().into_diagnostic()
    }

    fn checkpoint(&self) -> Result<()> {
        self.metrics.sync().into_diagnostic()?;
        let checkpoint = Checkpoint { settings: self.trainer.settings().to_toml(), state: self.trainer.state() };
        checkpoint.save(&self.folder.checkpoints(), self.episodes()).into_diagnostic()?;
        Ok(())
    }

    /// Quantises, measures against the baselines, writes actor file and report.
    pub fn finish(mut self) -> Result<()> {
        self.hold.at_measuring();
        let s = self.trainer.settings().clone();
        self.say(&format!("quantising, and measuring on {} held-out worlds", s.eval_worlds));
        let baselines = BASELINES.len() as u64 * EvalConfig::held_out(&s).agent_steps();
        let meter = Meter::new(self.quiet, export_agent_steps(&s) + baselines);
        let watch: Watch<'_> = &|agent_steps| meter.add(agent_steps);
        let done = export_actor_watched(&s, &self.trainer.state(), watch).into_diagnostic()?;
        atomic::write(self.folder.actor(), &done.file).into_diagnostic()?;
        let rows = rows(&s, &done, watch)?;
        drop(meter);
        let file = EvaluationFile {
            rows: rows.clone(),
            argmax_agreement: done.agreement.share(),
            decisions_compared: done.agreement.decisions,
        };
        let json = serde_json::to_string_pretty(&file).into_diagnostic()?;
        atomic::write(self.folder.evaluation(), json.as_bytes()).into_diagnostic()?;
        let page = report::write(&self.folder)?;
        if !self.quiet {
            say_out!("{}", table(&rows))?;
            say_out!(
                "int8 and float choose the same greatest logit in {:.2} % of {} decisions",
                100.0 * done.agreement.share(),
                done.agreement.decisions
            )?;
            say_out!("actor file  {} ({} bytes)", self.folder.actor().display(), done.file.len())?;
            say_out!("report      {}", page.display())?;
            say_out!("picture     {}", self.folder.picture().display())?;
            say_out!("next        host-trainer inspect {}", self.folder.actor().display())?;
            say_out!("            host-trainer eval --model {} --uavs 5,10,20", self.folder.actor().display())?;
        }
        Ok(())
    }
}

/// Trained policies and baselines on the same worlds.
fn rows(s: &Settings, done: &ExportedActor, watch: Watch<'_>) -> Result<Vec<EvalRow>> {
    let mut rows = vec![done.int8.clone(), done.float.clone()];
    let held_out = EvalConfig::held_out(s);
    for policy in BASELINES {
        rows.push(EvalPolicy::Reference(policy).evaluate_watched(policy.name(), &held_out, watch).into_diagnostic()?);
    }
    Ok(rows)
}
