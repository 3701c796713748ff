//! Progress of a run: a bar on a terminal, plain lines in a log file, or nothing.
//!
//! Everything goes to standard error, so that standard output stays free for results. Errors of that output (a closed
//! pipe, for example) are ignored on purpose: a training of hours must not fail because its progress cannot be shown.

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// What is counted unless something else is said.
const EPISODES: &str = "episodes";

/// Where and how progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// A bar that redraws itself.
    Bar,
    /// A line whenever another `every_percent` of the episodes is done (and one for
    /// the first update and for the last episode): which lines come depends on
    /// episodes alone, never on the clock.
    Plain {
        /// At least 1.
        every_percent: u32,
    },
    /// Nothing; callers print errors themselves.
    Quiet,
}

impl Mode {
    /// [`Mode::Quiet`] if asked for, else [`Mode::Bar`] when standard error is a
    /// terminal, else a line per percent.
    #[must_use]
    pub fn detect(quiet: bool) -> Self {
        match (quiet, io::stderr().is_terminal()) {
            (true, _) => Self::Quiet,
            (false, true) => Self::Bar,
            (false, false) => Self::Plain { every_percent: 1 },
        }
    }
}

/// The state of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Status {
    /// How much is done, episodes unless something else is [counted](Progress::counting); from the start of the run,
    /// not of this process.
    pub done: u64,
    /// Time this process has worked on them.
    pub elapsed: Duration,
    /// Decisions of single UAVs per second.
    pub agent_steps_per_s: f64,
    /// Coverage index of the latest episodes, 0 to 1.
    pub coverage: Option<f64>,
    /// Episodic reward of the latest episodes.
    pub reward: Option<f64>,
}

/// Shows the progress of one run.
pub struct Progress {
    sink: Sink,
    total: u64,
    /// What is counted.
    unit: &'static str,
    /// Episodes that were done before this process.
    first: u64,
    /// Whether the first update was shown, and at which multiple of `every_percent`.
    shown: Option<u64>,
}

enum Sink {
    Bar(ProgressBar),
    Plain { every_percent: u64, out: Box<dyn Write + Send> },
    Quiet,
}

impl Progress {
    /// The progress of a run of `total` episodes.
    #[must_use]
    pub fn new(mode: Mode, total: u64) -> Self {
        match mode {
            Mode::Bar => Self::bar(ProgressDrawTarget::stderr(), total),
            Mode::Plain { every_percent } => Self::plain(Box::new(io::stderr()), every_percent, total),
            Mode::Quiet => Self { sink: Sink::Quiet, total, unit: EPISODES, first: 0, shown: None },
        }
    }

    /// Plain lines, written to `out`.
    #[must_use]
    pub fn plain(out: Box<dyn Write + Send>, every_percent: u32, total: u64) -> Self {
        let sink = Sink::Plain { every_percent: u64::from(every_percent.max(1)), out };
        Self { sink, total, unit: EPISODES, first: 0, shown: None }
    }

