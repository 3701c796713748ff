//! Event files, read back by a reader written from the format's description.

use std::fs;
use std::path::Path;

use covey_report::tensorboard::EventWriter;
use crc::{CRC_32_ISCSI, Crc};

#[derive(Debug, Default, PartialEq)]
struct Event {
    wall_time_s: f64,
    step: u64,
    file_version: Option<String>,
    session_status: Option<u64>,
    scalars: Vec<(String, f32)>,
}

/// The data of each TFRecord; panics when a CRC is wrong or bytes are left over.
fn records(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut take = |n: usize| {
        let (head, tail) = bytes.split_at_checked(n)?;
        bytes = tail;
        Some(head.to_vec())
    };
    let crc = |data: &[u8]| {
        let crc = Crc::<u32>::new(&CRC_32_ISCSI).checksum(data);
        crc.rotate_right(15).wrapping_add(0xa282_ead8).to_le_bytes().to_vec()
    };
    let mut records = Vec::new();
    while let Some(length) = take(8) {
        assert_eq!(take(4), Some(crc(&length)), "CRC of the length");
        let data = take(u64::from_le_bytes(length.try_into().unwrap()) as usize).expect("whole data");
        assert_eq!(take(4), Some(crc(&data)), "CRC of the data");
        records.push(data);
    }
    assert!(bytes.is_empty(), "{} bytes after the last record", bytes.len());
    records
}

/// Fields of a protobuf message: number and value (of varints and 64-bit fields the
/// value's bytes, little-endian).
fn fields(mut bytes: &[u8]) -> Vec<(u64, Vec<u8>)> {
    fn varint(bytes: &mut &[u8]) -> u64 {
        let mut value = 0;
        for shift in (0..).step_by(7) {
            let byte = bytes[0];
            *bytes = &bytes[1..];
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                break;
            }
        }
        value
    }
    let mut fields = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let length = match key & 7 {
            0 => {
                let value = varint(&mut bytes);
                fields.push((key >> 3, value.to_le_bytes().to_vec()));
                continue;
            }
            1 => 8,
            2 => varint(&mut bytes) as usize,
            5 => 4,
            other => panic!("wire type {other}"),
        };
        fields.push((key >> 3, bytes[..length].to_vec()));
        bytes = &bytes[length..];
    }
    fields
}

fn number(bytes: &[u8]) -> u64 {
    u64::from_le_bytes(bytes.try_into().unwrap())
}

fn events(path: &Path) -> Vec<Event> {
    let event = |data: Vec<u8>| {
        let mut event = Event::default();
        for (field, value) in fields(&data) {
            match field {
                1 => event.wall_time_s = f64::from_le_bytes(value.try_into().unwrap()),
                2 => event.step = number(&value),
                3 => event.file_version = Some(String::from_utf8(value).unwrap()),
                5 => {
                    for (_, point) in fields(&value) {
                        let point = fields(&point);
                        assert_eq!((point[0].0, point[1].0), (1, 2));
                        let tag = String::from_utf8(point[0].1.clone()).unwrap();
                        event.scalars.push((tag, f32::from_le_bytes(point[1].1.clone().try_into().unwrap())));
                    }
                }
                7 => event.session_status = Some(number(&fields(&value)[0].1)),
                other => panic!("field {other}"),
            }
        }
        event
    };
    records(&fs::read(path).unwrap()).into_iter().map(event).collect()
}

#[test]
fn scalars_come_back_with_step_time_and_value() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = EventWriter::create(folder.path().join("events"), 1e9).unwrap();
    let points = [
        ("episode/coverage", 0, 0.0, 0.2f32),
        ("episode/coverage", 127, 1e9 + 0.25, f32::NAN),
        ("update/loss, ü", 128, 1e9 + 0.5, -1e-9),
        ("x", u64::from(u32::MAX) * 5, 1e9 + 1.0, f32::INFINITY),
    ];
    for (tag, step, time, value) in points {
        writer.scalar(tag, step, time, value).unwrap();
    }
    writer.flush().unwrap();
    let events = events(writer.path());
    assert_eq!(events[0], Event { wall_time_s: 1e9, file_version: Some("brain.Event:2".into()), ..Event::default() });
    assert_eq!(events.len(), 1 + points.len());
    for (event, (tag, step, time, value)) in events[1..].iter().zip(points) {
        assert_eq!((event.step, event.wall_time_s), (step, time));
        assert_eq!(event.scalars.len(), 1);
        assert_eq!(event.scalars[0].0, tag);
        assert_eq!(event.scalars[0].1.to_bits(), value.to_bits());
    }
}

#[test]
fn a_resumed_run_adds_a_file_that_sorts_after_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut earlier = EventWriter::create(folder.path(), 1.0).unwrap();
    earlier.scalar("coverage", 10, 2.0, 0.3).unwrap();
    let earlier_path = earlier.path().to_owned();
    drop(earlier);
    let before = fs::read(&earlier_path).unwrap();
    fs::write(folder.path().join("notes.txt"), "not an event file").unwrap();

    let mut later = EventWriter::create(folder.path(), 3.0).unwrap();
    later.resumed_at(8, 3.0).unwrap();
    later.flush().unwrap();
    assert!(earlier_path.as_path() < later.path());
    assert_eq!(fs::read(&earlier_path).unwrap(), before);
    let events = events(later.path());
    assert_eq!((events[1].session_status, events[1].step), (Some(1), 8));
}

#[test]
fn a_file_in_the_place_of_the_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("events");
    fs::write(&path, "").unwrap();
    let error = EventWriter::create(&path, 0.0).unwrap_err();
    assert!(error.to_string().contains(&path.display().to_string()), "{error}");
}
