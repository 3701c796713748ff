//! A run that was interrupted and went on is, to the byte, the run that never was.
#![cfg(target_os = "linux")]

mod common;

use common::{Done, assert_same, checkpoints, copy, episodes_of, finish, refuse, results, resume, succeed, train};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use tempfile::TempDir;

/// 100 rounds: a line of progress each, twice what the narrowed pipe holds. So a run whose
/// output nobody reads stops in the middle and waits, however fast the machine is.
const SETTINGS: [&str; 2] = ["episodes=400", "checkpoint_every=8"];
const EPISODES: u64 = 400;

/// A run that works while its progress is read.
struct Running {
    child: Child,
    progress: BufReader<ChildStderr>,
}

impl Running {
    fn start(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
        let progress = child.stderr.take().expect("piped");
        // SAFETY: sets the capacity of a pipe that is open.
        let room = unsafe { libc::fcntl(progress.as_raw_fd(), libc::F_SETPIPE_SZ, 4096) };
        assert!(room > 0, "the pipe cannot be narrowed");
        Self { child, progress: BufReader::with_capacity(256, progress) }
    }

    /// Reads progress until `episodes` are done; their row of metrics is then written.
    fn wait_for(&mut self, episodes: u64) {
        let mut line = String::new();
        while !line.contains(&format!(" {episodes}/")) {
            line.clear();
            assert!(self.progress.read_line(&mut line).expect("text") > 0, "ended before {episodes} episodes");
        }
    }

    fn signal(&self, signal: i32) {
        // SAFETY: the child has not been waited for, so its id is its own.
        let sent = unsafe { libc::kill(self.child.id() as libc::pid_t, signal) };
        assert_eq!(sent, 0);
    }

    fn end(mut self) -> Done {
        let mut err = String::new();
        self.progress.read_to_string(&mut err).expect("text");
        let done = self.child.wait_with_output().expect("it ends");
        Done { err: common::unwrapped(&err), ..done.into() }
    }
}

/// A run never interrupted, and a folder for others.
struct Runs {
    folder: TempDir,
    whole: PathBuf,
}

fn runs(graph: &str) -> Runs {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = folder.path().join("whole");
    succeed(train(&whole, &SETTINGS).args(["--graph", graph, "--threads", "2", "--quiet"]));
    Runs { folder, whole }
}

impl Runs {
    fn start(&self, graph: &str) -> (PathBuf, Running) {
        let out = self.folder.path().join("interrupted");
        let running = Running::start(train(&out, &SETTINGS).args(["--graph", graph, "--threads", "1"]));
        (out, running)
    }

    /// Goes on with copies of `run` on one and on two threads.
    fn check(&self, run: &Path) {
        for threads in ["1", "2"] {
            let again = self.folder.path().join(format!("again-{threads}"));
            copy(run, &again);
            succeed(resume(&again).args(["--threads", threads, "--quiet"]));
            assert_same(&results(&self.whole), &results(&again), &format!("resumed on {threads} threads"));
        }
    }
}

fn interrupted_by(signal: i32, graph: &str) {
    let runs = runs(graph);
    let (out, mut running) = runs.start(graph);
    running.wait_for(4);
    running.signal(signal);
    let done = running.end();
    assert_eq!(done.code, Some(130), "{}", done.err);
    let how = format!("host-trainer train --resume {}", out.display());
    assert!(done.err.contains(&how), "no “{how}” in: {}", done.err);
    let saved = episodes_of(&checkpoints(&out).pop().expect("a checkpoint"));
    assert!((4..EPISODES).contains(&saved), "stopped at {saved} episodes");
    assert!(!out.join("actor.postcard").exists(), "an unfinished run has no actor");
    // Interrupted again after it went on (or at its end, if that comes first).
    let mut running = Running::start(resume(&out).args(["--threads", "2"]));
    running.wait_for(saved + 4);
    running.signal(signal);
    let again = running.end();
    assert!(matches!(again.code, Some(130 | 0)), "{:?}: {}", again.code, again.err);
    runs.check(&out);
}

#[test]
fn ctrl_c_without_a_graph_loses_nothing() {
    interrupted_by(libc::SIGINT, "none");
}

