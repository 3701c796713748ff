//! Recordings as evidence: never written over, saying what was flown, decided again as they were flown, and named as what
//! they are when they are something else.

#[path = "../node/mission.rs"]
mod flown;
#[path = "../node/vehicle.rs"]
#[allow(dead_code)] // The tests of the node use all of it.
mod vehicle;

use super::{bridge, words};
use firmware_core::actor::Actor;
use firmware_core::gate::Limits;
use firmware_core::geometry::Vec2;
use flown::mission;
use sitl_bridge::autopilot::Firmware;
use sitl_bridge::frame::{Encoder, Frame, Source};
use sitl_bridge::mission::{Mission, PoiMap};
use sitl_bridge::node::{
    FeedForward, HostTime, Node, NodeOutput, OperatorCommand, Pace, Settings, StepTiming, gate_limits,
};
use sitl_bridge::replay::{RecordingInfo, Replay, ReplayCheck, ReplayReport};
use sitl_bridge::signing::{LinkSigning, Session};
use sitl_bridge::tlog::{Note, NoteReader, TlogReader, TlogWriter, flight_folder};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{self, BufRead as _, BufReader, Write};
use std::os::unix::ffi::OsStringExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{Arc, Mutex};
use vehicle::{TICK_MS, Vehicle};

const START_US: u64 = 1_790_000_000_000_000;
pub(super) const ACTOR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware-core/tests/data/sample-gcn.actor");
const ID: u16 = 3;

fn settings<'a>(actor: Actor<'a>, mission: &Mission, record: bool) -> Settings<'a> {
    Settings {
        id: ID,
        system: 4,
        vehicle_system: 7,
        actor,
        mission: Arc::new(mission.clone()),
        pois: Arc::new(PoiMap::new(&mission.pois)),
        timing: StepTiming::default(),
        limits: gate_limits(Limits::default(), mission),
        feed_forward: FeedForward::Ramp,
        take_off: true,
        wait_for: 1,
        strict: false,
        rate_hz: 5.0,
        source: Source::Datagrams,
        autopilot_signing: LinkSigning::off(),
        swarm_signing: LinkSigning::off(),
        record,
        advice: String::new(),
    }
}

#[derive(Clone, Default)]
struct Memory(Arc<Mutex<Vec<u8>>>);

impl Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A flight in real time that is recorded, as `fly` does it: answers come within microseconds, and turns of the node as
/// they fall.
struct Recorded {
    node: Node<'static>,
    vehicle: Vehicle,
    unix_us: u64,
    out: NodeOutput,
    tlog: TlogWriter,
    /// Added to each recorded time, as when the host's clock was set.
    set_us: i64,
    /// Times are cut to milliseconds, as some tools write them.
    coarse: bool,
    decisions: u64,
    autopilot: Encoder,
}

impl Recorded {
    fn new(memory: Memory, with_notes: bool) -> Self {
        let bytes: &'static [u8] = fs::read(ACTOR).unwrap().leak();
        let mission = mission();
        let mut settings = settings(Actor::load(bytes).unwrap(), &mission, true);
        if !with_notes {
            // As earlier versions flew.
            (settings.timing.pace, settings.timing.lead_ms) = (Pace::Deadlines, 0);
        }
        let mut tlog = TlogWriter::to(memory).unwrap();
        if with_notes {
            tlog.note(START_US, 4, &Note::Flight(settings.flight()));
            tlog.note(START_US, 4, &Note::Epoch(Some(mission.epoch_unix_ms)));
        }
        Self {
            node: Node::new(settings, Session::new()).unwrap(),
            vehicle: Vehicle::new(Firmware::ArduPilot, &mission, Vec2::from_u(100.0, 100.0)),
            unix_us: START_US,
            out: NodeOutput::default(),
            tlog,
            set_us: 0,
            coarse: false,
            decisions: 0,
            autopilot: Encoder::new(7, 1),
        }
    }

    fn now(&self) -> HostTime {
        HostTime { wall_ms: (self.unix_us - START_US) / 1000, unix_us: self.unix_us }
    }

    fn recorded_us(&self) -> u64 {
        let us = self.unix_us.saturating_add_signed(self.set_us);
        if self.coarse { us / 1000 * 1000 } else { us }
    }

    /// Records and sends; returns the commands that want an answer.
    fn flush(&mut self) -> Vec<u16> {
        let at = self.recorded_us();
        let mut commands = Vec::new();
        for frame in self.out.received.iter().chain(&self.out.to_swarm).chain(&self.out.to_autopilot) {
            self.tlog.record(at, frame);
        }
        for frame in std::mem::take(&mut self.out.to_autopilot) {
            self.vehicle.hear(&frame);
            if frame.message_id() == 76 {
                commands.push(u16::from_le_bytes([frame.payload()[28], frame.payload()[29]]));
            }
        }
        self.decisions += self.out.decisions.len() as u64;
        self.out.clear();
        commands
    }

