//! Faults of flights against the simulated autopilots, where it matters what the autopilot does: its own time-outs
//! and failsafes, and that the node never works against them. One flight, a UAV for each fault.

mod swarm;

use covey_env::{Scenario, World};
use firmware_core::gate::Limits;
use serde_json::{Value, json};
use sitl_bridge::mission::{Layers, Mission, Origin};
use sitl_bridge::node::run::NodeEvent;
use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use swarm::{Plan, Swarm};

/// The fleet's clock begins here, Unix time in ms; steps too.
const START_MS: i64 = 1_795_305_600_000;
/// While nothing streams setpoints the fleet runs so many times as fast as the wall's clock: a node that a busy computer
/// holds up for a second must not seem dead.
const SPEED: u32 = 5;
/// Faults that begin in transit come this long after the first in flight, fleet's ms.
const AFTER_MS: i64 = 4000;

fn mission() -> Mission {
    let mut world = World::new(&Scenario::default()).unwrap();
    world.reset(777, 0);
    let mut mission = Mission::of_world(&world, Origin::default()).unwrap();
    mission.layers = Layers { base_m: 10.0, spacing_m: 1.0, count: 10 };
    mission.epoch_unix_ms = START_MS;
    mission
}

/// A flight of one UAV for each fault, until the fleet's clock is at `until_s`.
struct Flight {
    /// The fleet's events of each UAV.
    events: BTreeMap<u64, Vec<Value>>,
    /// Warnings and news of each node.
    notices: BTreeMap<usize, Vec<String>>,
    /// The fleet's closing figures.
    stats: Value,
}

impl Flight {
    fn fly(faults: &[Value], until_s: i64) -> Self {
        let pads = (0..faults.len()).map(|i| [40.0 + 15.0 * i as f64, 100.0]).collect();
        let mut fleet = json!({"unix_ms": START_MS, "speed": SPEED, "seed": 1});
        fleet["faults"] = faults.iter().enumerate().map(|(id, fault)| with_id(fault, id)).collect();
        let Value::Object(fleet) = fleet else { unreachable!() };
        // The fleet waits for a node that fell silent by the wall clock.
        let limits = Limits { link_wall_ms: 120_000, ..Limits::simulation() };
        let mut swarm = Swarm::launch(&Plan { mission: mission(), pads, sequence: None, limits, fleet });
        let mut flight = Self { events: BTreeMap::new(), notices: BTreeMap::new(), stats: Value::Null };
        let mut now_s = 0;
        while now_s < until_s {
            // The fleet tells of itself once a step at least.
            let event = swarm.fleet.next_event().unwrap();
            now_s = now_s.max(event["t_ms"].as_i64().unwrap_or(0) / 1000);
            flight.hear(event);
            swarm.reports.try_iter().for_each(|report| flight.take(report));
        }
        let (_, last) = swarm.end();
        last.into_iter().for_each(|event| flight.hear(event));
        flight
    }

    fn take(&mut self, (id, report): (usize, NodeEvent)) {
        if let NodeEvent::Notice(notice) = report {
            self.notices.entry(id).or_default().push(notice.text);
        }
    }

    fn hear(&mut self, event: Value) {
        if event["event"] == "stats" {
            self.stats = event;
        } else if let Some(id) = event["id"].as_u64() {
            self.events.entry(id).or_default().push(event);
        }
    }

    /// The first event of this name after the fault of this UAV began.
    fn event(&self, id: u64, name: &str) -> &Value {
        self.find(id, name).unwrap_or_else(|| panic!("no {name} of {id}: {}", self.story(id)))
    }

    fn find(&self, id: u64, name: &str) -> Option<&Value> {
        let after = self.events[&id].iter().skip_while(|event| event["event"] != "fault");
        after.into_iter().find(|event| event["event"] == name)
    }

    /// Fleet's ms from the beginning of the fault to this event.
    fn delay_ms(&self, id: u64, name: &str) -> i64 {
        self.event(id, name)["t_ms"].as_i64().unwrap() - self.event(id, "fault")["t_ms"].as_i64().unwrap()
    }

