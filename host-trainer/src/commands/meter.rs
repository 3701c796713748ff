//! How far a measurement is, and how long it will take.

use covey_report::progress::{Mode, Progress, Status};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// A log gets a line whenever so much more is done, percent.
const EVERY_PERCENT: u32 = 10;
/// The progress is looked at so often in a measurement.
const LOOKS: u64 = 1000;

/// Counts the agent-steps of a measurement, from all threads, and shows them. Dropped, it ends the display.
pub struct Meter {
    progress: Mutex<Progress>,
    total: u64,
    flown: AtomicU64,
    start: Instant,
}

impl Meter {
    /// For a measurement of so many agent-steps.
    pub fn new(quiet: bool, agent_steps: u64) -> Self {
        let mode = match Mode::detect(quiet) {
            Mode::Plain { .. } => Mode::Plain { every_percent: EVERY_PERCENT },
            other => other,
        };
        Self {
            progress: Mutex::new(Progress::new(mode, agent_steps).counting("agent-steps")),
            total: agent_steps,
            flown: AtomicU64::new(0),
            start: Instant::now(),
        }
    }

    /// Takes note of more.
    pub fn add(&self, agent_steps: u64) {
        let before = self.flown.fetch_add(agent_steps, Ordering::Relaxed);
        let look = |flown: u64| u128::from(flown) * u128::from(LOOKS) / u128::from(self.total.max(1));
        if look(before) < look(before + agent_steps) {
            self.with(|progress| {
                // Another thread may have shown more meanwhile.
                let done = self.flown.load(Ordering::Relaxed);
                let elapsed = self.start.elapsed();
                let agent_steps_per_s = done as f64 / elapsed.as_secs_f64();
                progress.update(&Status { done, elapsed, agent_steps_per_s, ..Status::default() });
            });
        }
    }

    /// A line above the progress.
    pub fn say(&self, line: &str) {
        self.with(|progress| progress.line(line));
    }

    fn with(&self, change: impl FnOnce(&mut Progress)) {
        // Progress is only shown: a thread that failed meanwhile spoils nothing.
        change(&mut self.progress.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Drop for Meter {
    fn drop(&mut self) {
        self.with(Progress::clear);
    }
}