    fn hear(&mut self, frame: &Frame) -> Vec<u16> {
        let now = self.now();
        self.node.receive_autopilot(frame.bytes(), now, &mut self.out);
        self.flush()
    }

    /// The end of a turn; commands are answered 60 µs later, and the next turn comes at once.
    fn turn(&mut self) {
        let now = self.now();
        self.node.tick(now, &mut self.out);
        let mut commands = self.flush();
        while let Some(command) = commands.pop() {
            self.unix_us += 60;
            let ack = self.autopilot.encode_payload(77, &[&command.to_le_bytes()[..], &[0]].concat()).unwrap();
            commands.extend(self.hear(&ack));
            self.unix_us += 5;
            let now = self.now();
            self.node.tick(now, &mut self.out);
            commands.extend(self.flush());
        }
    }

    fn pass(&mut self, us: u64) {
        let until = self.unix_us + us;
        while self.unix_us < until {
            self.unix_us += (until - self.unix_us).min(20_137);
            self.turn();
        }
    }

    /// A tick of the vehicle; `heard` says whether the link carries what it sends.
    fn tick(&mut self, heard: bool) {
        self.pass(u64::from(TICK_MS) * 1000 - 700);
        for frame in self.vehicle.tick() {
            if heard {
                self.unix_us += 7;
                self.hear(&frame);
            }
        }
        self.turn();
    }

    fn command(&mut self, command: OperatorCommand) {
        let at = self.recorded_us();
        self.tlog.note(at, 4, &Note::Command(command));
        self.node.command(command);
    }
}

fn replayed(bytes: &[u8]) -> ReplayReport {
    let actor = fs::read(ACTOR).unwrap();
    let mission = mission();
    let info = RecordingInfo::of(&mut TlogReader::new(bytes), None, None).unwrap();
    assert_eq!((info.id, info.system, info.took_off), (ID, 4, true));
    let node = Node::new(settings(Actor::load(&actor).unwrap(), &mission, false), Session::new()).unwrap();
    let mut replay = Replay::new(node, info, ReplayCheck::new(ID, mission.scale, FeedForward::Ramp));
    TlogReader::new(bytes).for_each(|record| replay.feed(&record.unwrap()));
    replay.finish()
}

fn flight(notes: bool, fly: impl FnOnce(&mut Recorded)) -> (Vec<u8>, u64) {
    let memory = Memory::default();
    let mut recorded = Recorded::new(memory.clone(), notes);
    fly(&mut recorded);
    let decisions = recorded.decisions;
    drop(recorded);
    let bytes = memory.0.lock().unwrap().clone();
    (bytes, decisions)
}

/// A recording of a flight with decisions, and the mission that it flew.
pub(super) fn a_flight() -> (Vec<u8>, String) {
    (flight(true, |f| (0..200).for_each(|_| f.tick(true))).0, mission().to_toml(""))
}

#[test]
fn the_replay_takes_its_turns_as_the_node_did() {
    for (what, coarse, set_us) in
        [("as it was", false, 0), ("times in ms", true, 0), ("clock set back", false, -40_000_000)]
    {
        let (bytes, decisions) = flight(true, |f| {
            f.coarse = coarse;
            (0..300).for_each(|_| f.tick(true));
            f.set_us = set_us;
            (0..100).for_each(|_| f.tick(true));
        });
        assert!(decisions > 20, "{what}: {decisions}");
        let report = replayed(&bytes);
        assert_eq!(report.differences, [], "{what}");
        assert_eq!((report.decisions, report.equal, report.other_setpoints), (decisions, decisions, 0), "{what}");
    }
}

#[test]
fn gaps_in_the_telemetry_are_replayed_too() {
    let (bytes, decisions) = flight(true, |f| {
        (0..250).for_each(|_| f.tick(true));
        for gap in [1, 2, 3, 5, 8, 13] {
            (0..gap).for_each(|_| f.tick(false));
            (0..40).for_each(|_| f.tick(true));
        }
        // A minute and more of silence at the end.
        (0..400).for_each(|_| f.tick(false));
        f.tick(true);
    });
    let report = replayed(&bytes);
    assert_eq!(report.differences, []);
    assert_eq!(report.decisions, decisions);
}

#[test]
fn commands_stand_in_the_recording_and_are_carried_out_again() {
    for command in [OperatorCommand::Return, OperatorCommand::Land, OperatorCommand::Release] {
        let fly = |f: &mut Recorded| {
            (0..300).for_each(|_| f.tick(true));
            f.command(command);
            (0..30).for_each(|_| f.tick(true));
            f.command(OperatorCommand::Start);
            (0..100).for_each(|_| f.tick(true));
        };
        let (bytes, decisions) = flight(true, fly);
        let report = replayed(&bytes);
        assert_eq!((&report.differences[..], report.decisions), (&[][..], decisions), "{command:?}");
        assert_eq!(report.other_setpoints, 0, "{command:?}");
    }
}

