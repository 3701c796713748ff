//! A run that was interrupted and went on is, to the byte, the run that never was.
#![cfg(target_os = "linux")]

mod common;

use common::held::{Held, held_at};
use common::{assert_same, checkpoints, copy, episodes_of, finish, refuse, results, resume, succeed, train};
use std::fs;
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// 10 rounds of 4 episodes.
const SETTINGS: [&str; 2] = ["episodes=40", "checkpoint_every=8"];

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
    /// A run that is held at the end of this round.
    fn start(&self, graph: &str, round: u32) -> (PathBuf, Held) {
        let out = self.folder.path().join("interrupted");
        let mut command = train(&out, &SETTINGS);
        let held = held_at(&format!("round:{round}"), command.args(["--graph", graph, "--threads", "1"]));
        (out, held)
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
    let (out, mut held) = runs.start(graph, 1);
    held.interrupt(signal);
    let done = held.end();
    assert_eq!(done.code, Some(130), "{}", done.err);
    let how = format!("host-trainer train --resume {}", out.display());
    assert!(done.err.contains(&how), "no “{how}” in: {}", done.err);
    assert_eq!(episodes_of(&checkpoints(&out).pop().expect("a checkpoint")), 4);
    assert!(!out.join("actor.postcard").exists(), "an unfinished run has no actor");
    // Interrupted again after it went on.
    let mut held = held_at("round:3", resume(&out).args(["--threads", "2"]));
    held.interrupt(signal);
    let again = held.end();
    assert_eq!(again.code, Some(130), "{}", again.err);
    assert_eq!(episodes_of(&checkpoints(&out).pop().expect("a checkpoint")), 12);
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
    let held = held_at("round:1", &mut command);
    held.signal(libc::SIGHUP);
    held.go_on();
    let done = held.end();
    assert_eq!(done.code, Some(0), "{}", done.err);
    assert_same(&results(&runs.whole), &results(&out), "after a signal that is ignored");
}

#[test]
fn a_killed_run_goes_on_from_its_last_checkpoint() {
    let runs = runs("gcn");
    let (out, held) = runs.start("gcn", 7);
    held.signal(libc::SIGKILL);
    assert_eq!(held.end().code, None);
    assert_eq!(episodes_of(&checkpoints(&out).pop().expect("a checkpoint")), 24);
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
    let (out, held) = runs.start("gcn", 7);
    held.signal(libc::SIGKILL);
    held.end();
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

#[test]
fn a_second_signal_ends_the_run_at_once() {
    let runs = runs("none");
    let (out, mut held) = runs.start("none", 1);
    held.signal(libc::SIGINT);
    held.wait_for("press Ctrl-C again");
    // Still held: it cannot have come to the end of a round.
    held.signal(libc::SIGTERM);
    let done = held.end();
    assert_eq!(done.code, Some(130), "{}", done.err);
    assert_eq!(episodes_of(&checkpoints(&out).pop().expect("a checkpoint")), 0);
    runs.check(&out);
}

#[test]
fn a_signal_while_it_measures_ends_the_run_and_nothing_is_lost() {
    let runs = runs("none");
    let out = runs.folder.path().join("interrupted");
    let held = held_at("measuring", train(&out, &SETTINGS).args(["--graph", "none", "--threads", "1"]));
    held.signal(libc::SIGTERM);
    let done = held.end();
    assert_eq!(done.code, Some(130), "{}", done.err);
    let how = format!("go on with: host-trainer train --resume {}", out.display());
    assert!(done.err.contains("while quantising and measuring") && done.err.contains(&how), "{}", done.err);
    assert!(!out.join("evaluation.json").exists());
    runs.check(&out);
}

#[test]
fn a_run_folder_has_one_process() {
    let runs = runs("none");
    let (out, mut held) = runs.start("none", 1);
    let id = format!("process {}", held.id());
    refuse(&mut resume(&out), &[&out.display().to_string(), "is in use by", &id, "wait for its end"]);
    held.interrupt(libc::SIGINT);
    held.end();
    assert!(!out.join("run.lock").exists());
    runs.check(&out);
}

/// As when the disk was full before the first checkpoint.
#[test]
fn what_a_failed_start_has_left_does_not_block_the_next() {
    let runs = runs("none");
    let out = runs.folder.path().join("failed");
    fs::create_dir_all(out.join("checkpoints")).expect("a folder");
    fs::write(out.join("config.toml"), "uavs = 7\n").expect("written");
    fs::write(out.join("metrics.jsonl"), "").expect("written");
    fs::write(out.join("run.lock"), "123").expect("written");
    succeed(train(&out, &SETTINGS).args(["--graph", "none", "--quiet"]));
    assert_same(&results(&runs.whole), &results(&out), "in the folder of a failed start");
    // A folder in which something was trained is not one.
    for checkpoint in checkpoints(&out) {
        fs::remove_file(checkpoint).expect("removed");
    }
    refuse(&mut train(&out, &SETTINGS), &["already holds a run"]);
}
