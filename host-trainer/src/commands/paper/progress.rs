//! Progress of several runs that train at the same time.

use crate::settings::Settings;
use covey_report::progress::{Mode, Progress, Status};
use std::sync::Mutex;
use std::time::Instant;

/// Progress of all runs together.
pub struct Watch {
    /// And the episodes done, by earlier processes too.
    progress: Mutex<(Progress, u64)>,
    start: Instant,
    /// Episodes done by earlier processes.
    before: u64,
    /// Agent-steps of an episode.
    steps: u64,
    quiet: bool,
}

impl Watch {
    /// Of the runs `wanted`, of which `missing` are to be trained and have `before` episodes.
    pub fn new(quiet: bool, wanted: &[Settings], missing: usize, before: u64) -> Self {
        let episodes = wanted.first().map_or(0, |s| u64::from(s.rounds()) * u64::from(s.num_envs));
        let steps = wanted.first().map_or(0, |s| u64::from(s.steps) * u64::from(s.uavs));
        let progress = Progress::new(Mode::detect(quiet), episodes * missing as u64).resumed_at(before);
        Self { progress: Mutex::new((progress, before)), start: Instant::now(), before, steps, quiet }
    }

    fn with(&self, change: impl FnOnce(&mut (Progress, u64))) {
        // Progress is only shown: another thread's panic ends the program anyway.
        if let Ok(mut shared) = self.progress.lock() {
            change(&mut shared);
        }
    }

    /// A line, unless the command is quiet.
    pub fn say(&self, message: &str) {
        if !self.quiet {
            self.with(|(progress, _)| progress.line(message));
        }
    }

    /// Counts episodes that a run has trained.
    pub fn played(&self, episodes: u64) {
        let elapsed = self.start.elapsed();
        self.with(|(progress, done)| {
            *done += episodes;
            progress.update(&Status {
                done: *done,
                elapsed,
                agent_steps_per_s: ((*done - self.before) * self.steps) as f64 / elapsed.as_secs_f64(),
                coverage: None,
                reward: None,
            });
        });
    }

    /// Ends the display.
    pub fn finish(&self) {
        self.with(|(progress, _)| progress.finish());
    }
}
