//! Results on standard output, where `println!` would panic.
//!
//! When its reader has gone, the program ends without a word, as other programs do; that it is full, or cannot be
//! written to, is an error in words. What a flight prints while it flies goes through [`outlet`](crate::outlet).

use crate::outlet::drain;
use miette::{Result, miette};
use std::io::{ErrorKind, Write as _, stdout};

/// The status that a shell gives a program that a closed pipe has ended.
const CLOSED_PIPE: i32 = 141;

/// Writes a text, whole lines.
///
/// # Errors
/// Standard output takes no more.
pub(super) fn print(text: &str) -> Result<()> {
    let mut out = stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => {
            // Warnings came before.
            drain();
            std::process::exit(CLOSED_PIPE)
        }
        Err(error) => Err(miette!("cannot write to standard output: {error}; send it elsewhere to see the result")),
    }
}
