//! Standard output and standard error, where `println!` would panic.
//!
//! [`print_out!`] and [`say_out!`] write results to standard output: when its reader has gone, the program ends as other
//! programs do (by SIGPIPE), and any other failure is an error in words. [`tell!`] writes remarks to standard
//! error and ignores failures there: work of hours must not end because nobody can be told of it.

use miette::{Result, miette};
use std::fmt::Arguments;
use std::io::{ErrorKind, Write, stderr, stdout};

/// Writes to standard output.
///
/// # Errors
/// When it takes no more.
pub fn write_out(text: Arguments<'_>) -> Result<()> {
    let mut out = stdout().lock();
    match out.write_fmt(text).and_then(|()| out.flush()) {
        Ok(()) => Ok(()),
        Err(e) if e.kind() == ErrorKind::BrokenPipe => end_by_closed_pipe(),
        Err(e) => Err(miette!(
            help = "files that the command writes are complete; send its output elsewhere to see it",
            "cannot write to standard output: {e}"
        )),
    }
}

/// Writes a line to standard error, if it takes one.
pub fn write_err(text: Arguments<'_>) {
    // In one piece, so that lines of several threads do not mix.
    let _ = stderr().lock().write_all(format!("{text}\n").as_bytes());
}

/// Ends as a program that does not handle the signal.
fn end_by_closed_pipe() -> ! {
    #[cfg(unix)]
    // SAFETY: restores the default action of a signal and raises it.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
        libc::raise(libc::SIGPIPE);
    }
    // Where there is no such signal, or it is blocked: the status that a shell gives it.
    std::process::exit(141)
}

/// `print!` that returns an error instead of panicking.
macro_rules! print_out {
    ($($arg:tt)*) => { $crate::commands::output::write_out(format_args!($($arg)*)) };
}

/// `println!` that returns an error instead of panicking.
macro_rules! say_out {
    ($($arg:tt)*) => { $crate::commands::output::write_out(format_args!("{}\n", format_args!($($arg)*))) };
}

/// `eprintln!` that does not panic.
macro_rules! tell {
    ($($arg:tt)*) => { $crate::commands::output::write_err(format_args!($($arg)*)) };
}

pub(crate) use {print_out, say_out, tell};