    fn bar(target: ProgressDrawTarget, total: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total), target).with_style(style(EPISODES));
        Self { sink: Sink::Bar(bar), total, unit: EPISODES, first: 0, shown: None }
    }

    /// Counts these instead of episodes.
    #[must_use]
    pub fn counting(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        if let Sink::Bar(bar) = &self.sink {
            bar.set_style(style(unit));
        }
        self
    }

    /// For a run that is resumed after `episodes` episodes: they count as done, but not in the rate from which the time
    /// left is estimated.
    #[must_use]
    pub fn resumed_at(mut self, episodes: u64) -> Self {
        self.first = episodes;
        if let Sink::Bar(bar) = &self.sink {
            bar.set_position(episodes);
        }
        self
    }

    /// Shows the state of the run; in plain mode only when a line is due.
    pub fn update(&mut self, status: &Status) {
        let left = self.time_left(status);
        match &mut self.sink {
            Sink::Bar(bar) => {
                bar.set_position(status.done);
                bar.set_message(Details { status, left }.to_string());
            }
            Sink::Plain { every_percent, out } => {
                let percent = percent(status.done, self.total);
                let mark = percent / *every_percent;
                let last = status.done >= self.total;
                if self.shown.is_none_or(|shown| mark > shown) || (last && self.shown != Some(u64::MAX)) {
                    let details = Details { status, left };
                    let _ = writeln!(out, "{percent:3} %  {}/{} {}  {details}", status.done, self.total, self.unit);
                    // After the last line no further one is due.
                    self.shown = Some(if last { u64::MAX } else { mark });
                }
            }
            Sink::Quiet => {}
        }
    }

    /// Shows a message on a line of its own: a checkpoint, a warning.
    pub fn line(&mut self, message: &str) {
        match &mut self.sink {
            Sink::Bar(bar) => bar.println(message),
            Sink::Plain { out, .. } => {
                let _ = writeln!(out, "{message}");
            }
            Sink::Quiet => {}
        }
    }

    /// Ends the display; a bar is taken away.
    pub fn clear(&mut self) {
        match &mut self.sink {
            Sink::Bar(bar) => bar.finish_and_clear(),
            Sink::Plain { .. } | Sink::Quiet => self.finish(),
        }
    }

    /// Ends the display and leaves it as it is.
    pub fn finish(&mut self) {
        match &mut self.sink {
            Sink::Bar(bar) => bar.abandon(),
            Sink::Plain { out, .. } => {
                let _ = out.flush();
            }
            Sink::Quiet => {}
        }
    }

    fn time_left(&self, status: &Status) -> Option<Duration> {
        let done = status.done.checked_sub(self.first).filter(|&n| n > 0)?;
        let left = self.total.saturating_sub(status.done);
        Duration::try_from_secs_f64(status.elapsed.as_secs_f64() * left as f64 / done as f64).ok()
    }
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Progress").field("total", &self.total).field("first", &self.first).finish_non_exhaustive()
    }
}

fn style(unit: &str) -> ProgressStyle {
    ProgressStyle::with_template(&format!("{{wide_bar:.cyan/dim}} {{pos}}/{{len}} {unit}  {{msg}}"))
        .expect("units have no braces")
        .progress_chars("━╸─")
}

fn percent(done: u64, total: u64) -> u64 {
    // No episodes to do are all done.
    done.min(total).saturating_mul(100).checked_div(total).unwrap_or(100)
}

/// The part that the bar and the plain lines share.
struct Details<'a> {
    status: &'a Status,
    left: Option<Duration>,
}

impl fmt::Display for Details<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(coverage) = self.status.coverage {
            write!(f, "coverage {coverage:.3}  ")?;
        }
        if let Some(reward) = self.status.reward {
            write!(f, "reward {reward:.1}  ")?;
        }
        write!(f, "{} agent-steps/s", rate(self.status.agent_steps_per_s))?;
        match self.left {
            Some(left) if !left.is_zero() => write!(f, "  {} left", duration(left)),
            _ => Ok(()),
        }
    }
}

/// `950`, `12.3 k`, `1.25 M`.
fn rate(per_s: f64) -> String {
    match per_s {
        r if r >= 999_950.0 => format!("{:.2} M", r / 1e6),
        r if r >= 999.5 => format!("{:.1} k", r / 1e3),
        r => format!("{r:.0}"),
    }
}

/// `45 s`, `3 min 20 s`, `2 h 05 min`; rounded up, so that it never says 0 s.
fn duration(d: Duration) -> String {
    let s = d.as_secs_f64().ceil() as u64;
    match (s / 3600, s / 60 % 60, s % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, min, s) => format!("{min} min {s:02} s"),
        (h, min, _) => format!("{h} h {min:02} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use indicatif::InMemoryTerm;

    #[test]
    fn the_bar_shows_count_coverage_rate_and_time_left() {
        let term = InMemoryTerm::new(4, 110);
        let mut progress = Progress::bar(ProgressDrawTarget::term_like(Box::new(term.clone())), 400).resumed_at(100);
        progress.line("checkpoint saved");
        progress.update(&Status {
            done: 200,
            elapsed: Duration::from_secs(60),
            agent_steps_per_s: 61_240.0,
            coverage: Some(0.5674),
            reward: None,
        });
        progress.finish();
        let shown = term.contents();
        assert!(shown.starts_with("checkpoint saved\n"), "{shown}");
        let expected = "200/400 episodes  coverage 0.567  61.2 k agent-steps/s  2 min 00 s left";
        assert!(shown.contains(expected), "{shown}");
    }
}
