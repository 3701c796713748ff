//! Trains the runs that are missing, several at a time.

use super::progress::Watch;
use crate::cli::ExperimentPaper;
use crate::commands::interrupt::{SAVING, Stop};
use crate::commands::session::Session;
use crate::experiments::paper::{Run, check, finished, folder_of, run_name, runs};
use crate::run::{CheckpointError, FolderError, RunFolder};
use crate::settings::Settings;
use crate::train::{Trainer, Workers};
use covey_report::progress::Mode;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::Path;
use std::sync::Mutex;

/// Trains all runs that are not finished. False when it was stopped.
pub fn train(args: &ExperimentPaper, wanted: &[Settings], threads: usize, stop: &Stop) -> Result<bool> {
    let folder = folder_of(&args.out, args.settings);
    let present = runs(&args.out, args.settings).into_diagnostic()?;
    if let Some(settings) = wanted.first() {
        check(&present, settings).into_diagnostic()?;
    }
    let missing: Vec<&Settings> =
        wanted.iter().filter(|s| !present.iter().any(|r| is_run_of(r, s) && finished(&r.folder))).collect();
    let jobs = args.jobs.unwrap_or(threads).clamp(1, missing.len().max(1));
    let resumed = missing.iter().filter_map(|s| present.iter().find(|r| is_run_of(r, s)));
    let watch = Watch::new(args.quiet, wanted, missing.len(), resumed.map(episodes_done).sum());
    watch.say(&format!(
        "{} of {} runs to train in {}, {jobs} at a time with {} threads each",
        missing.len(),
        wanted.len(),
        folder.display(),
        (threads / jobs).max(1)
    ));
    let queue = Mutex::new(missing.into_iter());
    let work = || -> Result<bool> {
        let workers = Workers::new((threads / jobs).max(1)).into_diagnostic()?;
        loop {
            let next = queue.lock().ok().and_then(|mut q| q.next());
            let Some(settings) = next else { return Ok(true) };
            let path = folder.join(run_name(settings));
            let ended = train_run(&path, settings, &workers, stop, &watch).wrap_err_with(|| path.display().to_string());
            if ended.is_err() {
                // The others save and stop too.
                stop.fail();
            }
            if !ended? {
                return Ok(false);
            }
        }
    };
    let ended: Vec<Result<bool>> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
        handles.into_iter().map(|h| h.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    });
    watch.finish();
    ended.into_iter().try_fold(true, |all, one| Ok(all & one?))
}

fn is_run_of(run: &Run, settings: &Settings) -> bool {
    run.settings.graph == settings.graph && run.settings.seed == settings.seed
}

/// Episodes of a run that are in its newest checkpoint.
fn episodes_done(run: &Run) -> u64 {
    let rounds = run.folder.load().map_or(0, |(_, checkpoint)| u64::from(checkpoint.state.rounds));
    rounds * u64::from(run.settings.num_envs)
}

/// Trains one run to its end, from its newest checkpoint where it has one. False when stopped.
fn train_run(path: &Path, settings: &Settings, workers: &Workers, stop: &Stop, watch: &Watch) -> Result<bool> {
    if stop.asked() {
        return Ok(false);
    }
    let loaded = match RunFolder::open(path) {
        Ok(folder) => {
            let lock = Session::lock(&folder)?;
            match folder.load() {
                Ok((_, checkpoint)) => Some((folder, lock, checkpoint)),
                // Cut off before its first checkpoint: nothing is lost.
                Err(FolderError::Checkpoint(CheckpointError::None(_))) => {
                    std::fs::remove_dir_all(path).map_err(|e| miette!("cannot remove {}: {e}", path.display()))?;
                    None
                }
                Err(e) => return Err(e).into_diagnostic(),
            }
        }
        Err(_) => None,
    };
    let resumed = loaded.is_some();
    let (folder, lock, trainer) = match loaded {
        Some((folder, lock, checkpoint)) => {
            (folder, lock, Trainer::resume(settings.clone(), checkpoint.state).into_diagnostic()?)
        }
        None => {
            let trainer = Trainer::new(settings.clone()).into_diagnostic()?;
            let folder = RunFolder::create(Some(path), settings).into_diagnostic()?;
            let lock = Session::lock(&folder)?;
            (folder, lock, trainer)
        }
    };
    let mut session = Session::open(folder, lock, trainer, resumed, Mode::Quiet)?;
    let mut before = session.episodes();
    let done = {
        let _saving = stop.waits(SAVING);
        session.train(workers, stop, |row| {
            watch.played(row.episodes - before);
            before = row.episodes;
        })?
    };
    // Runs that measure are not waited for: they measure again.
    stop.end_if_signalled();
    if done {
        session.finish()?;
        watch.say(&format!("{} is done", run_name(settings)));
    }
    Ok(done)
}
