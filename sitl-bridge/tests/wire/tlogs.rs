use super::frame;
use mavlink::dialects::common::{MavMessage, SETUP_SIGNING_DATA};
use proptest::prelude::*;
use sitl_bridge::frame::{Encoder, Frame};
use sitl_bridge::tlog::{Record, TlogReader, TlogWriter};
use std::io::{self, Write};
use std::sync::{Arc, Mutex};

const START_US: u64 = 1_790_000_000_000_000;

/// A disk with room for so many bytes.
#[derive(Clone)]
struct Disk(Arc<Mutex<(Vec<u8>, usize)>>);

impl Disk {
    fn new(room: usize) -> Self {
        Self(Arc::new(Mutex::new((Vec::new(), room))))
    }

    fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap().0.clone()
    }

    fn set_room(&self, room: usize) {
        self.0.lock().unwrap().1 = room;
    }
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let (written, room) = &mut *self.0.lock().unwrap();
        let len = bytes.len().min(room.saturating_sub(written.len()));
        if len == 0 {
            return Err(io::ErrorKind::StorageFull.into());
        }
        written.extend_from_slice(&bytes[..len]);
        Ok(len)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn records(count: u32) -> Vec<Record> {
    let record = |n: u32| Record { unix_us: START_US + u64::from(n) * 1000, frame: frame(n) };
    (0..count).map(record).collect()
}

fn write(records: &[Record]) -> Vec<u8> {
    let disk = Disk::new(usize::MAX);
    let mut writer = TlogWriter::to(disk.clone()).unwrap();
    for record in records {
        writer.record(record.unix_us, &record.frame);
    }
    drop(writer);
    disk.bytes()
}

fn read(bytes: &[u8]) -> (Vec<Record>, u64, bool) {
    let mut reader = TlogReader::new(bytes);
    let records = reader.by_ref().collect::<io::Result<Vec<_>>>().unwrap();
    (records, reader.skipped(), reader.is_cut())
}

#[test]
fn a_record_is_the_time_with_the_highest_byte_first_and_the_frame() {
    let written = write(&records(1));
    assert_eq!(written, [&START_US.to_be_bytes()[..], frame(0).bytes()].concat());
}

#[test]
fn what_is_recorded_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.tlog");
    let records = records(10_000);
    let mut writer = TlogWriter::create(&path).unwrap();
    for record in &records {
        writer.record(record.unix_us, &record.frame);
    }
    assert!(writer.take_error().is_none());
    drop(writer);
    let mut reader = TlogReader::open(&path).unwrap();
    assert_eq!(reader.by_ref().collect::<io::Result<Vec<_>>>().unwrap(), records);
    assert_eq!((reader.skipped(), reader.is_cut()), (0, false));
}

#[test]
fn a_file_that_cannot_be_made_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    assert!(TlogWriter::create(&folder.path().join("no-such-folder/flight.tlog")).is_err());
    assert!(TlogReader::open(&folder.path().join("none.tlog")).is_err());
}

/// At the latest a second of flight is lost in a crash.
#[test]
fn a_second_of_flight_is_handed_to_the_disk() {
    let disk = Disk::new(usize::MAX);
    let mut writer = TlogWriter::to(disk.clone()).unwrap();
    for n in 0..6 {
        writer.record(START_US + n * 200_000, &frame(1));
    }
    // By its own thread; the writer is still open.
    while read(&disk.bytes()).0.len() < 6 {
        std::thread::yield_now();
    }
    drop(writer);
}

#[test]
fn a_full_disk_loses_records_and_nothing_else() {
    let all = records(5000);
    let disk = Disk::new(40_000);
    let mut writer = TlogWriter::to(disk.clone()).unwrap();
    let (full, later) = all.split_at(4000);
    for record in full {
        writer.record(record.unix_us, &record.frame);
    }
    writer.flush();
    while writer.lost() == 0 {
        std::thread::yield_now();
    }
    assert_eq!(writer.take_error().unwrap().kind(), io::ErrorKind::StorageFull);
    // The disk has room again: what comes is recorded, and the record that was cut is whole.
    disk.set_room(usize::MAX);
    for record in later {
        writer.record(record.unix_us, &record.frame);
    }
    drop(writer);
    let (found, skipped, cut) = read(&disk.bytes());
    assert_eq!((skipped, cut), (0, false));
    assert!(found.len() > 1000 && found.ends_with(later), "{} records", found.len());
    assert!(found.iter().all(|record| all.contains(record)));
}

/// Keys are not written down.
#[test]
fn setup_signing_is_not_recorded() {
    let setup = Encoder::new(1, 1).encode(&MavMessage::SETUP_SIGNING(SETUP_SIGNING_DATA::default())).unwrap();
    let key = Record { unix_us: 1, frame: setup };
    let other = records(1)[0];
    assert_eq!(write(&[key, other, key]), write(&[other]));
}

#[test]
fn a_cut_end_is_noticed() {
    let all = records(3);
    let bytes = write(&all);
    let length = bytes.len() / 3;
    for len in 0..bytes.len() {
        let (found, skipped, cut) = read(&bytes[..len]);
        assert_eq!((found.as_slice(), skipped), (&all[..len / length], 0), "cut at {len}");
        assert_eq!(cut, len % length != 0, "cut at {len}");
    }
}

/// A message that this version does not know is kept.
#[test]
fn unknown_messages_are_read() {
    let mut bytes = write(&records(3));
    let length = bytes.len() / 3;
    // The id of the second one.
    bytes[length + 8 + 7..length + 8 + 10].copy_from_slice(&[0x60, 0xEA, 0]);
    let (found, skipped, cut) = read(&bytes);
    assert_eq!((found.len(), skipped, cut), (3, 0, false));
    assert!(!found[1].frame.is_checked() && found[2].frame.is_checked());
}

proptest! {
    #[test]
    fn damage_costs_only_what_it_hits(
        damaged in prop::collection::vec((0usize..20, any::<prop::sample::Index>(), 1u8..), 0..3),
        garbage in prop::collection::vec(prop_oneof![Just(0xFD), Just(0xFE), any::<u8>()], 0..400),
        place in 0usize..20,
    ) {
        let all = records(20);
        let mut pieces: Vec<_> = all.iter().map(|record| write(std::slice::from_ref(record))).collect();
        for (which, at, flip) in &damaged {
            // The frame, not its time: a wrong time cannot be noticed.
            let at = 8 + at.index(pieces[*which].len() - 8);
            pieces[*which][at] ^= flip;
        }
        pieces.insert(place, garbage);
        let (found, ..) = read(&pieces.concat());
        let found: Vec<Frame> = found.into_iter().map(|r| r.frame).filter(Frame::is_checked).collect();
        // One garbled frame in 65,536 fits its checksum by chance, and hides what it covers.
        prop_assume!(found.iter().all(|frame| all.iter().any(|record| record.frame == *frame)));
        let whole = all.iter().enumerate().filter(|(n, _)| damaged.iter().all(|(which, ..)| which != n));
        for (n, record) in whole {
            prop_assert!(found.contains(&record.frame), "record {n}");
        }
    }

    #[test]
    fn no_bytes_break_the_reader(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        read(&bytes);
    }
}