    fn said(&self, id: usize, text: &str) {
        let said = self.notices[&id].iter().any(|notice| notice.contains(text));
        assert!(said, "nobody said {text}: {}", self.story(id as u64));
    }

    /// GUIDED was not taken, and nothing armed, after the fault.
    fn never_retaken(&self, id: u64) {
        let after = self.events[&id].iter().skip_while(|event| event["event"] != "fault");
        let mut taken = after.filter(|e| e["event"] == "armed" || (e["event"] == "mode" && e["mode"] == "GUIDED"));
        assert!(taken.next().is_none(), "{}", self.story(id));
    }

    /// The autopilot had nothing to refuse.
    fn not_asked(&self, id: usize) {
        assert!(!self.notices[&id].iter().any(|notice| notice.contains("refused")), "{}", self.story(id as u64));
    }

    fn story(&self, id: u64) -> String {
        format!("{:?} {:?}", self.events.get(&id), self.notices.get(&(id as usize)))
    }
}

fn with_id(fault: &Value, id: usize) -> Value {
    let mut fault = fault.clone();
    fault["id"] = id.into();
    fault
}

#[test]
fn the_autopilot_keeps_what_the_node_lets_go() {
    let transit = |kind: &str| json!({"kind": kind, "phase": "transit", "after_ms": AFTER_MS});
    let flight = Flight::fly(
        &[
            transit("pose_frozen"),
            transit("nan"),
            transit("pose_stale"),
            json!({"kind": "pilot_mode", "mode": "LOITER", "phase": "transit", "after_ms": AFTER_MS}),
            json!({"kind": "link_cut", "phase": "transit", "after_ms": AFTER_MS, "for_ms": 20_000}),
            json!({"kind": "reboot", "phase": "transit", "after_ms": AFTER_MS}),
            json!({"kind": "reboot", "phase": "takeoff"}),
            json!({"kind": "pilot_mode", "mode": "LOITER", "phase": "takeoff", "after_ms": 1000}),
            transit("gps_lost"),
        ],
        70,
    );
    // A stop: zero velocity, then silence. It brakes at once, from 5 m/s at most, and stands long before the
    // autopilot's own timeout comes, 3 s after the last setpoint: flying on would be 15 m.
    for (id, reason) in [(0, "state_frozen"), (1, "number_refused"), (2, "state_stale")] {
        flight.said(id, &format!("holding the place: {reason}"));
        flight.said(id, &format!("no setpoints: {reason}"));
        let timeout = flight.event(id as u64, "timeout");
        assert!(timeout["flown_m"].as_f64().unwrap() < 7.5, "{timeout}");
        // Detection, a second of zero velocity, the timeout, and ticks.
        assert!(flight.delay_ms(id as u64, "timeout") <= 1700 + 1200 + 3200 + 400, "{}", flight.story(id as u64));
        flight.never_retaken(id as u64);
    }
    // The pilot has it at once and for good.
    flight.said(3, "no setpoints: mode_left");
    assert!(flight.find(3, "timeout").is_none() && flight.find(3, "failsafe").is_none(), "{}", flight.story(3));
    flight.never_retaken(3);
    // Without a link the autopilot's timeout stops it; then it misses the node's heartbeat and returns. When the link
    // is back the node sees that and keeps still.
    let timeout = flight.event(4, "timeout");
    assert!((2800..=3400).contains(&timeout["silent_ms"].as_i64().unwrap()), "{timeout}");
    // Until then it goes on along its last setpoint: 5 m/s and 2.5 m/s² at most.
    assert!(timeout["flown_m"].as_f64().unwrap() < 5.0 * 3.4 + 1.25 * 3.4 * 3.4, "{timeout}");
    let failsafe = flight.event(4, "failsafe");
    assert!(failsafe["reason"] == "GCS" && (4000..=7000).contains(&flight.delay_ms(4, "failsafe")), "{failsafe}");
    assert!(flight.notices[&4].iter().any(|n| n.contains("no setpoints")), "{}", flight.story(4));
    flight.never_retaken(4);
    // A reboot in the air is a crash; one just off the ground is not, and nobody arms it again.
    assert_eq!(flight.event(5, "reboot")["id"], 5);
    flight.never_retaken(5);
    assert_eq!(flight.event(6, "reboot")["id"], 6);
    flight.said(6, "no setpoints: mode_left");
    flight.not_asked(6);
    flight.never_retaken(6);
    // A pilot who takes over in the climb keeps it.
    flight.said(7, "no setpoints: mode_left");
    flight.not_asked(7);
    flight.never_retaken(7);
    // Without GPS the node stops it, and the autopilot lands for its estimator; it is not taken out of that.
    flight.said(8, "holding the place: ");
    assert_eq!(flight.event(8, "failsafe")["reason"], "EKF");
    flight.never_retaken(8);
}

