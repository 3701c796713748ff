//! Every command is fed bad files, bad folders, bad numbers, broken outputs and signals: it ends orderly, and says of
//! what it was.
#![cfg(target_os = "linux")]

use super::formats::{CSV, KML, LIST, PLAN};
use super::recordings::{ACTOR, a_flight};
use covey_tests::{BadFile, End, Table, bad_files, bad_places, bad_values};
use rustix::process::Signal;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An autopilot's link that nobody else takes.
const LINK: [&str; 2] = ["--autopilot", "udpin:127.0.0.1:0"];

/// Good files, and names for new ones.
struct Bench {
    folder: PathBuf,
    mission: String,
    tlog: String,
    made: u32,
}

impl Bench {
    fn new(folder: &Path) -> Self {
        let (bytes, mission) = a_flight();
        let path = |name: &str| folder.join(name).display().to_string();
        let bench = Self { folder: folder.to_owned(), mission: path("flown.toml"), tlog: path("flown.tlog"), made: 0 };
        fs::write(&bench.mission, mission).unwrap();
        fs::write(&bench.tlog, bytes).unwrap();
        bench
    }

    /// A path that no other row has.
    fn fresh(&mut self, name: &str) -> String {
        self.made += 1;
        self.folder.join(format!("{}-{name}", self.made)).display().to_string()
    }

