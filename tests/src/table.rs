//! The table, and how its rows are run and judged.

use crate::outputs::Outputs;
use rustix::fs::OFlags;
use rustix::process::{Pid, Signal, kill_process};
use std::fs::File;
use std::io::Read;
use std::os::unix::fs::OpenOptionsExt as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::ScopedJoinHandle;

/// Rows that each program's test must have at the least. All of them together are more than 300.
pub const LEAST_OF_ALL: [(&str, usize); 3] = [("host-trainer", 250), ("sitl-bridge", 250), ("xtask", 60)];
const _: () = assert!(LEAST_OF_ALL[0].1 + LEAST_OF_ALL[1].1 + LEAST_OF_ALL[2].1 >= 300);

/// Exit status of a program that a signal has stopped in its own words.
const INTERRUPTED: i32 = 130;
/// The signal of a closed pipe.
const SIGPIPE: i32 = 13;
/// What a shell makes of a program that a closed pipe has ended.
const CLOSED_PIPE: i32 = 141;

/// How a command must end.
#[derive(Clone, Debug)]
pub enum End {
    /// Exit status 0.
    Done,
    /// Exit status 1 or 2, and all these words on standard error.
    Refused(Vec<String>),
    /// As refused, or 0.
    MayPass(Vec<String>),
    /// The output breaks: 0, or ended quietly by the closed pipe.
    Quiet,
    /// Held at the pipe, which it then reads: the signal ends it with status 130 and these words on standard error, or,
    /// without words, as the system does.
    Signalled(PathBuf, Signal, Option<&'static str>),
}

impl End {
    /// Refused, with these words.
    #[must_use]
    pub fn refused(words: &[&str]) -> Self {
        Self::Refused(words.iter().map(|&word| word.to_owned()).collect())
    }

    /// Refused with the name of the file, or, where it may pass, done.
    #[must_use]
    pub fn names(path: &Path, may_pass: bool) -> Self {
        let words = vec![path.display().to_string()];
        if may_pass { Self::MayPass(words) } else { Self::Refused(words) }
    }
}

struct Row {
    name: String,
    command: Command,
    outputs: Outputs,
    end: End,
}

/// Commands, each with what it is fed and how it must end.
#[derive(Default)]
pub struct Table(Vec<Row>);

impl Table {
    /// A row.
    pub fn add(&mut self, name: impl Into<String>, command: Command, end: End) {
        self.0.push(Row { name: name.into(), command, outputs: Outputs::Read, end });
    }

    /// Rows of a command that succeeds where its outputs do: with each kind of broken output. `make` makes it anew. A
    /// full standard output is an error in words, a closed one the quiet end; what becomes of standard error changes
    /// nothing.
    pub fn add_broken_outputs(&mut self, name: &str, mut make: impl FnMut() -> Command) {
        for outputs in Outputs::BROKEN {
            let end = match outputs {
                Outputs::FullOut => End::refused(&["cannot write to standard output: No space left on device"]),
                Outputs::CutOut | Outputs::CutInTheMiddle => End::Quiet,
                _ => End::Done,
            };
            self.0.push(Row { name: format!("{name}: {outputs:?}"), command: make(), outputs, end });
        }
    }

    /// Runs all rows, several at a time. `program` is the one that they are of: so many rows it must have.
    ///
    /// # Panics
    /// With every row that did not end as it must, or when there are too few.
    pub fn run(self, program: &str) {
        let least = LEAST_OF_ALL.iter().find(|(name, _)| *name == program).expect("a program of the list").1;
        assert!(self.0.len() >= least, "{} combinations, at least {least} are wanted", self.0.len());
        println!("{program}: {} combinations", self.0.len());
        let (queue, wrong) = (Mutex::new(self.0.into_iter()), Mutex::new(Vec::new()));
        let work = || {
            loop {
                let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some(mut row) = next else { return };
                if let Some(what) = row.run() {
                    let what = format!("{}: {what}\n  {:?}", row.name, row.command);
                    wrong.lock().unwrap_or_else(PoisonError::into_inner).push(what);
                }
            }
        };
        let threads = std::thread::available_parallelism().map_or(2, std::num::NonZero::get) + 1;
        std::thread::scope(|scope| (0..threads).for_each(|_| _ = scope.spawn(work)));
        let wrong = wrong.into_inner().unwrap_or_else(PoisonError::into_inner);
        assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    }
}

impl Row {
    /// What was wrong.
    fn run(&mut self) -> Option<String> {
        let done = match &self.end {
            End::Signalled(pipe, signal, _) => signalled(&mut self.command, pipe, *signal),
            _ => self.outputs.run(&mut self.command),
        };
        match done {
            Ok(output) => self.judge(&output),
            Err(error) => Some(format!("it cannot be run: {error}")),
        }
    }

    fn judge(&self, output: &Output) -> Option<String> {
        let (code, signal) = (output.status.code(), output.status.signal());
        let err = words(&output.stderr);
        if err.contains("panicked") || code == Some(101) {
            return Some(format!("it panicked: {err}"));
        }
        let lacks = |words: &[String]| words.iter().find(|word| !err.contains(&words_of(word))).cloned();
        let complaint = |words: &[String]| lacks(words).map(|word| format!("no “{word}” in: {err}"));
        match (&self.end, code, signal) {
            (End::Done | End::MayPass(_), Some(0), _) => None,
            (End::Refused(words) | End::MayPass(words), Some(1 | 2), _) => complaint(words),
            (End::Quiet, Some(0 | CLOSED_PIPE), _) | (End::Quiet, None, Some(SIGPIPE)) => {
                err.contains("Broken pipe").then(|| format!("it speaks of the pipe: {err}"))
            }
            (End::Signalled(_, _, Some(words)), Some(INTERRUPTED), _) => complaint(&[(*words).to_owned()]),
            (End::Signalled(_, sent, None), None, Some(signal)) if signal == sent.as_raw() => None,
            _ => Some(format!("exit status {code:?}, signal {signal:?}, not {:?}: {err}", self.end)),
        }
    }
}

/// Starts it, and sends it the signal once it reads the pipe.
fn signalled(command: &mut Command, pipe: &Path, signal: Signal) -> std::io::Result<Output> {
    let opened = crate::held(pipe)?;
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let (id, ended) = (Pid::from_child(&child), AtomicBool::new(false));
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    std::thread::scope(|scope| {
        let (stdout, stderr) = (scope.spawn(|| read(stdout)), scope.spawn(|| read(stderr)));
        let sender = scope.spawn(|| {
            let held = opened()?;
            if !ended.load(Ordering::SeqCst) {
                kill_process(id, signal)?;
            }
            Ok::<File, std::io::Error>(held)
        });
        let status = child.wait()?;
        ended.store(true, Ordering::SeqCst);
        // One that ended by itself has not read it: then this lets the sender go.
        let _reader = File::options().read(true).custom_flags(OFlags::NONBLOCK.bits() as i32).open(pipe);
        // What the program started itself goes on now, and ends.
        drop(sender.join());
        let text = |reader: ScopedJoinHandle<'_, Vec<u8>>| reader.join().unwrap_or_default();
        Ok(Output { status, stdout: text(stdout), stderr: text(stderr) })
    })
}

fn read(from: Option<impl Read>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let _ = from.map(|mut from| from.read_to_end(&mut bytes));
    bytes
}

/// What was written, in one line: reports break lines and mark them.
#[must_use]
pub fn words(bytes: &[u8]) -> String {
    words_of(&String::from_utf8_lossy(bytes).replace(['│', '╰', '├', '─', '▶', '×'], " "))
}

fn words_of(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