/// A node as a process of its own, that can be killed.
struct Process {
    child: Child,
    port: u16,
}

impl Process {
    fn start(mission: &std::path::Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_sitl-bridge"))
            .args(["fly", "--id", "0", "--takeoff", "--simulated", "--autopilot", "udpin:127.0.0.1:0"])
            // The ground station's id, so that the autopilot's failsafe watches the node.
            .args(["--system", "255", "--mission"])
            .arg(mission)
            .stderr(Stdio::piped())
            .stdin(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut all = String::new();
        while !line.starts_with("autopilot: ") {
            line.clear();
            assert!(said.read_line(&mut line).unwrap() > 0, "it ended: {all}");
            all += &line;
        }
        // Whatever it says later must not stop it.
        std::thread::spawn(move || said.lines().map_while(Result::ok).for_each(drop));
        let port = line.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).next_back();
        Self { child, port: port.unwrap_or_else(|| panic!("no port in {line}")) }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_killed_node_leaves_the_autopilots_own_timeout_to_stop_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.toml");
    std::fs::write(&path, mission().to_toml("")).unwrap();
    let mut node = Process::start(&path);
    let config = json!({
        "vehicles": [{"id": 0, "system": 1, "port": node.port, "start_u": [100, 100]}],
        "origin": {"lat": Origin::default().lat, "lon": Origin::default().lon, "alt": Origin::default().alt_m},
        "epoch_unix_ms": START_MS, "unix_ms": START_MS, "speed": SPEED, "lockstep_timeout_s": 10,
        // As docs/safety.md tells to set it.
        "guided_timeout_s": 1, "parameters": {"FS_GCS_ENABLE": 1},
    });
    let python = sitl_bridge::simulation::find_python(None);
    let mut fleet = sitl_bridge::simulation::Fleet::start(&python, "simlink", &config, false).unwrap();
    let mut events = Vec::new();
    let mut killed_ms = None;
    let named = |events: &[Value], name: &str| events.iter().find(|e: &&Value| e["event"] == name).cloned();
    while named(&events, "failsafe").is_none() {
        events.push(fleet.next_event().unwrap());
        let fast = |event: &Value| {
            let v = &event["v"][0];
            let (x, y) = (v[0].as_f64().unwrap_or(0.0), v[1].as_f64().unwrap_or(0.0));
            // 3 m/s.
            x.hypot(y) > 2.4
        };
        if killed_ms.is_none()
            && let Some(moving) = events.iter().find(|e| e["event"] == "truth" && fast(e))
        {
            killed_ms = moving["t_ms"].as_i64();
            node.child.kill().unwrap();
        }
    }
    // It goes on along its last setpoint, 5 m/s and 2.5 m/s² at most, until the timeout of 1 s, brakes, and stands.
    let (timeout, stopped) = (named(&events, "timeout").unwrap(), named(&events, "stopped").unwrap());
    assert!((1000..=1400).contains(&timeout["silent_ms"].as_i64().unwrap()), "{timeout}");
    let (until_timeout, in_all) = (timeout["flown_m"].as_f64().unwrap(), stopped["flown_m"].as_f64().unwrap());
    assert!((2.0..=9.5).contains(&until_timeout), "{timeout}");
    assert!(in_all > until_timeout && in_all < 25.0, "{stopped}");
    // Then the autopilot misses the node's heartbeat, and returns by itself.
    assert_eq!(named(&events, "failsafe").unwrap()["reason"], "GCS");
    println!("flown after the last setpoint: {until_timeout} m until the timeout, {in_all} m in all");
}