#[test]
fn termination_with_gcn_loses_nothing() {
    interrupted_by(libc::SIGTERM, "gcn");
}

#[test]
fn a_lost_terminal_with_gat_loses_nothing() {
    interrupted_by(libc::SIGHUP, "gat");
}

/// `nohup` starts its command with this signal ignored.
#[test]
fn a_run_without_a_terminal_goes_on_when_one_is_lost() {
    let runs = runs("none");
    let out = runs.folder.path().join("alone");
    let mut command = train(&out, &SETTINGS);
    command.args(["--graph", "none", "--threads", "1"]);
    // SAFETY: allowed between fork and exec.
    unsafe {
        command.pre_exec(|| {
            libc::signal(libc::SIGHUP, libc::SIG_IGN);
            Ok(())
        });
    }
    let mut running = Running::start(&mut command);
    running.wait_for(4);
    running.signal(libc::SIGHUP);
    let done = running.end();
    assert_eq!(done.code, Some(0), "{}", done.err);
    assert_same(&results(&runs.whole), &results(&out), "after a signal that is ignored");
}

#[test]
fn a_killed_run_goes_on_from_its_last_checkpoint() {
    let runs = runs("gcn");
    let (out, mut running) = runs.start("gcn");
    running.wait_for(28);
    running.signal(libc::SIGKILL);
    assert_eq!(running.end().code, None);
    let saved = episodes_of(&checkpoints(&out).pop().expect("a checkpoint"));
    assert!((24..EPISODES).contains(&saved), "saved at {saved} episodes");
    // What else a kill can leave: half a row, a temporary file, half an event.
    let append = |path: &Path, bytes: &[u8]| {
        let mut file = fs::OpenOptions::new().append(true).open(path).expect("a file of the run");
        file.write_all(bytes).expect("written");
    };
    append(&out.join("metrics.jsonl"), b"{\"episodes\":9");
    append(&common::files(&out.join("events"))[0], &[1, 2, 3]);
    let leftover = out.join("checkpoints/.episode-0000000032.ckpt.1-0.covey-tmp");
    fs::write(&leftover, b"COVEY").expect("written");
    runs.check(&out);
    assert!(!runs.folder.path().join("again-1/checkpoints").join(leftover.file_name().expect("a name")).exists());
}

/// A run that had ended all its episodes, but not its evaluation.
#[test]
fn a_run_killed_while_it_measures_writes_actor_and_report_when_resumed() {
    let runs = runs("gcn");
    let out = runs.folder.path().join("unmeasured");
    copy(&runs.whole, &out);
    for name in ["actor.postcard", "evaluation.json", "report.html"] {
        fs::remove_file(out.join(name)).expect("a file of a whole run");
    }
    runs.check(&out);
    assert!(runs.folder.path().join("again-2/report.html").exists());
}

/// Once more with a whole run: nothing is left to do, and nothing changes.
#[test]
fn resuming_a_whole_run_changes_nothing() {
    let runs = runs("none");
    let before = results(&runs.whole);
    succeed(resume(&runs.whole).arg("--quiet"));
    assert_same(&before, &results(&runs.whole), "resumed at its end");
}

#[test]
fn a_run_that_lost_rows_of_its_metrics_is_not_resumed() {
    let runs = runs("gcn");
    let (out, mut running) = runs.start("gcn");
    running.wait_for(28);
    running.signal(libc::SIGKILL);
    running.end();
    let metrics = out.join("metrics.jsonl");
    let kept = fs::read_to_string(&metrics).expect("metrics");
    let first = kept.lines().next().expect("a row");
    fs::write(&metrics, format!("{first}\n")).expect("written");
    refuse(&mut resume(&out), &["has 1 complete rows", "earlier checkpoint"]);
    fs::remove_file(&metrics).expect("removed");
    refuse(&mut resume(&out), &["metrics.jsonl"]);
    // With the file back in its place the run goes on.
    fs::write(&metrics, kept).expect("written");
    assert_eq!(finish(resume(&out).arg("--quiet")).code, Some(0));
    assert_same(&results(&runs.whole), &results(&out), "after the file was put back");
}