    fn bad(&self, kind: &str, name: &str, good: &[u8], more: &[(&'static str, &[u8])]) -> Vec<BadFile> {
        bad_files(&self.folder.join(kind), name, good, more)
    }
}

fn with(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sitl-bridge"));
    command.args(args).env("NO_COLOR", "1");
    command
}

#[test]
fn whatever_it_is_fed_a_command_ends_orderly() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = Bench::new(folder.path());
    let mut table = Table::default();
    bad_missions(&mut table, &mut bench);
    bad_actors_and_keys(&mut table, &mut bench);
    bad_recordings(&mut table, &mut bench);
    bad_outs(&mut table, &mut bench);
    bad_numbers(&mut table, &mut bench);
    broken_outputs(&mut table, &mut bench);
    signals(&mut table, &mut bench);
    table.run("sitl-bridge");
}

fn bad_missions(table: &mut Table, bench: &mut Bench) {
    let toml = fs::read(&bench.mission).unwrap();
    let more: [(&str, &[u8]); 3] = [
        ("huge", b"side_u = 99999999999999999999\n"),
        ("larger than any float", b"side_u = 1e999\n"),
        ("not a number", b"origin = { lat = nan, lon = 8.5, alt_m = 400.0 }\npois_u = [[1, 2]]\n"),
    ];
    for bad in bench.bad("missions", "my.toml", &toml, &more) {
        let file = bad.path.display().to_string();
        let commands: [(&str, Command); 5] = [
            ("mission check", with(&["mission", "check", &file])),
            ("mission convert", with(&["mission", "convert", &file, "-"])),
            ("replay", with(&["replay", &bench.tlog, "--actor", ACTOR, "--other-mission", "--mission", &file])),
            // What may pass would fly: the id is refused then.
            ("fly", with(&[&["fly", "--id", "254", "--mission", &file], &LINK[..]].concat())),
            ("swarm", with(&[&["swarm", "--first-id", "254", "--count", "1", "--mission", &file], &LINK[..]].concat())),
        ];
        for (name, command) in commands {
            let flies = name == "fly" || name == "swarm";
            let end = if flies && bad.may_pass { End::refused(&[]) } else { End::names(&bad.path, bad.may_pass) };
            table.add(format!("{name}: {}", bad.kind), command, end);
        }
    }
    let geojson = r#"{"type":"FeatureCollection","covey":{"origin":{"lat":47.4,"lon":8.5,"alt_m":400}},"features":[
        {"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[8.501,47.401]}}]}"#;
    for (name, good) in
        [("my.geojson", geojson), ("my.kml", KML), ("my.csv", CSV), ("my.plan", PLAN), ("my.waypoints", LIST)]
    {
        // The first number of the text becomes these.
        let (before, after) = good.split_once("47.4").unwrap();
        let [huge, infinite, none] = ["99999999999999999999", "1e999", "NaN"].map(|n| format!("{before}{n}{after}"));
        let more: [(&str, &[u8]); 3] = [
            ("huge", huge.as_bytes()),
            ("larger than any float", infinite.as_bytes()),
            ("not a number", none.as_bytes()),
        ];
        for bad in bench.bad(name, name, good.as_bytes(), &more) {
            let file = bad.path.display().to_string();
            let out = bench.fresh("made.toml");
            let check = with(&["mission", "check", &file]);
            table.add(format!("mission check {name}: {}", bad.kind), check, End::names(&bad.path, bad.may_pass));
            let convert = with(&["mission", "convert", "--alt-m", "400", &file, &out]);
            // In waypoints the first number is the home's, which is laid around the rest once an altitude is given.
            let may_pass = bad.may_pass || name == "my.waypoints" && more.iter().any(|(kind, _)| *kind == bad.kind);
            table.add(format!("mission convert {name}: {}", bad.kind), convert, End::names(&bad.path, may_pass));
        }
    }
}

fn bad_actors_and_keys(table: &mut Table, bench: &mut Bench) {
    let mission = bench.mission.clone();
    let fly = [&["fly", "--id", "1", "--mission", &mission], &LINK[..]].concat();
    for bad in bench.bad("actors", "my.actor", &fs::read(ACTOR).unwrap(), &[("text", b"side_u = 1\n")]) {
        let file = bad.path.display().to_string();
        let commands: [&[&str]; 6] = [
            &["self-test", &file],
            &["signature", &file],
            &["replay", &bench.tlog, "--mission", &mission, "--actor", &file],
            &["swarm", "--count", "1", "--mission", &mission, "--actor", &file],
            &["swarm", "--sim", "--count", "1", "--actor", &file],
            &[&fly[..], &["--actor", &file]].concat(),
        ];
        for args in commands {
            table.add(format!("{}: {}", args[0], bad.kind), with(args), End::names(&bad.path, false));
        }
    }
    let key = b"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\n";
    for bad in bench.bad("keys", "my.key", key, &[]) {
        let file = bad.path.display().to_string();
        let command = with(&[&fly[..], &["--signing-key-file", &file]].concat());
        // Others may read them, which is refused whatever they hold.
        table.add(format!("fly --signing-key-file: {}", bad.kind), command, End::names(&bad.path, false));
    }
    for bad in bench.bad("states", "my.state", b"1\n", &[]).into_iter().filter(|bad| !bad.may_pass) {
        if bad.kind != "missing" {
            let file = bad.path.display().to_string();
            let command = with(&[&fly[..], &["--signing-state", &file]].concat());
            table.add(format!("fly --signing-state: {}", bad.kind), command, End::names(&bad.path, false));
        }
    }
}

fn bad_recordings(table: &mut Table, bench: &mut Bench) {
    let good = fs::read(&bench.tlog).unwrap();
    let mission = bench.mission.clone();
    for bad in bench.bad("tlogs", "my.tlog", &good, &[("text", b"FMT, 128, 89, FMT\n")]) {
        let file = bad.path.display().to_string();
        for json in [&[][..], &["--json"]] {
            let command = with(&[&["replay", &file, "--actor", ACTOR, "--mission", &mission], json].concat());
            let may_pass = bad.kind == "cut off";
            table.add(format!("replay: {}", bad.kind), command, End::names(&bad.path, may_pass));
        }
    }
}

fn bad_outs(table: &mut Table, bench: &mut Bench) {
    let mission = bench.mission.clone();
    for (kind, place) in bad_places(&bench.folder, "out") {
        let out = place.display().to_string();
        let commands: [(&str, &[&str]); 4] = [
            ("mission convert", &["mission", "convert", "--force", &mission, &out]),
            ("fly --tlog", &["fly", "--id", "1", "--mission", &mission, LINK[0], LINK[1], "--tlog", &out]),
            (
                "fly --signing-state",
                &["fly", "--id", "1", "--mission", &mission, LINK[0], LINK[1], "--signing-state", &out],
            ),
            ("swarm --tlog", &["swarm", "--count", "1", "--mission", &mission, LINK[0], LINK[1], "--tlog", &out]),
        ];
        for (name, args) in commands {
            // Where a folder is wanted, one is no trouble, but then it would fly.
            if !(name == "swarm --tlog" && kind == "a folder is there") {
                table.add(format!("{name}: {kind}"), with(args), End::names(&place, false));
            }
        }
    }
    for python in ["/nowhere/python", "/dev/null"] {
        let command = with(&["swarm", "--sim", "--count", "1", "--python", python]);
        table.add(format!("swarm --python {python}"), command, End::refused(&[python]));
    }
}

fn bad_numbers(table: &mut Table, bench: &mut Bench) {
    let mission = bench.mission.clone();
    let out = bench.fresh("never.toml");
    // What is taken would fly: nobody has that id.
    let fly = ["fly", "--id", "254", "--mission", &mission, LINK[0], LINK[1]];
    let swarm = ["swarm", "--first-id", "254", "--mission", &mission, LINK[0], LINK[1]];
    let simulated = ["swarm", "--sim", "--python", "/nowhere/python"];
    let flags: [(&[&str], &[&str]); 6] = [
        (&["mission"], &["--world", "--seed", "--pois", "--lat", "--lon", "--alt"]),
        (
            &["mission", "convert", &mission, &out],
            &["--alt-m", "--scale-m", "--side-u", "--step-ms", "--policy-seed", "--layers", "--margin-u", "--base-m"],
        ),
        (&fly, &["--rate-hz", "--encode-ms", "--beacon-hz", "--lead-ms", "--system", "--vehicle-system", "--wait-for"]),
        (&swarm, &["--count", "--port-step"]),
        (&simulated, &["--worlds", "--first-world", "--seed", "--pois", "--steps", "--speed"]),
        (&["signature", ACTOR], &["--cases"]),
    ];
    for (args, flags) in flags {
        for flag in flags {
            for value in bad_values() {
                let mut command = with(args);
                command.arg(format!("{flag}={value}"));
                // Fields of missions have the flags' names, but for the bars.
                let named = flag.trim_start_matches('-').split('-').next().unwrap();
                table.add(format!("{} {flag}={value}", args[0]), command, End::refused(&[named]));
            }
        }
    }
    for link in
        ["", "x", "udpin:", "udpin:127.0.0.1:99999", "tcp:[::1", "serial:/dev/null:NaN", "serial:/nowhere:57600"]
    {
        let command = with(&["fly", "--id", "1", "--mission", &mission, "--autopilot", link]);
        let named = if link.contains("/nowhere") { "/nowhere" } else { link };
        table.add(format!("fly --autopilot {link}"), command, End::refused(&[named]));
        let command = with(&["fly", "--id", "1", "--mission", &mission, LINK[0], LINK[1], "--swarm", link]);
        table.add(format!("fly --swarm {link}"), command, End::refused(&[link]));
    }
}

fn broken_outputs(table: &mut Table, bench: &mut Bench) {
    let (mission, tlog) = (bench.mission.clone(), bench.tlog.clone());
    let replay = ["replay", &tlog, "--actor", ACTOR, "--mission", &mission];
    table.add_broken_outputs("mission", || with(&["mission"]));
    table.add_broken_outputs("mission check", || with(&["mission", "check", &mission]));
    table.add_broken_outputs("mission check --json", || with(&["mission", "check", "--json", &mission]));
    table.add_broken_outputs("mission convert", || with(&["mission", "convert", &mission, "-"]));
    table.add_broken_outputs("self-test", || with(&["self-test", ACTOR]));
    table.add_broken_outputs("signature", || with(&["signature", "--cases", "10", ACTOR]));
    table.add_broken_outputs("replay", || with(&replay));
    table.add_broken_outputs("replay --json", || with(&[&replay[..], &["--json"]].concat()));
}

fn signals(table: &mut Table, bench: &mut Bench) {
    let mission = bench.mission.clone();
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        // It reads the pipe in place of the recording, or of the mission that it is to fly.
        let pipe = bench.fresh("pipe");
        let command = with(&["replay", &pipe, "--actor", ACTOR, "--mission", &mission]);
        let end = End::Signalled(pipe.into(), signal, Some("stopped replaying"));
        table.add(format!("replay: {signal:?}"), command, end);
    }
}
