//! Ctrl-C, SIGTERM and SIGHUP.

use miette::{IntoDiagnostic, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit status of a run that a signal stopped.
pub const INTERRUPTED: i32 = 130;

/// From now on the first Ctrl-C, SIGTERM or SIGHUP sets the flag, which asks to stop at the end of
/// the round, and the second ends the program at once. Call it once.
///
/// # Errors
/// When the system takes no handler.
pub fn stop_on_signals() -> Result<Arc<AtomicBool>> {
    let hangup = Hangup::read();
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
        eprintln!("\nstopping at the end of this round; press Ctrl-C again to stop at once");
    })
    .into_diagnostic()?;
    hangup.keep_if_ignored();
    Ok(stop)
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
