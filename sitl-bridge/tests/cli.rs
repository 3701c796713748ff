//! The command line, as a user meets it: what goes wrong is said with the way out.

use std::io::{BufRead as _, BufReader, Read as _};
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn bridge() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sitl-bridge"))
}

fn run(args: &[&str]) -> Output {
    bridge().args(args).stdin(Stdio::null()).output().unwrap()
}

/// What a failed command says, in one line: the report breaks lines and marks them.
fn refused(args: &[&str]) -> String {
    let output = run(args);
    assert!(!output.status.success(), "{args:?} passed");
    let text = String::from_utf8_lossy(&output.stderr).replace(['│', '╰', '├', '─', '▶', '×'], " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn mission(folder: &Path) -> String {
    let output = run(&["mission", "--world", "3"]);
    assert!(output.status.success());
    let path = folder.join("mission.toml");
    std::fs::write(&path, output.stdout).unwrap();
    path.display().to_string()
}

/// A program that says it and fails.
fn script(folder: &Path, text: &str) -> String {
    let path = folder.join("python");
    std::fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
    std::fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    path.display().to_string()
}

#[test]
fn a_fleet_without_python_or_its_packages() {
    let message = refused(&["swarm", "--sim", "--python", "/nowhere/python"]);
    assert!(message.contains("cannot start the fleet's Python, /nowhere/python"), "{message}");
    assert!(message.contains("cargo xtask setup"), "{message}");
    let folder = tempfile::tempdir().unwrap();
    let python = script(folder.path(), "echo \"ModuleNotFoundError: No module named 'pymavlink'\" >&2; exit 1");
    let message = refused(&["swarm", "--sim", "--python", &python]);
    assert!(message.contains("has no pymavlink; `cargo xtask setup`"), "{message}");
    let python = script(folder.path(), "echo out of paper >&2; exit 3");
    let message = refused(&["swarm", "--sim", "--python", &python]);
    assert!(message.contains("the fleet ended (exit status: 3): out of paper"), "{message}");
}

#[test]
fn real_autopilots_that_cannot_be_had() {
    let message = refused(&["swarm", "--sim", "gazebo"]);
    assert!(message.contains("use simlink, arducopter=PROGRAM or px4=FOLDER"), "{message}");
    let message = refused(&["swarm", "--sim", "arducopter="]);
    assert!(message.contains("the program is missing"), "{message}");
    let message = refused(&["swarm", "--sim", "arducopter=/nowhere/arducopter"]);
    assert!(message.contains("/nowhere/arducopter: no such program; build ArduPilot's SITL"), "{message}");
    let message = refused(&["swarm", "--sim", "px4=/nowhere"]);
    assert!(message.contains("/nowhere: no bin/px4 in there"), "{message}");
    // What simulated autopilots alone can do.
    for option in [&["--ideal"][..], &["--px4"], &["--fleet", "{}"]] {
        let message = refused(&[&["swarm", "--sim", "arducopter=sh"], option].concat());
        assert!(message.contains("is for simlink alone"), "{message}");
    }
    let message = refused(&["swarm", "--sim", "px4=/nowhere", "--speed", "2"]);
    assert!(message.contains("PX4 tells the host's time"), "{message}");
}

#[test]
fn ports_that_are_taken_and_ids_that_do_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let mission = mission(folder.path());
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = format!("udpin:127.0.0.1:{}", taken.local_addr().unwrap().port());
    let message = refused(&["fly", "--id", "3", "--mission", &mission, "--autopilot", &address]);
    assert!(message.contains("another program listens there"), "{message}");
    let message = refused(&["fly", "--id", "255", "--mission", &mission, "--autopilot", "udpin:127.0.0.1:0"]);
    assert!(message.contains("ids go up to 254"), "{message}");
    let message = refused(&["fly", "--id", "20", "--mission", &mission, "--autopilot", "udpin:127.0.0.1:0"]);
    assert!(message.contains("UAV 20 has no altitude layer of its own: the mission has 20"), "{message}");
    let many = ["--count", "21", "--port-step", "0", "--autopilot", "udpout:127.0.0.1:9", "--mission", &mission];
    let message = refused(&[&["swarm"][..], &many].concat());
    assert!(message.contains("UAV 20 has no altitude layer of its own"), "{message}");
    let message = refused(&["fly", "--id", "1", "--mission", &mission, "--autopilot", "carrier-pigeon:x"]);
    assert!(message.contains("no kind of connection"), "{message}");
    let message = refused(&["swarm", "--count", "200", "--port-step", "1000", "--mission", &mission]);
    assert!(message.contains("no link for UAV"), "{message}");
}

#[test]
fn actors_and_missions_that_cannot_fly() {
    let folder = tempfile::tempdir().unwrap();
    let mission = mission(folder.path());
    let message = refused(&["fly", "--id", "1", "--mission", &mission, "--actor", &mission]);
    assert!(message.contains("mission.toml is no actor file that can fly"), "{message}");
    let message = refused(&["swarm", "--sim", "--actor", "/nowhere"]);
    assert!(message.contains("cannot read /nowhere"), "{message}");
    let bad = folder.path().join("bad.toml");
    std::fs::write(&bad, std::fs::read_to_string(&mission).unwrap().replace("step_ms = 2000", "step_ms = 20")).unwrap();
    let message = refused(&["fly", "--id", "1", "--mission", &bad.display().to_string()]);
    assert!(message.contains("line 5: step_ms = 20; use 200 to 32767"), "{message}");
    let timing = ["--encode-ms", "900", "--autopilot", "udpin:127.0.0.1:0"];
    let message = refused(&[&["fly", "--id", "1", "--mission", &mission][..], &timing].concat());
    assert!(message.contains("must follow each other within a step of 2000 ms"), "{message}");
}

#[test]
fn a_stopped_node_says_what_the_vehicle_does() {
    let folder = tempfile::tempdir().unwrap();
    let mission = mission(folder.path());
    use rustix::process::Signal;
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        let mut node = bridge()
            .args(["fly", "--id", "3", "--mission", &mission, "--autopilot", "udpin:127.0.0.1:0"])
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stderr = BufReader::new(node.stderr.take().unwrap());
        let mut lines = String::new();
        while !lines.contains("flying alone") {
            assert!(stderr.read_line(&mut lines).unwrap() > 0, "it ended: {lines}");
        }
        assert!(lines.contains("listening on udp 127.0.0.1:"), "{lines}");
        let pid = rustix::process::Pid::from_child(&node);
        rustix::process::kill_process(pid, signal).unwrap();
        stderr.read_to_string(&mut lines).unwrap();
        assert!(node.wait().unwrap().success(), "{lines}");
        assert!(lines.contains("stopped: nothing was in the air"), "{lines}");
    }
}
