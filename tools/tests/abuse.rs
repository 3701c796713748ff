//! Every task is fed bad files, a computer without tools, broken outputs and signals: it ends orderly, and says of what
//! it was. Nothing is installed or built: the search path is a folder of the test.
#![cfg(target_os = "linux")]

use covey_tests::{End, Table, bad_files, bad_values};
use rustix::process::Signal;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

const ACTOR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware-core/tests/data/sample-gcn.actor");

struct Bench {
    folder: PathBuf,
    /// A folder without a program, to search for programs.
    nothing: PathBuf,
}

impl Bench {
    /// A task on a computer that has nothing.
    fn task(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
        command.args(args).env("PATH", &self.nothing).env("XDG_CACHE_HOME", &self.nothing);
        command
    }

    /// A task on a computer whose cargo is this script.
    fn with_cargo(&self, name: &str, script: &str, args: &[&str]) -> Command {
        let folder = self.folder.join(name);
        fs::create_dir_all(&folder).expect("a folder");
        let cargo = folder.join("cargo");
        fs::write(&cargo, format!("#!/bin/sh\n{script}\n")).expect("written");
        fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).expect("a program");
        let mut command = self.task(args);
        command.env("PATH", &folder);
        command
    }
}

#[test]
fn whatever_it_is_fed_a_task_ends_orderly() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = Bench { folder: folder.path().to_owned(), nothing: folder.path().join("nothing") };
    fs::create_dir(&bench.nothing).expect("a folder");
    let mut table = Table::default();
    bad_actors(&mut table, &bench);
    bad_computers(&mut table, &bench);
    bad_words(&mut table, &bench);
    broken_outputs(&mut table, &bench);
    signals(&mut table, &bench);
    table.run("xtask");
}

fn bad_actors(table: &mut Table, bench: &Bench) {
    let good = fs::read(ACTOR).expect("an actor");
    for bad in bad_files(&bench.folder.join("actors"), "my.actor", &good, &[("text", b"uavs = 5\n")]) {
        let file = bad.path.display().to_string();
        let commands: [&[&str]; 4] = [
            &["size", &file],
            &["flash", "--board", "nucleo-h743zi", "--dry-run", "--actor", &file],
            &["flash", "--board", "qemu-m7", "--dry-run", "--actor", &file],
            &["flash", "--host", "pilot@uav", "--dry-run", "--actor", &file],
        ];
        for args in commands {
            table.add(format!("{args:?}: {}", bad.kind), bench.task(args), End::names(&bad.path, false));
        }
        if !bad.path.is_file() {
            for (flag, at) in [("--arducopter", bad.path.clone()), ("--px4", bad.path.join("bin/px4"))] {
                table.add(
                    format!("sitl {flag}: {}", bad.kind),
                    bench.task(&["sitl", flag, &file]),
                    End::names(&at, false),
                );
            }
        }
    }
}

/// No tools, tools that fail, and tools that print what nobody understands.
fn bad_computers(table: &mut Table, bench: &Bench) {
    for (args, word) in [
        (&["setup", "qemu-arm"][..], "apt-get"),
        (&["targets"], "apt-get"),
        (&["size", ACTOR], "apt-get"),
        (&["counts"], "apt-get"),
        (&["flash", "--board", "qemu-m4f", "--actor", ACTOR], "apt-get"),
        (&["flash", "--board", "nucleo-h743zi", "--actor-only", "--actor", ACTOR], "probe-rs"),
        (&["flash", "--host", "pilot@uav", "--actor", ACTOR], "ssh"),
        (&["modules"], "cargo"),
        (&["sitl"], "--arducopter"),
        (&["setup", "--check", "qemu-arm"], "missing"),
    ] {
        table.add(format!("{args:?} on a bare computer"), bench.task(args), End::refused(&[word]));
    }
    table.add("a step without cargo", bench.task(&["test", "--only", "fmt"]), End::refused(&[]));
    let scripts =
        [("fails", "exit 3"), ("dies", "kill -9 $$"), ("babbles", "echo '{\"a\": NaN}'"), ("says nothing", "")];
    for (name, script) in scripts {
        let modules = bench.with_cargo(name, script, &["modules"]);
        table.add(format!("modules, cargo {name}"), modules, End::refused(&["cargo metadata"]));
        let step = bench.with_cargo(name, script, &["test", "--only", "fmt"]);
        let end = if script.contains("exit") || script.contains("kill") { End::refused(&[]) } else { End::Done };
        table.add(format!("a step, cargo {name}"), step, end);
    }
}

fn bad_words(table: &mut Table, bench: &Bench) {
    for value in bad_values().into_iter().filter(|value| !value.is_empty()) {
        for args in [&["test", "--only", value][..], &["setup", value], &["flash", "--actor", ACTOR, "--board", value]]
        {
            // What begins with a minus sign is taken for flags.
            let named = if value.starts_with('-') { "-1" } else { value };
            table.add(format!("{args:?}"), bench.task(args), End::refused(&[named]));
        }
        let at_once = format!("--at-once={value}");
        table.add(format!("sitl {at_once}"), bench.task(&["sitl", &at_once]), End::refused(&["--at-once"]));
    }
    for host in ["", "pilot@", "pilot@uav:99999", "pilot@[::1", "ssh://", "pilot@uav:NaN"] {
        let command = bench.task(&["flash", "--dry-run", "--actor", ACTOR, "--host", host]);
        table.add(format!("flash --host {host}"), command, End::refused(&[host]));
    }
}

fn broken_outputs(table: &mut Table, bench: &Bench) {
    table.add_broken_outputs("test --list", || bench.task(&["test", "--list"]));
    for board in ["nucleo-h743zi", "qemu-m7"] {
        let args = ["flash", "--dry-run", "--actor", ACTOR, "--board", board];
        table.add_broken_outputs(board, || bench.task(&args));
    }
    table.add_broken_outputs("flash --host", || {
        bench.task(&["flash", "--dry-run", "--actor", ACTOR, "--host", "pilot@uav"])
    });
}

/// The task ends by the signal, as it waits for a program of which the pipe tells that it runs.
fn signals(table: &mut Table, bench: &Bench) {
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        let name = format!("signal-{}", signal.as_raw());
        let pipe = bench.folder.join(format!("pipe-{name}"));
        let script = format!("read line < {}", Path::new(&pipe).display());
        let command = bench.with_cargo(&name, &script, &["test", "--only", "fmt"]);
        table.add(format!("test: {name}"), command, End::Signalled(pipe, signal, None));
    }
}
