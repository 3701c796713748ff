//! The fleet of autopilots: a process of `python -m simlink`, or of `python -m sitl`.

use crate::outlet::say;
use serde_json::Value;
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use thiserror::Error;

/// The fleet has this long to become ready.
const START: Duration = Duration::from_secs(30);
/// A fleet has this long to stop.
const END: Duration = Duration::from_secs(5);
/// Number of lines of its log that are kept for an error message.
const LOG_LINES: usize = 12;
/// The interpreter of the environment that `cargo xtask setup` makes, under the project's folder.
const VENV: &str = ".venv/bin/python";

/// Why the fleet cannot be used.
#[derive(Debug, Error)]
pub enum FleetError {
    /// The interpreter did not start.
    #[error("cannot start the fleet's Python, {}: {source}; `cargo xtask setup` makes its environment, or name another with --python", python.display())]
    Start {
        /// What was to be started.
        python: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The interpreter lacks a package.
    #[error("{} has no {package}; `cargo xtask setup` makes an environment that has it, or name another with --python", python.display())]
    Package {
        /// The interpreter.
        python: PathBuf,
        /// The package.
        package: String,
    },
    /// The process ended.
    #[error("the fleet ended{}:\n{log}", status.as_ref().map(|s| format!(" ({s})")).unwrap_or_default())]
    Ended {
        /// Its exit status.
        status: Option<String>,
        /// The end of its log.
        log: String,
    },
    /// It did not become ready in time.
    #[error("the fleet was not ready within {} s:\n{log}", START.as_secs())]
    NotReady {
        /// The end of its log.
        log: String,
    },
}

/// A running fleet. It ends when this is dropped.
#[derive(Debug)]
pub struct Fleet {
    python: PathBuf,
    child: Child,
    stdin: Option<ChildStdin>,
    events: Receiver<Value>,
    log: Arc<Mutex<Vec<String>>>,
    threads: Vec<JoinHandle<()>>,
}

impl Fleet {
    /// Starts the fleet of a Python package, `simlink` or `sitl`, and waits until it is ready.
    ///
    /// # Errors
    /// See [`FleetError`].
    pub fn start(python: &Path, package: &str, config: &Value, verbose: bool) -> Result<Self, FleetError> {
        let failed = |source| FleetError::Start { python: python.to_owned(), source };
        let mut child = Command::new(python)
            .args(["-m", package])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let (send, events) = channel();
        let log = Arc::new(Mutex::new(Vec::new()));
        let mut threads = Vec::new();
        if let Some(stdout) = child.stdout.take() {
            threads.push(thread::spawn(move || {
                for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                    if serde_json::from_str(&line).is_ok_and(|event| send.send(event).is_err()) {
                        break;
                    }
                }
            }));
        }
        if let Some(stderr) = child.stderr.take() {
            let log = Arc::clone(&log);
            threads.push(thread::spawn(move || {
                for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                    if verbose {
                        say(&line);
                    }
                    let mut log = log.lock().unwrap_or_else(PoisonError::into_inner);
                    if log.len() == LOG_LINES {
                        log.remove(0);
                    }
                    log.push(line);
                }
            }));
        }
        let stdin = child.stdin.take();
        let mut fleet = Self { python: python.to_owned(), child, stdin, events, log, threads };
        fleet.command(config);
        fleet.await_ready()?;
        Ok(fleet)
    }

    /// Its process id.
    #[must_use]
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    /// Sends a command; a fleet that has ended ignores it.
    pub fn command(&mut self, command: &Value) {
        if let Some(stdin) = &mut self.stdin {
            let _ = writeln!(stdin, "{command}").and_then(|()| stdin.flush());
        }
    }

    /// The events since the last call.
    ///
    /// # Errors
    /// [`FleetError::Ended`] once the process has ended and all its events were returned.
    pub fn events(&mut self) -> Result<Vec<Value>, FleetError> {
        let mut events = Vec::new();
        loop {
            match self.events.try_recv() {
                Ok(event) => events.push(event),
                Err(std::sync::mpsc::TryRecvError::Empty) => return Ok(events),
                Err(std::sync::mpsc::TryRecvError::Disconnected) if events.is_empty() => return Err(self.ended()),
                Err(std::sync::mpsc::TryRecvError::Disconnected) => return Ok(events),
            }
        }
    }

    /// The next event, whenever it comes.
    ///
    /// # Errors
    /// [`FleetError::Ended`] once the process has ended and all its events were returned.
    pub fn next_event(&mut self) -> Result<Value, FleetError> {
        self.events.recv().map_err(|_| self.ended())
    }

    /// Stops the fleet and returns its last events.
    pub fn stop(&mut self) -> Vec<Value> {
        self.command(&serde_json::json!({"stop": true}));
        self.stdin = None;
        let until = Instant::now() + END;
        let mut rest = Vec::new();
        while let Ok(event) = self.events.recv_timeout(until.saturating_duration_since(Instant::now())) {
            rest.push(event);
        }
        rest
    }

    fn await_ready(&mut self) -> Result<(), FleetError> {
        let until = Instant::now() + START;
        loop {
            match self.events.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(event) if event["event"] == "ready" => return Ok(()),
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => return Err(FleetError::NotReady { log: self.log_tail() }),
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended()),
            }
        }
    }

    fn ended(&mut self) -> FleetError {
        let status = self.child.wait().ok().map(|status| status.to_string());
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
        let log = self.log_tail();
        let missing = log.rsplit_once("No module named ").and_then(|(_, rest)| rest.lines().next());
        match missing {
            Some(package) => FleetError::Package {
                python: self.python.clone(),
                package: package.trim_matches(['\'', '"', ' ']).to_owned(),
            },
            None => FleetError::Ended { status, log },
        }
    }

    fn log_tail(&self) -> String {
        self.log.lock().unwrap_or_else(PoisonError::into_inner).join("\n")
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        // Closing its input ends it; a fleet that hangs is ended from outside.
        self.stdin = None;
        let until = Instant::now() + END;
        while Instant::now() < until {
            match self.child.try_wait() {
                Ok(None) => thread::sleep(Duration::from_millis(10)),
                _ => break,
            }
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// The Python interpreter of the fleet: the named one, or that of the environment that `cargo xtask setup`
/// made, searched from the current directory and from this program's upwards; else `python3`.
#[must_use]
pub fn find_python(named: Option<&Path>) -> PathBuf {
    if let Some(python) = named {
        return python.to_owned();
    }
    let starts = [std::env::current_dir().ok(), std::env::current_exe().ok()];
    let found = starts.iter().flatten().flat_map(|start| start.ancestors()).map(|folder| folder.join(VENV));
    found.into_iter().find(|python| python.exists()).unwrap_or_else(|| PathBuf::from("python3"))
}