/// A recording in a file, and its mission beside it.
fn files(bytes: &[u8]) -> (tempfile::TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    // No name has to be UTF-8.
    let tlog = folder.path().join(OsString::from_vec(b"Fl\xFCg.tlog".to_vec()));
    let mission_file = folder.path().join(OsString::from_vec(b"\xE4.toml".to_vec()));
    fs::write(&tlog, bytes).unwrap();
    fs::write(&mission_file, mission().to_toml("")).unwrap();
    (folder, tlog, mission_file)
}

fn replay(tlog: &Path, mission: &Path, options: &[&str]) -> Output {
    let options: Vec<_> = options.iter().map(OsStr::new).collect();
    let args = [
        OsStr::new("replay"),
        tlog.as_os_str(),
        OsStr::new("--actor"),
        OsStr::new(ACTOR),
        OsStr::new("--mission"),
        mission.as_os_str(),
    ];
    bridge(&[&args[..], &options].concat())
}

#[test]
fn a_recording_names_its_mission_and_its_settings() {
    let (bytes, _) = flight(true, |f| (0..300).for_each(|_| f.tick(true)));
    let (folder, tlog, mission_file) = files(&bytes);
    let output = replay(&tlog, &mission_file, &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((told["mission_named"].as_bool(), told["equal_in_all"].as_bool()), (Some(true), Some(true)), "{told}");
    // Another mission is not mixed with it, unless that is asked for.
    let other = folder.path().join("other.toml");
    fs::write(&other, Mission { policy_seed: 11, ..mission() }.to_toml("")).unwrap();
    let output = replay(&tlog, &other, &[]);
    assert!(output.status.code() == Some(2) && words(&output).contains("--other-mission"), "{}", words(&output));
    let output = replay(&tlog, &other, &["--other-mission"]);
    assert!(output.status.code() != Some(2) && words(&output).contains("was flown, and"), "{}", words(&output));
    let later = folder.path().join("later.toml");
    fs::write(&later, Mission { epoch_unix_ms: 5, ..mission() }.to_toml("")).unwrap();
    let output = replay(&tlog, &later, &[]);
    assert!(
        output.status.code() == Some(2) && words(&output).contains("is it the mission that was flown?"),
        "{}",
        words(&output)
    );
    // Nor are other settings.
    let output = replay(&tlog, &mission_file, &["--ideal"]);
    assert!(output.status.code() == Some(2) && words(&output).contains("flown as flight"), "{}", words(&output));
    let output = replay(&tlog, &mission_file, &["--encode-ms", "300"]);
    assert!(output.status.code() == Some(2) && words(&output).contains("--encode-ms 400"), "{}", words(&output));
}

#[test]
fn recordings_of_earlier_versions_are_replayed_with_a_word() {
    let (bytes, _) = flight(false, |f| (0..300).for_each(|_| f.tick(true)));
    let (folder, tlog, mission_file) = files(&bytes);
    let output = replay(&tlog, &mission_file, &[]);
    assert!(
        output.status.code() == Some(0) && words(&output).contains("does not say which mission was flown"),
        "{}",
        words(&output)
    );
    let later = folder.path().join("later.toml");
    fs::write(&later, Mission { epoch_unix_ms: 0, ..mission() }.to_toml("")).unwrap();
    let output = replay(&tlog, &later, &[]);
    assert!(
        output.status.code() == Some(2) && words(&output).contains("counts its steps from another time"),
        "{}",
        words(&output)
    );
}

#[test]
fn what_is_no_tlog_is_named_as_what_it_is() {
    let (bytes, _) = flight(true, |f| (0..200).for_each(|_| f.tick(true)));
    let records: Vec<_> = TlogReader::new(&bytes[..]).map(Result::unwrap).collect();
    let timed = |time: &dyn Fn(u64) -> [u8; 8]| -> Vec<u8> {
        records.iter().flat_map(|r| [&time(r.unix_us)[..], r.frame.bytes()].concat()).collect()
    };
    let raw: Vec<u8> = records.iter().flat_map(|r| r.frame.bytes().to_vec()).collect();
    for (bytes, words_said) in [
        (raw.clone(), "a stream of MAVLink frames without times"),
        (raw[5..].to_vec(), "a stream of MAVLink frames without times"),
        (timed(&|_| [0; 8]), "they are all the same"),
        (timed(&|us| us.to_le_bytes()), "is the lowest byte first?"),
        ([&bytes[..], &bytes].concat(), "2 flights of the node are in it"),
        (b"\xA3\x95\x80\x80FMT".to_vec(), "a flight log of ArduPilot's own"),
        (b"ULog\x01\x12\x35".to_vec(), "a flight log of PX4's own"),
        (b"\x1f\x8b\x08".to_vec(), "gunzip"),
        (b"PK\x03\x04".to_vec(), "a ZIP archive"),
        (Vec::new(), "no MAVLink frame in its 0 bytes"),
    ] {
        let (_folder, tlog, mission_file) = files(&bytes);
        let output = replay(&tlog, &mission_file, &[]);
        assert_eq!(output.status.code(), Some(2), "{words_said}");
        assert!(words(&output).contains(words_said), "{}", words(&output));
    }
}

#[test]
fn a_recording_is_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let tlog = folder.path().join("a.tlog");
    fs::write(&tlog, "evidence").unwrap();
    assert_eq!(TlogWriter::create(&tlog).unwrap_err().kind(), io::ErrorKind::AlreadyExists);
    let mission_file = folder.path().join("m.toml");
    fs::write(&mission_file, mission().to_toml("")).unwrap();
    let args = ["fly", "--id", "3", "--autopilot", "udpin:127.0.0.1:0", "--mission"].map(OsStr::new);
    let output = bridge(&[&args[..], &[mission_file.as_os_str(), OsStr::new("--tlog"), tlog.as_os_str()]].concat());
    assert!(
        !output.status.success() && words(&output).contains("never written over: name another file"),
        "{}",
        words(&output)
    );
    assert_eq!(fs::read(&tlog).unwrap(), b"evidence");
    // What keeps nothing can be written to.
    assert!(TlogWriter::create(Path::new("/dev/null")).is_ok());
}

