//! `train`: the main job, from settings to actor file and report.

use super::device::put;
use super::{apply, cores, use_threads};
use crate::cli::{PolicyArg, Train};
use crate::finish::{EvaluationFile, Finished, actor_file, trial};
use crate::measure::{EvalRow, Subject, table};
use crate::report_page;
use crate::run::{Checkpoint, RunFolder};
use crate::settings::{Graph, Settings};
use crate::train::{RoundMetrics, Trainer, Workers};
use covey_report::atomic;
use covey_report::metrics::MetricsLog;
use covey_report::progress::{Mode, Progress, Status};
use covey_report::tensorboard::EventWriter;
use miette::{IntoDiagnostic, Result, miette};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Instant, SystemTime};

/// Exit status of a run that a signal stopped.
pub(super) const INTERRUPTED: i32 = 130;

/// Trains, or goes on training.
///
/// # Errors
/// Bad settings, a folder that cannot be used, a disk that is full: the newest
/// checkpoint stays intact.
pub fn run(args: &Train) -> Result<()> {
    // Before a run folder is made.
    if args.threads == Some(0) {
        return Err(miette!("--threads 0: use at least 1"));
    }
    let stop = stop_on_signals()?;
    let (folder, trainer) = if let Some(dir) = &args.resume {
        let folder = RunFolder::open(dir).into_diagnostic()?;
        let (settings, checkpoint) = folder.load().into_diagnostic()?;
        let trainer = Trainer::resume(settings, checkpoint.state).into_diagnostic()?;
        (folder, put(trainer, args.device)?)
    } else {
        let settings = settings(args)?;
        let trainer = put(Trainer::new(settings.clone()).into_diagnostic()?, args.device)?;
        (RunFolder::create(args.out.as_deref(), &settings).into_diagnostic()?, trainer)
    };
    let shards = trainer.settings().shards as usize;
    let threads = args.threads.unwrap_or_else(|| cores().min(shards));
    use_threads(Some(threads));
    let workers = Workers::new(threads.min(shards)).into_diagnostic()?;
    let mut session = Session::open(folder, trainer, args.resume.is_some(), Mode::detect(args.quiet))?;
    if !session.train(&workers, &stop, |_| {})? {
        session.say(&format!(
            "stopped at {} episodes; go on with: host-trainer train --resume {}",
            session.episodes(),
            session.folder.path().display()
        ));
        std::process::exit(INTERRUPTED);
    }
    session.finish()
}

fn settings(args: &Train) -> Result<Settings> {
    let mut s = Settings::default();
    if let Some(file) = &args.config {
        s.merge_file(file).into_diagnostic()?;
    }
    let named = [args.episodes.map(|e| format!("episodes={e}")), args.seed.map(|v| format!("seed={v}"))];
    let all: Vec<String> = args.set.iter().cloned().chain(named.into_iter().flatten()).collect();
    if let Some(graph) = args.graph {
        s.graph = Graph(graph.into());
    }
    apply(&mut s, &all)?;
    Ok(s)
}

/// The first Ctrl-C, SIGTERM or SIGHUP asks to stop at the end of the round, the second stops at once.
pub(super) fn stop_on_signals() -> Result<Arc<AtomicBool>> {
    // `nohup` has SIGHUP ignored, and it stays so.
    #[cfg(unix)]
    // SAFETY: changes what a signal does, and keeps what it did.
    let hangup = unsafe { libc::signal(libc::SIGHUP, libc::SIG_IGN) };
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
        eprintln!("\nstopping at the end of this round; press Ctrl-C again to stop at once");
    })
    .into_diagnostic()?;
    #[cfg(unix)]
    if hangup == libc::SIG_IGN {
        // SAFETY: as above.
        unsafe { libc::signal(libc::SIGHUP, libc::SIG_IGN) };
    }
    Ok(stop)
}

/// A run with its files open.
pub(super) struct Session {
    folder: RunFolder,
    trainer: Trainer,
    metrics: MetricsLog,
    events: EventWriter,
    progress: Progress,
    quiet: bool,
}

fn now() -> f64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64())
}

impl Session {
    /// Opens the files of a new run or, `resumed`, of one that goes on.
    pub(super) fn open(folder: RunFolder, trainer: Trainer, resumed: bool, mode: Mode) -> Result<Self> {
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
        Ok(Self { folder, trainer, metrics, events, progress, quiet: mode == Mode::Quiet })
    }

    pub(super) fn episodes(&self) -> u64 {
        u64::from(self.trainer.rounds()) * u64::from(self.trainer.settings().num_envs)
    }

    fn say(&mut self, message: &str) {
        if !self.quiet {
            self.progress.line(message);
        }
    }

    /// Trains until all is done (true) or `stop` is set (false); `watch` sees every round.
    pub(super) fn train(
        &mut self,
        workers: &Workers,
        stop: &AtomicBool,
        mut watch: impl FnMut(&RoundMetrics),
    ) -> Result<bool> {
        let s = self.trainer.settings().clone();
        self.say(&format!(
            "training {} for {} episodes in {} ({}, {} threads)",
            s.graph.0.name(),
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
        while !self.trainer.done() && !stop.load(Ordering::SeqCst) {
            let row = self.trainer.round(workers).into_diagnostic()?;
            self.record(&row)?;
            let agent_steps = row.agent_steps - before;
            self.progress.update(&Status {
                episodes: row.episodes,
                elapsed: start.elapsed(),
                agent_steps_per_s: agent_steps as f64 / start.elapsed().as_secs_f64(),
                coverage: Some(row.coverage),
                reward: Some(row.reward),
            });
            watch(&row);
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
    pub(super) fn finish(mut self) -> Result<()> {
        let s = self.trainer.settings().clone();
        self.say(&format!("quantising, and measuring on {} held-out worlds", s.eval_worlds));
        let done = actor_file(&s, &self.trainer.state()).into_diagnostic()?;
        atomic::write(self.folder.actor(), &done.file).into_diagnostic()?;
        let rows = rows(&s, &done)?;
        let file =
            EvaluationFile { rows: rows.clone(), argmax_agreement: done.agreement, decisions_compared: done.compared };
        let json = serde_json::to_string_pretty(&file).into_diagnostic()?;
        atomic::write(self.folder.evaluation(), json.as_bytes()).into_diagnostic()?;
        let page = report_page::write(&self.folder)?;
        if !self.quiet {
            println!("{}", table(&rows));
            println!(
                "int8 and float choose the same greatest logit in {:.2} % of {} decisions",
                100.0 * done.agreement,
                done.compared
            );
            println!("actor file  {} ({} bytes)", self.folder.actor().display(), done.file.len());
            println!("report      {}", page.display());
            println!("picture     {}", self.folder.picture().display());
            println!("next        host-trainer inspect {}", self.folder.actor().display());
            println!("            host-trainer eval --model {} --uavs 5,10,20", self.folder.actor().display());
        }
        Ok(())
    }
}

/// Trained policies and baselines on the same worlds.
fn rows(s: &Settings, done: &Finished) -> Result<Vec<EvalRow>> {
    let mut rows = vec![done.int8.clone(), done.float.clone()];
    for policy in [PolicyArg::Centroid, PolicyArg::Greedy, PolicyArg::Hover, PolicyArg::Random] {
        rows.push(Subject::Written(policy).measure(policy.name(), &trial(s)).into_diagnostic()?);
    }
    Ok(rows)
}
