//! Outputs that take nothing: closed, full, and pipes whose reader has gone.
#![cfg(target_os = "linux")]

mod common;

use common::{TINY, copy, succeed, train, trainer, unwrapped};
use std::fs::OpenOptions;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Every command, on a whole run at `run`; `fresh` is a folder in which nothing is yet.
fn commands(run: &Path, fresh: &Path) -> Vec<(&'static str, Command)> {
    let with = |args: &[&str]| {
        let mut command = trainer();
        command.args(args);
        command
    };
    let path = |file: &str| fresh.join(file).display().to_string();
    let (run, actor) = (run.display().to_string(), run.join("actor.postcard").display().to_string());
    let mut bench = with(&["bench", "--repeats", "1", "--threads", "1"]);
    TINY.iter().for_each(|set| _ = bench.args(["--set", set]));
    let mut paper = with(&["experiment", "paper", "--quick", "--graphs", "none", "--seeds", "3", "--worlds", "2"]);
    for set in ["pois=20", "side=80", "steps=10", "rollout_steps=5", "uavs=6", "episodes=8"] {
        paper.args(["--set", set]);
    }
    paper.args(["--out", &path("paper")]);
    vec![
        ("settings", with(&["settings"])),
        ("inspect", with(&["inspect", &actor])),
        ("eval", with(&["eval", "--model", &actor, "--worlds", "2", "--uavs", "5"])),
        ("eval --json", with(&["eval", "--policy", "hover", "--worlds", "2", "--json"])),
        ("eval --float", with(&["eval", "--run", &run, "--float", "--worlds", "2", "--uavs", "5"])),
        ("export", with(&["export", &run, "--out", &path("a.postcard")])),
        ("report", with(&["report", &run, "--out", &path("page.html")])),
        ("radio", with(&["experiment", "radio", "--worlds", "2", "--uavs", "3", "--json", "--out", &path("radio")])),
        ("bench", bench),
        ("paper", paper),
        ("train", train(&fresh.join("run"), &["episodes=8"])),
    ]
}

/// Runs every command with outputs that `spoil` makes, and checks each.
fn each(spoil: impl Fn(&mut Command), check: impl Fn(&str, &Output, &str)) {
    let folder = tempfile::tempdir().expect("a folder");
    let run = folder.path().join("whole");
    succeed(train(&run, &["episodes=8"]).arg("--quiet"));
    let fresh = folder.path().join("fresh");
    copy(&run, &fresh.join("unused"));
    for (name, mut command) in commands(&run, &fresh) {
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        spoil(&mut command);
        let output = command.output().expect("the program starts");
        let err = unwrapped(&String::from_utf8_lossy(&output.stderr));
        assert!(!err.contains("panicked"), "{name}: {err}");
        check(name, &output, &err);
    }
    for made in ["a.postcard", "page.html", "run/actor.postcard", "run/report.html", "paper/report.md"] {
        assert!(fresh.join(made).is_file(), "{made} was not written");
    }
}

fn full() -> Stdio {
    OpenOptions::new().write(true).open("/dev/full").expect("a device of Linux").into()
}

/// A pipe that nobody reads any more.
fn cut() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

#[test]
fn a_full_standard_output_is_an_error_in_words() {
    each(
        |command| _ = command.stdout(full()),
        |name, output, err| {
            assert_eq!(output.status.code(), Some(1), "{name}: {err}");
            assert!(err.contains("cannot write to standard output: No space left on device"), "{name}: {err}");
        },
    );
}

#[test]
fn a_pipe_whose_reader_has_gone_ends_a_command_quietly() {
    each(
        |command| _ = command.stdout(cut()),
        |name, output, err| {
            assert_eq!(output.status.signal(), Some(libc::SIGPIPE), "{name}: {err}");
            assert!(!err.contains("Broken pipe") && !err.contains("cannot write"), "{name}: {err}");
        },
    );
}

#[test]
fn work_goes_on_when_nobody_can_be_told() {
    for error_output in [full, cut] {
        each(
            |command| _ = command.stderr(error_output()),
            |name, output, _| assert_eq!(output.status.code(), Some(0), "{name}"),
        );
    }
}

#[test]
fn work_goes_on_with_both_outputs_closed() {
    each(
        |command| {
            let program = std::mem::replace(command, Command::new("sh"));
            command.args(["-c", r#"exec "$0" "$@" >&- 2>&-"#]).arg(program.get_program()).args(program.get_args());
        },
        |name, output, _| assert_eq!(output.status.code(), Some(0), "{name}"),
    );
}
