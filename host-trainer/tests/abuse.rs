//! Every command is fed bad files, bad folders, bad numbers, broken outputs and signals: it ends orderly, and says of
//! what it was.
#![cfg(target_os = "linux")]

mod common;

use common::{TINY, copy, succeed, train, trainer};
use covey_tests::{BadFile, End, Table, bad_files, bad_places, bad_values};
use rustix::process::Signal;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const SIGNALS: [Signal; 3] = [Signal::INT, Signal::TERM, Signal::HUP];

/// The whole run that commands read, and a folder for what they make.
struct Bench {
    run: PathBuf,
    folder: PathBuf,
    made: u32,
}

impl Bench {
    /// A path that no other row has.
    fn fresh(&mut self, name: &str) -> String {
        self.made += 1;
        self.folder.join(format!("{}-{name}", self.made)).display().to_string()
    }

    /// A copy of the run, in which `name` is as in `bad`.
    fn spoilt_run(&mut self, name: &str, bad: &BadFile) -> String {
        let run = self.fresh("run");
        copy(&self.run, Path::new(&run));
        let file = Path::new(&run).join(name);
        fs::remove_file(&file).expect("it was there");
        match bad.kind {
            "missing" => {}
            "a folder" | "below" => fs::create_dir(&file).expect("a folder"),
            _ => _ = fs::copy(&bad.path, &file).expect("copied"),
        }
        run
    }

    fn path(&self, name: &str) -> String {
        self.run.join(name).display().to_string()
    }
}

fn with(args: &[&str]) -> Command {
    let mut command = trainer();
    command.args(args);
    command
}

#[test]
fn whatever_it_is_fed_a_command_ends_orderly() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = folder.path().join("run");
    succeed(train(&run, &["episodes=8"]).arg("--quiet"));
    let mut bench = Bench { run, folder: folder.path().to_owned(), made: 0 };
    let mut table = Table::default();
    bad_settings_and_actors(&mut table, &mut bench);
    spoilt_runs(&mut table, &mut bench);
    bad_outs(&mut table, &mut bench);
    bad_numbers(&mut table, &mut bench);
    broken_outputs(&mut table, &mut bench);
    signals(&mut table, &mut bench);
    table.run("host-trainer");
}

fn bad_settings_and_actors(table: &mut Table, bench: &mut Bench) {
    let more: [(&str, &[u8]); 4] = [
        ("huge", b"uavs = 99999999999999999999\n"),
        ("larger than any float", b"learning_rate = 1e999\n"),
        ("not a number", b"learning_rate = nan\n"),
        ("half a line", b"learning_ra"),
    ];
    for bad in bad_files(&bench.folder.join("settings"), "my.toml", b"uavs = 5\nepisodes = \"many\"\n", &more) {
        let file = bad.path.display().to_string();
        let out = bench.fresh("run");
        // An empty file is the defaults, which would train.
        let command = with(&["train", "--config", &file, "--set", "episodes=0", "--out", &out]);
        let end = if bad.kind == "empty" { End::refused(&["episodes"]) } else { End::names(&bad.path, false) };
        table.add(format!("train --config: {}", bad.kind), command, end);
    }
    let actor = fs::read(bench.path("actor.postcard")).expect("an actor");
    for bad in bad_files(&bench.folder.join("actors"), "my.postcard", &actor, &[("text", b"uavs = 5\n")]) {
        let file = bad.path.display().to_string();
        let out = bench.fresh("radio");
        let commands: [&[&str]; 4] = [
            &["inspect", &file],
            &["eval", "--worlds", "2", "--model", &file],
            &["eval", "--worlds", "2", "--radio", "loss=0.5", "--model", &file],
            &["experiment", "radio", "--worlds", "2", "--out", &out, "--model", &file],
        ];
        for args in commands {
            table.add(format!("{}: {}", args[0], bad.kind), with(args), End::names(&bad.path, false));
        }
        let image = with(&["eval", "--worlds", "2", "--actor", "qemu-m7", "--image", &file]);
        if !bad.path.is_file() {
            table.add(format!("eval --image: {}", bad.kind), image, End::names(&bad.path, false));
        }
    }
}

