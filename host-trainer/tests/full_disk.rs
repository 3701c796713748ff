//! A disk that takes no more: the run stops and says why, the last good checkpoint is
//! intact, and with room again the run ends as if nothing had happened.
#![cfg(target_os = "linux")]

mod common;

use common::{Done, assert_same, checkpoints, files, finish, results, resume, succeed, train, trainer};
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The run that has room all along.
fn whole(folder: &Path, settings: &[&str]) -> PathBuf {
    let out = folder.join("whole");
    succeed(train(&out, settings).arg("--quiet"));
    out
}

fn length(file: &Path) -> u64 {
    fs::metadata(file).unwrap_or_else(|e| panic!("{}: {e}", file.display())).len()
}

/// Stopped orderly, with a newest checkpoint that is sound and nothing half made; and
/// from there the run ends as the one that had room.
fn check(done: &Done, run: &Path, whole: &Path) {
    assert_eq!(done.code, Some(1), "{}", done.err);
    assert!(!done.err.contains("panicked"), "{}", done.err);
    assert!(!run.join("actor.postcard").exists(), "an actor of an unfinished run");
    let made = files(&run.join("checkpoints"));
    assert_eq!(made, checkpoints(run), "something half made is left");
    let newest = made.last().expect("a checkpoint");
    assert!(common::episodes_of(newest) > 0, "{}", newest.display());
    succeed(trainer().arg("export").arg(run).arg("--out").arg(run.with_extension("postcard")));
    succeed(resume(run).args(["--threads", "1", "--quiet"]));
    assert_same(&results(whole), &results(run), "with room again");
}

/// Limits the size of any file that a command writes: writing more is then an error, for
/// root too.
fn limit_files(command: &mut Command, bytes: u64) -> &mut Command {
    let limit = libc::rlimit { rlim_cur: bytes, rlim_max: bytes };
    // SAFETY: both calls are allowed between fork and exec. Ignoring the signal makes the
    // write fail instead of ending the process.
    unsafe {
        command.pre_exec(move || {
            libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
            match libc::setrlimit(libc::RLIMIT_FSIZE, &limit) {
                0 => Ok(()),
                _ => Err(std::io::Error::last_os_error()),
            }
        })
    }
}

/// Checkpoints fit, but the events grow until a row does not.
#[test]
fn files_that_cannot_grow_stop_the_run_and_lose_nothing() {
    let settings = ["episodes=160", "checkpoint_every=16", "hidden=4", "feature=2", "head=4"];
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, out) = (whole(folder.path(), &settings), folder.path().join("stopped"));
    let (events, checkpoint) = (length(&files(&whole.join("events"))[0]), length(&checkpoints(&whole)[0]));
    let limit = checkpoint + checkpoint / 8;
    assert!(limit < events, "events of {events} bytes fit beside a checkpoint of {checkpoint}: use more episodes");
    let done = finish(limit_files(train(&out, &settings).arg("--quiet"), limit));
    assert!(done.err.contains("File too large") && done.err.contains("stopped"), "{}", done.err);
    check(&done, &out, &whole);
}

/// A disk on which two checkpoints have room, but not three.
#[test]
fn a_full_disk_stops_the_run_and_loses_nothing() {
    let settings = ["episodes=40", "checkpoint_every=8"];
    let folder = tempfile::tempdir().expect("a folder");
    let whole = whole(folder.path(), &settings);
    let (disk, kept) = (folder.path().join("disk"), folder.path().join("kept"));
    fs::create_dir(&disk).expect("a folder");
    let size = length(&checkpoints(&whole)[0]) * 27 / 10;
    // A small disk of its own that only this process and its children see. What is on it
    // when the run has stopped is copied off.
    let script = r#"mount -t tmpfs -o size="$1" tmpfs "$2" || exit 99; disk=$2; kept=$3; shift 3
        "$@"; code=$?; cp -a "$disk/run" "$kept"; exit $code"#;
    let mut command = Command::new("unshare");
    command.args(["--user", "--map-root-user", "--mount", "sh", "-c", script, "sh"]);
    command.arg(size.to_string()).arg(&disk).arg(&kept);
    let run = train(&disk.join("run"), &settings);
    command.arg(run.get_program()).args(run.get_args()).arg("--quiet").env("NO_COLOR", "1");
    let Ok(output) = command.output() else {
        eprintln!("no `unshare` on this machine: a disk of one's own cannot be made");
        return;
    };
    let done = Done::from(output);
    if !kept.exists() && done.err.contains("unshare") || done.code == Some(99) {
        eprintln!("this machine lets nobody mount a disk of one's own: {}", done.err);
        return;
    }
    assert!(done.err.contains("No space left on device"), "{}", done.err);
    assert!(done.err.contains("Free space on the disk") && done.err.contains("untouched"), "{}", done.err);
    check(&done, &kept, &whole);
}
