//! What was made or typed while settings and flags had other names still works.

mod common;

use common::{copy, refuse, resume, succeed, train, trainer};
use host_trainer::experiments::paper::Results;
use std::fs;
use std::path::{Path, PathBuf};

/// A run that was stopped after 4 of 6 episodes, with every setting that has another name now.
fn old_run(folder: &Path) -> PathBuf {
    let run = folder.join("run");
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/run-with-old-names"), &run);
    run
}

#[test]
fn an_old_run_goes_on_and_can_be_used() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = old_run(folder.path());
    let config = fs::read_to_string(run.join("config.toml")).expect("settings");
    for old in ["segment", "worlds", "averaging", "teacher", "teacher_episodes", "scenario"] {
        assert!(config.contains(&format!("\n{old} = ")), "the run was made without {old}");
    }
    let rows = fs::read_to_string(run.join("metrics.jsonl")).expect("rows");
    for command in [&["report"][..], &["eval", "--worlds", "2", "--float", "--run"]] {
        succeed(trainer().args(command).arg(&run));
    }
    let exported = folder.path().join("actor.postcard");
    succeed(trainer().arg("export").arg(&run).arg("--out").arg(&exported));
    for actor in [&exported, &run.join("actor.postcard")] {
        assert!(succeed(trainer().arg("inspect").arg(actor)).out.contains("a sound actor"));
    }
    succeed(resume(&run).arg("--quiet"));
    assert!(run.join("checkpoints/episode-0000000006.ckpt").is_file());
    assert_eq!(fs::read_to_string(run.join("config.toml")).expect("settings"), config);
    let first_rows = |text: &str| text.lines().take(2).map(str::to_owned).collect::<Vec<_>>();
    let now = fs::read_to_string(run.join("metrics.jsonl")).expect("rows");
    assert_eq!((first_rows(&now), now.lines().count()), (first_rows(&rows), 3));
    // What the resumed run wrote has today's names and goes on again.
    succeed(resume(&run).arg("--quiet"));
}

#[test]
fn an_edited_old_run_names_todays_setting() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = old_run(folder.path());
    let config = run.join("config.toml");
    let text = fs::read_to_string(&config).expect("settings");
    fs::write(&config, text.replace("averaging = 0.5", "averaging = 0.25")).expect("written");
    refuse(&mut resume(&run), &["ema_decay = 0.25", "made with 0.5"]);
    fs::write(&config, text.replace("averaging = 0.5", "averaging = 0.5\nema_decay = 0.5")).expect("written");
    refuse(&mut resume(&run), &["`averaging` is the old name of `ema_decay`", "config.toml"]);
}

#[test]
fn old_names_of_settings_are_taken_with_a_word() {
    let folder = tempfile::tempdir().expect("a folder");
    let (config, out) = (folder.path().join("my.toml"), folder.path().join("run"));
    fs::write(&config, "teacher = 0\nclip = 0.3\n").expect("written");
    let mut command = train(&out, &["episodes=4", "averaging=0.5"]);
    let done = succeed(command.arg("--quiet").arg("--config").arg(&config));
    for word in ["`teacher` is now `cloning_weight`", "`averaging` is now `ema_decay`"] {
        assert_eq!(done.err.matches(word).count(), 1, "{}", done.err);
    }
    let written = fs::read_to_string(out.join("config.toml")).expect("settings");
    for line in ["cloning_weight = 0.0\n", "ema_decay = 0.5\n", "clip = 0.3\n"] {
        assert!(written.contains(line), "no {line} in {written}");
    }
    let quiet = succeed(train(&folder.path().join("new"), &["episodes=4", "ema_decay=0.5"]).arg("--quiet"));
    assert_eq!(quiet.err, "");
}

#[test]
fn old_flags_are_taken_with_a_word() {
    let flags = ["--worlds", "2", "--uavs", "3", "--json"];
    let pairs: [(&[&str], &[&str], &[&str]); 2] = [
        (
            &["eval", "--link", "loss=0.5", "--scenario=uniform"],
            &["eval", "--radio", "loss=0.5", "--poi-distribution=uniform"],
            &["`eval --link` is now `eval --radio`", "`eval --scenario` is now `eval --poi-distribution`"],
        ),
        (&["experiment", "link"], &["experiment", "radio"], &["`experiment link` is now `experiment radio`"]),
    ];
    for (old, new, words) in pairs {
        let folder = tempfile::tempdir().expect("a folder");
        let run = |command: &[&str]| {
            let mut program = trainer();
            program.args(command).args(flags);
            if command[0] == "experiment" {
                program.arg("--out").arg(folder.path());
            }
            succeed(&mut program)
        };
        let (old, new) = (run(old), run(new));
        assert_eq!(old.out, new.out);
        for word in words {
            assert!(old.err.contains(word) && !new.err.contains(word), "{}", old.err);
        }
    }
}

/// The committed figures of the paper's experiments were written with other names.
#[test]
fn old_results_are_read_with_todays_names() {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/paper/results.json");
    let text = fs::read_to_string(&results).expect("results");
    let old = text.replacen("\"num_envs\"", "\"worlds\"", 1).replacen("\"ema_decay\"", "\"averaging\"", 1);
    let file = tempfile::NamedTempFile::new().expect("a file");
    fs::write(file.path(), old).expect("written");
    let group = &Results::read(file.path()).expect("sound").groups[0];
    assert_eq!((group.setting("num_envs"), group.setting("ema_decay")), ("64", "0.0"));
}