fn spoilt_runs(table: &mut Table, bench: &mut Bench) {
    let newest = common::checkpoints(&bench.run).pop().expect("a checkpoint");
    let newest = newest.strip_prefix(&bench.run).expect("inside").display().to_string();
    let files: [(&str, &[&[&str]]); 5] = [
        ("config.toml", &[&["train", "--resume"], &["eval", "--run"], &["export"], &["report"]]),
        (&newest, &[&["train", "--resume"], &["eval", "--float", "--run"], &["export"]]),
        ("actor.postcard", &[&["eval", "--run"], &["report"]]),
        ("metrics.jsonl", &[&["report"], &["train", "--resume"]]),
        ("evaluation.json", &[&["report"]]),
    ];
    for (name, commands) in files {
        let good = fs::read(bench.run.join(name)).expect("it is there");
        let more: [(&str, &[u8]); 2] = [("huge", b"uavs = 99999999999999999999\n"), ("not a number", b"{\"a\":NaN}\n")];
        for bad in bad_files(&bench.folder.join("files"), "file", &good, &more) {
            for args in commands {
                let run = bench.spoilt_run(name, &bad);
                let mut command = with(args);
                command.arg(&run);
                if args[0] == "export" || args[0] == "report" {
                    command.args(["--out", &bench.fresh("made")]);
                }
                if args[0] == "eval" {
                    command.args(["--worlds", "2"]);
                }
                // What is missing was not made yet; metrics that are cut off are of a run that was.
                let end = End::names(Path::new(&run), bad.kind == "missing" || bad.may_pass || name == "metrics.jsonl");
                table.add(format!("{args:?}, {name}: {}", bad.kind), command, end);
            }
        }
    }
}

fn bad_outs(table: &mut Table, bench: &mut Bench) {
    let run = bench.run.display().to_string();
    for (kind, place) in bad_places(&bench.folder, "out") {
        let out = place.display().to_string();
        let commands: [&[&str]; 4] = [
            &["export", &run],
            &["report", &run],
            &["report", &run, &run],
            &["experiment", "radio", "--worlds", "2", "--uavs", "2"],
        ];
        for args in commands {
            // A folder that is there is taken for what goes into a folder.
            let may_pass = args[0] == "experiment" && kind == "a folder is there";
            let mut command = with(args);
            command.args(["--out", &out]);
            let end = if may_pass { End::Done } else { End::names(place.parent().expect("a folder"), false) };
            table.add(format!("{args:?} --out: {kind}"), command, end);
        }
        if kind != "a folder is there" {
            table.add(format!("train --out: {kind}"), train(&place, &["episodes=4"]), End::names(&place, false));
        }
    }
    let missing = bench.fresh("missing");
    for args in [&["train", "--resume"][..], &["eval", "--run"], &["report"]] {
        let mut command = with(args);
        command.arg(&missing);
        table.add(format!("{args:?}: no run"), command, End::names(Path::new(&missing), false));
    }
    let paper = with(&["experiment", "paper", "--report-only", "--out", &missing]);
    table.add("experiment paper --report-only: no runs", paper, End::names(Path::new(&missing), false));
}

