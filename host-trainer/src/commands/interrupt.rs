//! Ctrl-C, SIGTERM and SIGHUP.

use super::output::tell;
use miette::{IntoDiagnostic, Result};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What is said while runs in training wait for the end of their round.
pub const SAVING: &str = "stopping training at the end of this round, which saves it";

/// Exit status of a run that a signal stopped.
pub const INTERRUPTED: i32 = 130;

/// Whether a signal has asked to stop, and what has to be saved before. The first signal is answered with words
/// that say what is being stopped; while nothing has to be saved it ends the program, and so does the second at
/// any time. Every file is written whole or not at all, so that ending at once spoils none.
#[derive(Debug, Default)]
pub struct Stop(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    signalled: bool,
    failed: bool,
    /// Those who have something to save or to end before the program ends: runs in training, emulated boards.
    waiting: usize,
    /// What a signal is answered with while they do.
    words: &'static str,
    /// What is said when the program ends at once.
    parting: String,
}

/// As long as it lives, a signal waits for its owner.
pub struct Waits<'s>(&'s Stop);

impl Stop {
    /// From now on this answers the signals. Call it once.
    ///
    /// # Errors
    /// When the system takes no handler.
    pub fn on_signals() -> Result<Arc<Self>> {
        let hangup = Hangup::read();
        let stop = Arc::new(Self::default());
        let handler = Arc::clone(&stop);
        ctrlc::set_handler(move || handler.signalled()).into_diagnostic()?;
        hangup.keep_if_ignored();
        Ok(stop)
    }

    /// For a command that has nothing to save: a signal ends it at once, with these words.
    ///
    /// # Errors
    /// As [`Self::on_signals`].
    pub fn with_words(parting: String) -> Result<Arc<Self>> {
        let stop = Self::on_signals()?;
        stop.at_once(parting);
        Ok(stop)
    }

    /// Whether a signal has come, or another run has failed.
    pub fn asked(&self) -> bool {
        let state = self.state();
        state.signalled || state.failed
    }

    /// Asks the other runs to stop, since one has failed.
    pub fn fail(&self) {
        self.state().failed = true;
    }

    /// What is said from now on when a signal ends the program at once.
    pub fn at_once(&self, parting: String) {
        self.state().parting = parting;
    }

    /// Until the guard is dropped a signal waits, answered with these words: what is stopped, and when.
    pub fn waits(&self, words: &'static str) -> Waits<'_> {
        let mut state = self.state();
        state.waiting += 1;
        state.words = words;
        Waits(self)
    }

    /// Ends the program when a signal has come and nothing has to be saved any more.
    pub fn end_if_signalled(&self) {
        let state = self.state();
        if state.signalled && state.waiting == 0 {
            end(&state.parting);
        }
    }

    fn signalled(&self) {
        let mut state = self.state();
        if state.signalled {
            std::process::exit(INTERRUPTED);
        }
        state.signalled = true;
        if state.waiting == 0 {
            end(&state.parting);
        }
        tell!("\n{}; press Ctrl-C again to stop at once", state.words);
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Nothing in it can be half changed.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn end(parting: &str) -> ! {
    tell!("\n{parting}");
    std::process::exit(INTERRUPTED);
}

impl Drop for Waits<'_> {
    fn drop(&mut self) {
        self.0.state().waiting -= 1;
    }
}

/// What SIGHUP does. `nohup` has it ignored, and so it must stay, but `ctrlc` handles all three
/// signals or none.
struct Hangup {
    #[cfg(unix)]
    action: libc::sigaction,
}

impl Hangup {
    fn read() -> Self {
        Self {
            #[cfg(unix)]
            // SAFETY: a structure of zeros is a valid `sigaction`, and a call without a new action
            // only fills it in.
            action: unsafe {
                let mut action = std::mem::zeroed();
                libc::sigaction(libc::SIGHUP, std::ptr::null(), &raw mut action);
                action
            },
        }
    }

    fn keep_if_ignored(&self) {
        #[cfg(unix)]
        if self.action.sa_sigaction == libc::SIG_IGN {
            // SAFETY: puts back the action that the system gave.
            unsafe { libc::sigaction(libc::SIGHUP, &raw const self.action, std::ptr::null_mut()) };
        }
    }
}
