//! `train`: the main job, from settings to actor file and report.

use super::device::put;
use super::interrupt::{INTERRUPTED, SAVING, Stop};
use super::session::Session;
use super::settings::{apply, warn};
use super::threads::{cores, use_threads};
use crate::cli::Train;
use crate::run::RunFolder;
use crate::settings::Settings;
use crate::train::{Trainer, Workers};
use covey_report::progress::Mode;
use miette::{IntoDiagnostic, Result, miette};

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
    let stop = Stop::on_signals()?;
    stop.at_once("stopped before training; nothing was begun".into());
    let (folder, lock, trainer) = if let Some(dir) = &args.resume {
        let folder = RunFolder::open(dir).into_diagnostic()?;
        let lock = Session::lock(&folder)?;
        let (settings, checkpoint) = folder.load().into_diagnostic()?;
        let trainer = Trainer::resume(settings, checkpoint.state).into_diagnostic()?;
        (folder, lock, put(trainer, args.device)?)
    } else {
        let settings = settings(args)?;
        let trainer = put(Trainer::new(settings.clone()).into_diagnostic()?, args.device)?;
        let folder = RunFolder::create(args.out.as_deref(), &settings).into_diagnostic()?;
        let lock = Session::lock(&folder)?;
        (folder, lock, trainer)
    };
    let shards = trainer.settings().shards as usize;
    let threads = args.threads.unwrap_or_else(|| cores().min(shards));
    use_threads(Some(threads));
    let workers = Workers::new(threads.min(shards)).into_diagnostic()?;
    let mut session = Session::open(folder, lock, trainer, args.resume.is_some(), Mode::detect(args.quiet))?;
    let how = format!("host-trainer train --resume {}", session.folder().path().display());
    let trained = {
        let _saving = stop.waits(SAVING);
        session.train(&workers, &stop, |_| {})?
    };
    if !trained {
        session.say(&format!("stopped at {} episodes; go on with: {how}", session.episodes()));
        // Takes off the lock.
        drop(session);
        std::process::exit(INTERRUPTED);
    }
    stop.at_once(format!("stopped while quantising and measuring; training is done and saved; go on with: {how}"));
    stop.end_if_signalled();
    session.finish()
}

fn settings(args: &Train) -> Result<Settings> {
    let mut s = Settings::default();
    if let Some(file) = &args.config {
        warn(s.merge_file(file).into_diagnostic()?);
    }
    let named = [args.episodes.map(|e| format!("episodes={e}")), args.seed.map(|v| format!("seed={v}"))];
    let all: Vec<String> = args.set.iter().cloned().chain(named.into_iter().flatten()).collect();
    if let Some(graph) = args.graph {
        s.graph = graph;
    }
    apply(&mut s, &all)?;
    Ok(s)
}
