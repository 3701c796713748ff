//! Tiny runs through the command line.

// Each test file uses a part of it.
#![allow(dead_code)]

#[cfg(unix)]
pub mod held;

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A run of seconds: a few rounds of a small network on small worlds.
pub const TINY: [&str; 14] = [
    "num_envs=4",
    "shards=2",
    "rollout_steps=10",
    "steps=20",
    "uavs=5",
    "pois=20",
    "side=80",
    "hidden=16",
    "feature=8",
    "head=16",
    "minibatch=100",
    "epochs=2",
    "eval_worlds=4",
    "calibration_worlds=2",
];

/// The program, ready for arguments; its messages are plain text.
pub fn trainer() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-trainer"));
    command.env("NO_COLOR", "1").stdin(Stdio::null());
    command
}

/// `train` with the tiny settings and those given.
pub fn train(out: &Path, settings: &[&str]) -> Command {
    let mut command = trainer();
    command.arg("train").arg("--out").arg(out);
    for setting in TINY.iter().chain(settings) {
        command.args(["--set", setting]);
    }
    command
}

/// `train --resume`.
pub fn resume(run: &Path) -> Command {
    let mut command = trainer();
    command.args(["train", "--resume"]).arg(run);
    command
}

/// What a command did.
pub struct Done {
    /// Exit status; `None` when a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error in one line, as far as line breaks and frames go.
    pub err: String,
}

impl From<Output> for Done {
    fn from(o: Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Self { code: o.status.code(), out: text(&o.stdout), err: unwrapped(&text(&o.stderr)) }
    }
}

/// Messages are wrapped to the width of the terminal, with a frame at the left.
pub fn unwrapped(text: &str) -> String {
    let bare = |line: &str| line.trim().trim_start_matches(['│', '×', '╰', '─', '▶', '├', ' ']).to_owned();
    text.lines().map(bare).collect::<Vec<_>>().join(" ")
}

/// Runs a command to its end.
pub fn finish(command: &mut Command) -> Done {
    command.output().expect("the program starts").into()
}

/// Runs a command that has to succeed.
pub fn succeed(command: &mut Command) -> Done {
    let done = finish(command);
    assert_eq!(done.code, Some(0), "{command:?}: {}", done.err);
    done
}

/// Runs a command that has to fail, orderly, and to say all of `words`.
pub fn refuse(command: &mut Command, words: &[&str]) -> Done {
    let done = finish(command);
    assert!(matches!(done.code, Some(1 | 2)), "{command:?}: exit {:?}: {}", done.code, done.err);
    for word in words {
        assert!(done.err.contains(word), "{command:?}: no “{word}” in: {}", done.err);
    }
    assert!(!done.err.contains("panicked"), "{command:?}: {}", done.err);
    assert!(done.err.matches("(os error").count() <= 1, "a cause that is said twice: {}", done.err);
    done
}

/// What has to be the same in two runs of the same settings: everything but the report
/// (it may name the folder) and TensorBoard's events (they have times).
pub fn results(run: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for name in ["config.toml", "metrics.jsonl", "actor.postcard", "evaluation.json"] {
        let bytes = fs::read(run.join(name)).unwrap_or_else(|e| panic!("{}/{name}: {e}", run.display()));
        found.insert(name.to_owned(), bytes);
    }
    let newest = checkpoints(run).pop().expect("a checkpoint");
    found.insert(name_of(&newest), fs::read(&newest).expect("readable"));
    found
}

/// Panics with the name of the first file in which two runs differ.
pub fn assert_same(one: &BTreeMap<String, Vec<u8>>, other: &BTreeMap<String, Vec<u8>>, what: &str) {
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>(), "{what}");
    for (name, bytes) in one {
        assert!(*bytes == other[name], "{what}: {name} differs");
    }
}

/// A run's checkpoints, oldest first.
pub fn checkpoints(run: &Path) -> Vec<PathBuf> {
    let mut found = files(&run.join("checkpoints"));
    found.retain(|p| p.extension() == Some(OsStr::new("ckpt")));
    found
}

/// Episodes that a checkpoint's name tells.
pub fn episodes_of(checkpoint: &Path) -> u64 {
    let name = name_of(checkpoint);
    name.trim_start_matches("episode-").trim_end_matches(".ckpt").parse().expect("a number of episodes")
}

/// The entries of a folder, sorted.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut found: Vec<_> = entries.map(|e| e.expect("an entry").path()).collect();
    found.sort();
    found
}

fn name_of(path: &Path) -> String {
    path.file_name().expect("a name").to_string_lossy().into_owned()
}

/// Every file below a folder with its bytes.
pub fn everything(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for path in files(folder) {
        if path.is_dir() {
            found.extend(everything(&path));
        } else {
            let bytes = fs::read(&path).expect("readable");
            found.insert(path, bytes);
        }
    }
    found
}

/// Copies a folder with all that is in it.
pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a new folder");
    for path in files(from) {
        let target = to.join(name_of(&path));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).expect("copied");
        }
    }
}
