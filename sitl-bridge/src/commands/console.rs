//! The operator at the terminal: commands on standard input, and Ctrl-C.

use crate::node::OperatorCommand;
use crate::outlet;
use miette::{IntoDiagnostic as _, Result};
use std::cell::RefCell;
use std::io::{self, BufRead};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// Exit status of a program that a signal has stopped.
const INTERRUPTED: i32 = 130;
/// Longest line that is read whole, bytes.
const LONGEST_LINE: usize = 100;

/// The operator's commands from standard input, for any number of nodes.
#[derive(Debug, Default)]
pub(crate) struct Console(RefCell<Vec<Sender<OperatorCommand>>>);

impl Console {
    /// The commands for one more node.
    pub fn listener(&self) -> Receiver<OperatorCommand> {
        let (send, receive) = channel();
        self.0.borrow_mut().push(send);
        receive
    }

    /// Reads commands from standard input in a thread of its own until the input ends. A line that is
    /// no command is answered with the list of commands.
    pub fn listen(&self) {
        let nodes = self.0.take();
        thread::spawn(move || {
            let mut input = io::stdin().lock();
            while let Some(line) = next_line(&mut input) {
                let command = match line.trim().to_ascii_lowercase().as_str() {
                    "" => continue,
                    "start" => OperatorCommand::Start,
                    "release" => OperatorCommand::Release,
                    "return" => OperatorCommand::Return,
                    "land" => OperatorCommand::Land,
                    other => {
                        // A standard error that is closed, or that nobody reads, keeps nobody from listening on.
                        outlet::say(&format!("`{other}`? start, release, return and land are understood; Ctrl-C ends"));
                        continue;
                    }
                };
                // A node that has ended receives no more.
                for node in &nodes {
                    let _ = node.send(command);
                }
            }
        });
    }
}

/// The next line, nothing at the end of the input. Bytes that are no UTF-8 are replaced; of a line that is
/// too long the beginning is returned, and the rest passed over.
fn next_line(input: &mut impl BufRead) -> Option<String> {
    let mut line = Vec::new();
    loop {
        let bytes = match input.fill_buf() {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return None,
        };
        if bytes.is_empty() && line.is_empty() {
            return None;
        }
        let end = bytes.iter().position(|&byte| byte == b'\n');
        let part = end.unwrap_or(bytes.len());
        let room = LONGEST_LINE - line.len();
        line.extend_from_slice(&bytes[..part.min(room)]);
        let (is_end, used) = (end.is_some() || bytes.is_empty(), part + usize::from(end.is_some()));
        input.consume(used);
        if is_end {
            return Some(String::from_utf8_lossy(&line).into_owned());
        }
    }
}

/// A flag that Ctrl-C (SIGINT), SIGTERM and SIGHUP (a lost terminal) set. The second signal ends the process at once.
///
/// # Errors
/// The system takes no signal handler.
pub(crate) fn stop_flag() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED);
        }
    })
    .into_diagnostic()?;
    Ok(stop)
}

/// Has Ctrl-C, SIGTERM and SIGHUP end the process at once, with these words: for commands that fly nothing.
///
/// # Errors
/// The system takes no signal handler.
pub(super) fn end_on_signals(parting: String) -> Result<()> {
    ctrlc::set_handler(move || {
        outlet::say(&parting);
        outlet::drain();
        std::process::exit(INTERRUPTED);
    })
    .into_diagnostic()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_cannot_be_read_do_not_end_the_listening() {
        let mut input = b"start\n\xff\xfe\n".to_vec();
        input.extend(vec![b'x'; 1_000_000]);
        input.extend(b"\n\nland");
        let mut input = io::BufReader::with_capacity(7, io::Cursor::new(input));
        let lines: Vec<String> = std::iter::from_fn(|| next_line(&mut input)).collect();
        assert_eq!(lines[..2], ["start".to_owned(), "\u{fffd}\u{fffd}".to_owned()]);
        assert_eq!((lines[2].len(), &lines[3..]), (LONGEST_LINE, &[String::new(), "land".to_owned()][..]));
    }
}
