//! The operator at the terminal: commands on standard input, and Ctrl-C.

use crate::node::OperatorCommand;
use miette::{IntoDiagnostic as _, Result};
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::{io, thread};

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
            for line in io::stdin().lines().map_while(Result::ok) {
                let command = match line.trim().to_ascii_lowercase().as_str() {
                    "" => continue,
                    "start" => OperatorCommand::Start,
                    "release" => OperatorCommand::Release,
                    "return" => OperatorCommand::Return,
                    "land" => OperatorCommand::Land,
                    other => {
                        eprintln!("`{other}`? start, release, return and land are understood; Ctrl-C ends");
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

/// A flag that Ctrl-C (SIGINT) and SIGTERM set. The second signal ends the process at once.
///
/// # Errors
/// The system takes no signal handler.
pub(crate) fn stop_flag() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .into_diagnostic()?;
    Ok(stop)
}