fn bad_numbers(table: &mut Table, bench: &mut Bench) {
    let (run, out) = (bench.run.display().to_string(), bench.fresh("never"));
    let flags: [(&[&str], &str, &str); 17] = [
        (&["train", "--out", "/proc/never"], "--set", "learning_rate="),
        (&["train", "--out", "/proc/never"], "--set", "seed="),
        (&["train", "--out", &out], "--episodes", ""),
        (&["train", "--out", &out, "--set", "episodes=0"], "--seed", ""),
        (&["train", "--out", &out, "--set", "episodes=0"], "--threads", ""),
        (&["eval", "--worlds", "2"], "--uavs", ""),
        (&["eval"], "--worlds", ""),
        (&["eval", "--worlds", "2"], "--seed", ""),
        (&["eval", "--worlds", "2"], "--radio", "loss="),
        (&["export", &run, "--out", &out], "--temperature", ""),
        (&["experiment", "radio", "--worlds", "2", "--out", &out], "--uavs", ""),
        (&["experiment", "radio", "--out", &out], "--worlds", ""),
        (&["experiment", "radio", "--worlds", "2", "--out", &out], "--seed", ""),
        (&["experiment", "paper", "--quick", "--out", &out], "--seeds", ""),
        (&["experiment", "paper", "--quick", "--out", &out], "--jobs", ""),
        (&["bench"], "--repeats", ""),
        (&["bench"], "--inputs", ""),
    ];
    for (args, flag, before) in flags {
        for value in bad_values() {
            let mut command = with(args);
            // With = a minus sign is no flag.
            command.arg(format!("{flag}={before}{value}"));
            // Errors of settings name the setting.
            let named = if before.is_empty() { flag.trim_start_matches('-') } else { before.trim_end_matches('=') };
            // TOML has numbers to the base of 16.
            let named = if (before, value) == ("seed=", "0x10") { "never" } else { named };
            table.add(format!("{} {flag}={before}{value}", args[0]), command, End::refused(&[named]));
        }
    }
}

fn broken_outputs(table: &mut Table, bench: &mut Bench) {
    let (run, actor) = (bench.run.display().to_string(), bench.path("actor.postcard"));
    table.add_broken_outputs("settings", || with(&["settings"]));
    table.add_broken_outputs("inspect", || with(&["inspect", &actor]));
    table.add_broken_outputs("eval", || with(&["eval", "--model", &actor, "--worlds", "2", "--uavs", "5"]));
    let eval = ["eval", "--policy", "hover", "--worlds", "2", "--uavs", "3", "--json"];
    table.add_broken_outputs("eval --json", || with(&eval));
    table.add_broken_outputs("export", || with(&["export", &run, "--out", &bench.fresh("actor")]));
    table.add_broken_outputs("report", || with(&["report", &run, "--out", &bench.fresh("page")]));
    let radio = ["experiment", "radio", "--worlds", "2", "--uavs", "2", "--json", "--out"];
    table.add_broken_outputs("experiment radio", || {
        let mut command = with(&radio);
        command.arg(bench.fresh("radio"));
        command
    });
    table.add_broken_outputs("train", || train(Path::new(&bench.fresh("run")), &["episodes=4"]));
}

fn signals(table: &mut Table, bench: &mut Bench) {
    let (run, actor) = (bench.run.display().to_string(), bench.path("actor.postcard"));
    for signal in SIGNALS {
        let out = bench.fresh("out");
        let mut rate = with(&["bench", "--repeats", "1", "--threads", "1"]);
        TINY.iter().for_each(|set| _ = rate.args(["--set", set]));
        let commands = [
            ("eval", with(&["eval", "--model", &actor, "--worlds", "2"]), "stopped measuring; nothing was written"),
            ("eval --float", with(&["eval", "--run", &run, "--float", "--worlds", "2"]), "stopped measuring"),
            ("export", with(&["export", &run, "--out", &out]), "stopped while quantising and measuring"),
            ("report", with(&["report", &run, "--out", &out]), "the page was not written"),
            ("radio", with(&["experiment", "radio", "--worlds", "2", "--out", &out]), "nothing was written in"),
            ("paper", with(&["experiment", "paper", "--report-only", "--out", &out]), "stopped while measuring"),
            ("bench", rate, "stopped measuring"),
            ("train", train(Path::new(&bench.fresh("run")), &["episodes=4"]), "stopped while quantising and measuring"),
        ];
        for (name, mut command, words) in commands {
            let pipe = bench.fresh("pipe");
            command.env("COVEY_HOLD_AT", format!("measuring:{pipe}"));
            table.add(format!("{name}: {signal:?}"), command, End::Signalled(pipe.into(), signal, Some(words)));
        }
        // While it reads its input, too.
        let pipe = bench.fresh("pipe");
        let eval = with(&["eval", "--model", &pipe]);
        table.add(
            format!("eval reads: {signal:?}"),
            eval,
            End::Signalled(pipe.into(), signal, Some("stopped measuring")),
        );
    }
}
