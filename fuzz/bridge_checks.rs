//! What must hold in the bridge whatever the bytes are. The fuzz targets run these on new inputs, the tests of
//! sitl-bridge on the corpus.

use sitl_bridge::connection::Address;
use sitl_bridge::frame::{Reader, Source};
use sitl_bridge::mission::{Draft, Given, Loaded};
use sitl_bridge::replay::{RecordingInfo, foreign};
use sitl_bridge::swarm_link::{SwarmAddress, neighbour_message};
use sitl_bridge::tlog::{NoteReader, TlogReader};
use std::path::Path;

/// A mission that is read can be written, and reads back as the same.
///
/// The first byte chooses the file's name, the rest is its content.
pub fn mission_file(data: &[u8]) {
    const NAMES: [&str; 8] = ["a.toml", "a.geojson", "a.kml", "a.csv", "a.plan", "a.waypoints", "a.json", "a"];
    let Some((name, content)) = data.split_first() else { return };
    let path = Path::new(NAMES[usize::from(*name) % NAMES.len()]);
    let Ok(mut draft) = Draft::from_bytes(content, path) else { return };
    if let Ok(loaded) = draft.clone().finish() {
        reads_back(&loaded);
    }
    draft.fill(&Given { alt_m: Some(400.0), simplify_fence: true, ..Given::default() });
    if let Ok(loaded) = draft.finish() {
        reads_back(&loaded);
    }
}

fn reads_back(loaded: &Loaded) {
    let text = loaded.mission.to_toml("fuzzed");
    let again = Loaded::from_bytes(text.as_bytes(), Path::new("a.toml")).expect("it can be flown");
    assert_eq!(again.mission, loaded.mission);
    assert_eq!(again.mission.hash(), loaded.mission.hash());
}

/// Records lie in the file as they are read; nothing in it stops the info.
pub fn tlog(data: &[u8]) {
    let mut reader = TlogReader::new(data);
    let (mut bytes, mut notes) = (0, NoteReader::default());
    for record in reader.by_ref() {
        let record = record.expect("memory can be read");
        let piece = [&record.unix_us.to_be_bytes()[..], record.frame.bytes()].concat();
        assert!(data.windows(piece.len()).any(|window| window == piece));
        bytes += piece.len() as u64;
        let _ = notes.take(&record.frame);
    }
    assert!(bytes + reader.skipped() <= data.len() as u64);
    assert!(reader.is_cut() || bytes + reader.skipped() == data.len() as u64);
    let _ = foreign(data);
    let _ = RecordingInfo::of(&mut TlogReader::new(data), None, None);
}

/// A string that names a link is written as one that does too.
pub fn connection_string(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(address) = text.parse::<Address>() {
        let written = address.to_string();
        assert!(written.parse::<Address>().is_ok(), "{text:?} becomes {written:?}");
    }
    let _ = text.parse::<SwarmAddress>();
}

/// Frames that are found lie in the bytes, and reading what is in them does no harm, from datagrams and from a stream.
pub fn mavlink_frames(data: &[u8]) {
    for source in [Source::Datagrams, Source::Stream] {
        let mut reader = Reader::new(source);
        for piece in data.chunks(300) {
            reader.push(piece);
            while let Some(frame) = reader.next_frame() {
                assert!(data.windows(frame.bytes().len()).any(|window| window == frame.bytes()));
                let _ = frame.message();
                let _ = neighbour_message(&frame);
            }
        }
    }
}