#[test]
fn each_flight_has_a_folder_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let tlogs = folder.path().join("new/logs");
    assert_eq!(flight_folder(&tlogs).unwrap(), tlogs);
    assert_eq!(flight_folder(&tlogs).unwrap(), tlogs, "nothing is in it");
    fs::write(tlogs.join("notes.txt"), "").unwrap();
    assert_eq!(flight_folder(&tlogs).unwrap(), tlogs);
    fs::write(tlogs.join("uav-0.tlog"), "").unwrap();
    assert_eq!(flight_folder(&tlogs).unwrap(), tlogs.join("flight-2"));
    assert_eq!(flight_folder(&tlogs).unwrap(), tlogs.join("flight-3"));
    let worlds = folder.path().join("worlds");
    fs::create_dir(&worlds).unwrap();
    fs::write(worlds.join("world-0.toml"), "").unwrap();
    assert_eq!(flight_folder(&worlds).unwrap(), worlds.join("flight-2"));
}

/// The program itself writes what was flown and what was typed.
#[test]
fn a_flight_records_its_settings_and_commands() {
    let folder = tempfile::tempdir().unwrap();
    let (tlog, mission_file) = (folder.path().join("a.tlog"), folder.path().join("m.toml"));
    fs::write(&mission_file, mission().to_toml("")).unwrap();
    let mut node = Command::new(env!("CARGO_BIN_EXE_sitl-bridge"))
        .args(["fly", "--id", "3", "--simulated", "--autopilot", "udpin:127.0.0.1:0", "--mission"])
        .arg(&mission_file)
        .arg("--tlog")
        .arg(&tlog)
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = node.stdin.take().unwrap();
    writeln!(stdin, "return").unwrap();
    let notes = || {
        let mut reader = NoteReader::default();
        let records =
            TlogReader::open(&tlog).map(|log| log.map_while(Result::ok).collect::<Vec<_>>()).unwrap_or_default();
        records.iter().filter(|r| Note::is_piece(&r.frame, 4)).filter_map(|r| reader.take(&r.frame)).collect::<Vec<_>>()
    };
    // It is on the disk while the program runs.
    while !notes().contains(&Note::Command(OperatorCommand::Return)) {
        assert!(node.try_wait().unwrap().is_none(), "it ended");
        std::thread::yield_now();
    }
    let pid = rustix::process::Pid::from_child(&node);
    rustix::process::kill_process(pid, rustix::process::Signal::TERM).unwrap();
    let said: Vec<_> = BufReader::new(node.stderr.take().unwrap()).lines().map_while(Result::ok).collect();
    assert!(node.wait().unwrap().success(), "{said:?}");
    let notes = notes();
    let Some(Note::Flight(flight)) = notes.first() else { panic!("{notes:?}") };
    let hash: String = mission().hash().iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(flight.get("mission"), Some(hash.as_str()));
    assert_eq!(
        (flight.get("limits"), flight.number("id"), flight.get("take_off")),
        (Some("simulation"), Some(ID), Some("0"))
    );
    let epoch = Note::Epoch(Some(mission().epoch_unix_ms));
    assert_eq!(notes[1..], [epoch, Note::Command(OperatorCommand::Return), Note::Command(OperatorCommand::Release)]);
}
