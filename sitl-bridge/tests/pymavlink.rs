//! pymavlink, the MAVLink of most ground software, understands what the bridge sends, and the
//! bridge what pymavlink sends: signed and unsigned, on the air and in tlogs.

use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message as _};
use sitl_bridge::frame::{Encoder, Frame, Reader, Rejected, Source, Version, crc_extra};
use sitl_bridge::signing::{Key, LinkSigning, Session, Timestamp, Unsigned};
use sitl_bridge::tlog::{TlogReader, TlogWriter};
use std::collections::HashMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const NOW: Timestamp = Timestamp::from_unix_us(1_790_000_000_000_000);
const KEY: [u8; 32] = [0xAB; 32];

/// Runs the peer and returns what it prints.
fn peer(args: &[&str], input: &[u8]) -> Vec<u8> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = package.parent().expect("the workspace").join(".venv/bin/python");
    let mut command = Command::new(&python);
    command.arg(package.join("tests/pymavlink_peer.py")).args(args);
    let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = child
        .unwrap_or_else(|e| panic!("{}: {e}. `cargo xtask setup simlink` installs pymavlink there", python.display()));
    child.stdin.take().expect("a pipe").write_all(input).expect("the peer reads");
    let output = child.wait_with_output().expect("the peer ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// One object a line.
fn lines(printed: &[u8]) -> Vec<HashMap<String, String>> {
    let text = String::from_utf8(printed.to_vec()).expect("text");
    let value = |v: &serde_json::Value| v.as_str().map_or_else(|| v.to_string(), str::to_owned);
    let object = |line: &str| serde_json::from_str::<serde_json::Map<String, serde_json::Value>>(line).expect("JSON");
    text.lines().map(|line| object(line).iter().map(|(k, v)| (k.clone(), value(v))).collect()).collect()
}

fn key_args() -> [String; 4] {
    let key = KEY.iter().map(|b| format!("{b:02x}")).collect();
    ["--key".into(), key, "--timestamp".into(), NOW.ticks().to_string()]
}

fn with_key<'a>(action: &'a str, key: &'a [String; 4]) -> Vec<&'a str> {
    [action].into_iter().chain(key.iter().map(String::as_str)).collect()
}

fn link(key: [u8; 32]) -> LinkSigning {
    LinkSigning::new(Key::new(key), 3, Unsigned::Refuse)
}

fn frames(bytes: &[u8]) -> Vec<Frame> {
    let mut reader = Reader::new(Source::Stream);
    reader.push(bytes);
    let found = std::iter::from_fn(|| reader.next_frame()).collect();
    assert_eq!(reader.counts().total(), 0);
    found
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// The frame that we make of what we read in one: the same bytes, when we read all of it.
fn again(frame: &Frame) -> Option<Frame> {
    let mut encoder = Encoder::new(frame.system(), frame.component()).with_version(frame.version());
    let message = frame.message().ok()?;
    let mut made = encoder.encode(&message).expect("a frame");
    for _ in 0..frame.sequence() {
        made = encoder.encode(&message).expect("a frame");
    }
    Some(made)
}

#[test]
fn all_checksums_are_pymavlinks() {
    let theirs = &lines(&peer(&["checksums"], &[]))[0];
    assert!(theirs.len() > 250);
    for (id, extra) in theirs {
        assert_eq!(crc_extra(id.parse().unwrap()).map(|e| e.to_string()).as_ref(), Some(extra), "message {id}");
    }
}

#[test]
fn the_bridge_reads_what_pymavlink_sends() {
    for (args, version) in [(&["encode"][..], Version::V2), (&["encode", "--v1"], Version::V1)] {
        let found = frames(&peer(args, &[]));
        assert_eq!(found.len(), 21);
        for (frame, n) in found.iter().zip(0..) {
            assert_eq!((frame.system(), frame.component(), frame.sequence()), (42, 7, n));
            assert!(frame.version() == version && frame.is_checked() && !frame.is_signed());
            match again(frame) {
                Some(made) if version == Version::V2 => assert_eq!(hex(made.bytes()), hex(frame.bytes()), "{frame:?}"),
                // In MAVLink 1 pymavlink and we agree on the payload's length too.
                Some(made) => assert_eq!(made.payload(), frame.payload(), "{frame:?}"),
                None => assert_eq!(frame.message_id(), 193, "only EKF_STATUS_REPORT is not in the common set"),
            }
        }
    }
}

#[test]
fn the_bridge_believes_what_pymavlink_signs() {
    let key = key_args();
    let bytes = peer(&with_key("encode", &key), &[]);
    let found = frames(&bytes);
    assert_eq!(found.len(), 21);
    let mut session = Session::new();
    for frame in &found {
        assert_eq!(session.verify(&link([1; 32]), frame, NOW), Err(Rejected::WrongKey));
        assert_eq!(session.verify(&link(KEY), frame, NOW), Ok(()));
        assert_eq!(session.verify(&link(KEY), frame, NOW), Err(Rejected::Replayed));
    }
}

/// Frames with every message that both know, in MAVLink 1 with every one that it can carry.
fn ours(version: Version) -> Vec<Frame> {
    let theirs = &lines(&peer(&["checksums"], &[]))[0];
    let mut ids: Vec<u32> = theirs.keys().map(|id| id.parse().expect("a number")).collect();
    ids.retain(|&id| version == Version::V2 || id < 256);
    ids.sort_unstable();
    let mut encoder = Encoder::new(9, 191).with_version(version);
    let frame = |id: u32| {
        let message = MavMessage::default_message_from_id(id)?;
        let mut payload = [0; 255];
        let len = message.ser(MavlinkVersion::V1, &mut payload);
        // No byte is zero and each is different from its neighbours; small, so that most are in range.
        let full: Vec<u8> = (0..len).map(|i| 1 + ((i + id as usize) % 4) as u8).collect();
        let message = MavMessage::parse(MavlinkVersion::V2, id, &full).unwrap_or(message);
        Some(encoder.encode(&message).expect("a frame"))
    };
    let frames: Vec<_> = ids.into_iter().filter_map(frame).collect();
    assert!(frames.len() > 100, "{}", frames.len());
    frames
}

#[test]
fn pymavlink_reads_what_the_bridge_sends() {
    for version in [Version::V2, Version::V1] {
        let sent = ours(version);
        let bytes: Vec<u8> = sent.iter().flat_map(|f| f.bytes().to_vec()).collect();
        let read = lines(&peer(&["decode"], &bytes));
        let types: Vec<_> = read.iter().map(|m| m["type"].as_str()).collect();
        assert_eq!(read.len(), sent.len(), "{types:?}");
        for (message, frame) in read.iter().zip(&sent) {
            assert_ne!(message["type"], "BAD_DATA", "{message:?}");
            assert_eq!(message["system"], "9");
            assert_eq!(message["component"], "191");
            assert_eq!(message["sequence"], frame.sequence().to_string());
            if version == Version::V2 {
                assert_eq!(message["repacked"], hex(frame.bytes()), "{}", message["type"]);
            }
        }
    }
}

#[test]
fn pymavlink_believes_what_the_bridge_signs() {
    let (mut session, link_of_ours) = (Session::new(), link(KEY));
    let unsigned = ours(Version::V2);
    let signed: Vec<_> =
        unsigned.iter().map(|f| session.sign(&link_of_ours, *f, NOW).expect("a signed frame")).collect();
    let bytes = |frames: &[Frame]| frames.iter().flat_map(|f| f.bytes().to_vec()).collect::<Vec<u8>>();
    let key = key_args();
    let args = with_key("decode", &key);

    let read = lines(&peer(&args, &bytes(&signed)));
    assert_eq!(read.len(), signed.len());
    for (message, frame) in read.iter().zip(&unsigned) {
        assert_eq!((message["signed"].as_str(), &message["repacked"]), ("true", &hex(frame.bytes())));
    }
    // It refuses what we refuse: no signature, another key, a replay.
    let mut wrong = Session::new();
    let forged = wrong.sign(&link([1; 32]), unsigned[0], NOW).expect("a signed frame");
    for refused in [&[unsigned[0]][..], &[forged]] {
        let read = lines(&peer(&args, &bytes(refused)));
        assert!(read.iter().all(|m| m["type"] == "BAD_DATA"), "{read:?}");
    }
    let twice = lines(&peer(&args, &bytes(&[signed[0], signed[0], signed[1]])));
    assert_eq!(twice.iter().filter(|m| m["type"] != "BAD_DATA").count(), 2, "{twice:?}");
}

/// In a folder of its own.
fn tlog_file() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("flight.tlog");
    (folder, path)
}

#[test]
fn pymavlink_reads_our_tlogs() {
    let (_folder, path) = tlog_file();
    let mut sent = ours(Version::V2);
    let mut writer = TlogWriter::create(&path).expect("a file");
    for (frame, n) in sent.iter().zip(0..) {
        writer.record(1_790_000_000_000_000 + n * 1000, frame);
    }
    drop(writer);
    // The message with the key is not recorded.
    let setup_signing = sent.iter().position(|f| f.message_id() == 256).expect("a message");
    sent.remove(setup_signing);
    let read = lines(&peer(&["read-tlog", "--file", path.to_str().expect("a name")], &[]));
    let types: Vec<_> = read.iter().map(|m| m["type"].as_str()).collect();
    assert_eq!(read.len(), sent.len(), "{types:?}");
    assert!(!types.contains(&"BAD_DATA"));
    let times = (0u64..).filter(|&n| n != setup_signing as u64).map(|n| 1_790_000_000_000_000 + n * 1000);
    assert!(read.iter().zip(times).all(|(m, us)| m["us"] == us.to_string()));
}

#[test]
fn we_read_pymavlinks_tlogs() {
    let (_folder, path) = tlog_file();
    peer(&["write-tlog", "--file", path.to_str().expect("a name")], &[]);
    let mut reader = TlogReader::open(&path).expect("a file");
    let records: Vec<_> = reader.by_ref().map(|r| r.expect("a record")).collect();
    assert_eq!((records.len(), reader.skipped(), reader.is_cut()), (21, 0, false));
    for (record, n) in records.iter().zip(0u8..) {
        assert_eq!((record.unix_us, record.frame.sequence()), (1_790_000_000_000_000 + u64::from(n) * 1000, n));
    }
    let bytes = std::fs::read(&path).expect("a file");
    assert_eq!(records.iter().map(|r| 8 + r.frame.bytes().len()).sum::<usize>(), bytes.len());
}
