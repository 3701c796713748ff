//! What is printed, where `println!` would panic.
//!
//! [`print()`] writes results: a reader that has gone ends the task without a word, as it ends other programs; an output
//! that is full is an error in words. [`show!`] and [`tell!`] write what only accompanies the work, on standard output
//! and on the error output: whether somebody can read it changes nothing.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _, stderr, stdout};

use crate::error::{Error, Result};

/// The status that a shell gives a program that a closed pipe has ended.
const CLOSED_PIPE: i32 = 141;

/// Writes a result to standard output.
///
/// # Errors
/// Standard output takes no more.
pub fn print(text: &str) -> Result<()> {
    let mut out = stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => std::process::exit(CLOSED_PIPE),
        Err(error) => Err(Error::Print(error)),
    }
}

/// Writes to standard output, if it takes it.
pub fn write_out(text: Arguments<'_>) {
    let mut out = stdout().lock();
    let _ = out.write_all(format!("{text}\n").as_bytes()).and_then(|()| out.flush());
}

/// Writes to the error output, if it takes it.
pub fn write_err(text: Arguments<'_>) {
    let _ = stderr().lock().write_all(format!("{text}\n").as_bytes());
}

/// `println!` that does not panic.
macro_rules! show {
    ($($arg:tt)*) => { $crate::output::write_out(format_args!($($arg)*)) };
}

/// `eprintln!` that does not panic.
macro_rules! tell {
    ($($arg:tt)*) => { $crate::output::write_err(format_args!($($arg)*)) };
}

pub(crate) use {show, tell};
