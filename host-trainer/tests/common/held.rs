//! Runs that `COVEY_HOLD_AT` holds at a stated point, so that nothing depends on how fast they are.

use super::{Done, unwrapped};
use std::ffi::CString;
use std::fs::OpenOptions;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::ffi::OsStrExt;
use std::process::{Child, ChildStderr, Command, Stdio};
use tempfile::TempDir;

/// A run that is held.
pub struct Held {
    child: Child,
    progress: BufReader<ChildStderr>,
    /// What was read of `progress`.
    said: String,
    /// The folder of the pipe that it reads.
    folder: TempDir,
}

/// Starts a command and returns when it is held at `point`: `round:N` or `measuring`.
pub fn held_at(point: &str, command: &mut Command) -> Held {
    let folder = tempfile::tempdir().expect("a folder");
    let pipe = folder.path().join("pipe");
    let name = CString::new(pipe.as_os_str().as_bytes()).expect("no zeros");
    // SAFETY: the name ends with a zero.
    assert_eq!(unsafe { libc::mkfifo(name.as_ptr(), 0o600) }, 0, "no pipe");
    command.env("COVEY_HOLD_AT", format!("{point}:{}", pipe.display()));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let progress = BufReader::new(child.stderr.take().expect("piped"));
    let mut held = Held { child, progress, said: String::new(), folder };
    held.wait_for("held at");
    held
}

impl Held {
    /// Reads what it says until a line has these words.
    pub fn wait_for(&mut self, words: &str) {
        let mut line = String::new();
        while !line.contains(words) {
            line.clear();
            let read = self.progress.read_line(&mut line).expect("text");
            assert!(read > 0, "it ended and never said “{words}”: {}", self.said);
            self.said += &line;
        }
    }

    /// Its process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends it a signal.
    pub fn signal(&self, signal: i32) {
        // SAFETY: the child has not been waited for, so its id is its own.
        let sent = unsafe { libc::kill(self.child.id() as libc::pid_t, signal) };
        assert_eq!(sent, 0);
    }

    /// Lets it go.
    pub fn go_on(&self) {
        // It reads until this writer is closed.
        drop(OpenOptions::new().write(true).open(self.folder.path().join("pipe")).expect("the pipe"));
    }

    /// Sends it a signal and lets it go when it has taken note.
    pub fn interrupt(&mut self, signal: i32) {
        self.signal(signal);
        self.wait_for("stopping training");
        self.go_on();
    }

    /// Waits for its end.
    pub fn end(mut self) -> Done {
        self.progress.read_to_string(&mut self.said).expect("text");
        let done = self.child.wait_with_output().expect("it ends");
        Done { err: unwrapped(&self.said), ..done.into() }
    }
}
