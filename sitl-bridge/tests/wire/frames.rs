use super::{frame, position, read};
use mavlink::Message as _;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavAutopilot, MavMessage, MavState, MavType, SETUP_SIGNING_DATA};
use proptest::prelude::*;
use sitl_bridge::frame::{EncodeError, Encoder, Frame, Reader, Rejected, Source, Version, crc_extra};

/// Names and counts of what a reader rejected.
fn rejected(reader: &Reader) -> Vec<(&'static str, u64)> {
    reader.counts().iter().map(|(reason, count)| (reason.name(), count)).collect()
}

#[test]
fn every_message_of_the_common_set_comes_back() {
    for version in [Version::V1, Version::V2] {
        let mut encoder = Encoder::new(7, 9).with_version(version);
        let ids = (0..20_000).filter(|&id| version == Version::V2 || id < 256);
        let messages: Vec<_> = ids.filter_map(MavMessage::default_message_from_id).collect();
        assert!(messages.len() > 100);
        for (n, message) in messages.iter().enumerate() {
            let sent = encoder.encode(message).unwrap();
            let (frames, reader) = read(sent.bytes());
            assert_eq!((frames.len(), rejected(&reader)), (1, vec![]), "{}", message.message_name());
            let got = &frames[0];
            assert_eq!((got, got.message_id(), got.version()), (&sent, message.message_id(), version));
            assert_eq!((got.system(), got.component(), usize::from(got.sequence())), (7, 9, n % 256));
            assert!(got.is_checked() && !got.is_signed() && got.signature().is_none());
            assert_eq!(&got.message().unwrap(), message);
        }
    }
}

/// Bytes of a real HEARTBEAT by pymavlink, in both versions.
#[test]
fn frames_are_those_of_other_implementations() {
    let heartbeat = MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 4,
        mavtype: MavType::MAV_TYPE_QUADROTOR,
        autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode: mavlink::dialects::common::MavModeFlag::from_bits_retain(217),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    });
    let mut encoder = Encoder::new(3, 1);
    assert_eq!(hex(&encoder.encode(&heartbeat).unwrap()), "fd090000000301000000040000000203d9040399f6");
    let mut encoder = Encoder::new(3, 1).with_version(Version::V1);
    assert_eq!(hex(&encoder.encode(&heartbeat).unwrap()), "fe0900030100040000000203d904030dae");
}

fn hex(frame: &Frame) -> String {
    frame.bytes().iter().map(|b| format!("{b:02x}")).collect()
}

#[test]
fn sequence_numbers_wrap_around() {
    let mut encoder = Encoder::new(1, 1);
    let sequences: Vec<_> = (0..300).map(|t| encoder.encode(&position(t)).unwrap().sequence()).collect();
    assert!(sequences.iter().zip(0..).all(|(&s, n): (&u8, u32)| u32::from(s) == n % 256));
}

#[test]
fn zeros_at_the_end_are_left_out_and_read_back() {
    let message = MavMessage::default_message_from_id(33).unwrap();
    let sent = Encoder::new(1, 1).encode(&message).unwrap();
    assert_eq!(sent.payload(), [0]);
    assert_eq!(read(sent.bytes()).0[0].message().unwrap(), message);
    // MAVLink 1 leaves out nothing.
    let sent = Encoder::new(1, 1).with_version(Version::V1).encode(&message).unwrap();
    assert_eq!(sent.payload(), [0; 28]);
}

/// A cut id would send the key as a heartbeat.
#[test]
fn setup_signing_needs_mavlink_2() {
    let message = MavMessage::SETUP_SIGNING(SETUP_SIGNING_DATA::default());
    let mut encoder = Encoder::new(1, 1).with_version(Version::V1);
    assert_eq!(encoder.encode(&message), Err(EncodeError::NeedsVersion2(256)));
    assert!(Encoder::new(1, 1).encode(&message).is_ok());
}

#[test]
fn a_payload_that_is_too_long_or_of_an_unknown_message_is_refused() {
    let mut encoder = Encoder::new(1, 1);
    assert_eq!(encoder.encode_payload(248, &[1; 256]), Err(EncodeError::TooLong(256)));
    assert_eq!(encoder.encode_payload(60_000, &[1]), Err(EncodeError::UnknownMessage(60_000)));
    assert_eq!(encoder.encode_payload(248, &[]).map(|f| f.payload().len()), Ok(0));
    assert_eq!(encoder.encode_payload(248, &[1; 255]).map(|f| f.payload().len()), Ok(255));
}

/// Only the message with the value is unreadable, and its bytes are there.
#[test]
fn a_value_of_another_dialect_is_an_error_of_that_message() {
    // Vehicle type 250, autopilot 3, mode 81, state 4.
    let payload = [4, 0, 0, 0, 250, 3, 81, 4, 3];
    let sent = Encoder::new(1, 1).encode_payload(0, &payload).unwrap();
    assert!(sent.message().is_err());
    assert_eq!(sent.payload(), payload);
}

#[test]
fn a_key_in_a_frame_is_not_printed() {
    let message = SETUP_SIGNING_DATA { secret_key: [0xA7; 32], ..SETUP_SIGNING_DATA::default() };
    let sent = Encoder::new(1, 1).encode(&MavMessage::SETUP_SIGNING(message)).unwrap();
    let printed = format!("{sent:?} {sent:#?}").to_lowercase();
    assert!(printed.contains("256") && !printed.contains("a7") && !printed.contains("167"), "{printed}");
}

#[test]
fn each_way_to_be_no_frame_is_counted() {
    let good = frame(5);
    let bytes = good.bytes();
    let mut flipped = bytes.to_vec();
    flipped[12] ^= 0x10;
    let mut flags = bytes.to_vec();
    flags[2] = 2;
    let unknown = {
        let mut b = bytes.to_vec();
        b[7..10].copy_from_slice(&[0x60, 0xEA, 0]);
        b
    };
    for (datagram, expected) in [
        (&b"hello"[..], vec![("garbage", 1)]),
        (&bytes[..20], vec![("truncated", 1)]),
        (&bytes[..1], vec![("truncated", 1)]),
        (&flipped, vec![("bad_checksum", 1)]),
        (&flags, vec![("unknown_flags", 1), ("garbage", 1)]),
        (&unknown, vec![]),
        (&[], vec![]),
    ] {
        let (frames, mut reader) = read(datagram);
        let mut expected = expected;
        expected.sort_by_key(|&(name, _)| Rejected::ALL.iter().position(|r| r.name() == name));
        assert_eq!(rejected(&reader), expected);
        assert!(frames.iter().all(|f| !f.is_checked()));
        // And the next datagram is read as if nothing had been.
        reader.push(bytes);
        assert_eq!(reader.next_frame(), Some(good));
    }
}

#[test]
fn names_of_reasons_are_different_snake_case() {
    let mut names: Vec<_> = Rejected::ALL.iter().map(|r| r.name()).collect();
    assert!(names.iter().all(|n| n.bytes().all(|b| b.is_ascii_lowercase() || b == b'_')));
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), Rejected::ALL.len());
}

/// Whatever a flipped bit hits, the frame behind is read: in the same datagram and in a stream.
#[test]
fn no_flipped_bit_costs_the_next_frame() {
    let (first, second) = (frame(1), frame(2));
    for bit in 0..first.bytes().len() * 8 {
        let mut bytes = [first.bytes(), second.bytes()].concat();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let checked: Vec<_> = read(&bytes).0.into_iter().filter(Frame::is_checked).collect();
        assert_eq!(checked, [second], "bit {bit}");
        // A stream must go on for a while: the flipped length may ask for more bytes.
        let mut reader = Reader::new(Source::Stream);
        reader.push(&bytes);
        reader.push(&[0; 300]);
        let checked: Vec<_> = std::iter::from_fn(|| reader.next_frame()).filter(Frame::is_checked).collect();
        assert_eq!(checked, [second], "bit {bit} in a stream");
    }
}

/// A header of a message nobody knows, whose length covers a valid frame, swallows nothing.
#[test]
fn a_fake_header_swallows_nothing() {
    let good = frame(3);
    for fake in [&[0xFD, 200, 0, 0, 1, 1, 1, 0x60, 0xEA, 0][..], &[0xFE, 250, 1, 1, 1, 3], &[0xFD; 12], &[0xFD, 9, 1]] {
        let bytes = [fake, good.bytes(), &[0; 300]].concat();
        let checked: Vec<_> = read(&bytes).0.into_iter().filter(Frame::is_checked).collect();
        assert_eq!(checked, [good]);
    }
}

/// What arrives: frames and what can happen to them.
#[derive(Clone, Debug)]
enum Piece {
    Frame(Frame),
    Garbage(Vec<u8>),
    Cut(Frame, usize),
    Flipped(Frame, usize),
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let ids = prop::sample::select((0..400).filter(|&id| crc_extra(id).is_some()).collect::<Vec<u32>>());
    // Payloads full of magic bytes are the hard ones.
    let byte = prop_oneof![Just(0xFD), Just(0xFE), Just(0), Just(1), any::<u8>()];
    let payload = prop::collection::vec(byte, 0..=255);
    (any::<u8>(), any::<u8>(), ids, payload, any::<bool>()).prop_map(|(system, component, id, payload, old)| {
        let version = if old && id < 256 { Version::V1 } else { Version::V2 };
        Encoder::new(system, component).with_version(version).encode_payload(id, &payload).unwrap()
    })
}

fn any_piece() -> impl Strategy<Value = Piece> {
    // Headers of real and of unknown messages with any length, whose frames never come.
    let header = (any::<u8>(), 0u8..=1, any::<[u8; 4]>())
        .prop_map(|(len, flags, [a, b, c, d])| vec![0xFD, len, flags, a, b, c, d % 250, 0, 0]);
    let byte = prop_oneof![Just(0xFD), Just(0xFE), Just(0), any::<u8>()];
    prop_oneof![
        4 => any_frame().prop_map(Piece::Frame),
        1 => prop::collection::vec(byte, 1..60).prop_map(Piece::Garbage),
        1 => header.prop_map(Piece::Garbage),
        1 => (any_frame(), any::<prop::sample::Index>()).prop_map(|(f, at)| Piece::Cut(f, at.index(f.bytes().len()))),
        1 => (any_frame(), any::<prop::sample::Index>()).prop_map(|(f, at)| Piece::Flipped(f, at.index(f.bytes().len() * 8))),
    ]
}

fn lay_out(pieces: &[Piece]) -> (Vec<u8>, Vec<Frame>) {
    let (mut bytes, mut valid) = (Vec::new(), Vec::new());
    for piece in pieces {
        match piece {
            Piece::Frame(frame) => {
                bytes.extend_from_slice(frame.bytes());
                valid.push(*frame);
            }
            Piece::Garbage(garbage) => bytes.extend_from_slice(garbage),
            Piece::Cut(frame, len) => bytes.extend_from_slice(&frame.bytes()[..*len]),
            Piece::Flipped(frame, bit) => {
                let at = bytes.len() + bit / 8;
                bytes.extend_from_slice(frame.bytes());
                bytes[at] ^= 1 << (bit % 8);
            }
        }
    }
    (bytes, valid)
}

proptest! {
    #[test]
    fn every_valid_frame_of_a_datagram_is_found(pieces in prop::collection::vec(any_piece(), 0..12)) {
        let (bytes, valid) = lay_out(&pieces);
        let found: Vec<_> = read(&bytes).0.into_iter().filter(Frame::is_checked).collect();
        // One of 65,536 wrong checksums fits by accident.
        prop_assume!(found.iter().all(|f| valid.contains(f)));
        prop_assert_eq!(found, valid);
    }

    #[test]
    fn every_valid_frame_of_a_stream_is_found_however_it_is_cut(
        pieces in prop::collection::vec(any_piece(), 0..12),
        cuts in prop::collection::vec(1usize..200, 1..20),
    ) {
        let (mut bytes, valid) = lay_out(&pieces);
        bytes.extend([0; 300]);
        let mut reader = Reader::new(Source::Stream);
        let (mut found, mut rest) = (Vec::new(), &bytes[..]);
        for &cut in cuts.iter().cycle() {
            let (now, later) = rest.split_at(cut.min(rest.len()));
            reader.push(now);
            found.extend(std::iter::from_fn(|| reader.next_frame()).filter(Frame::is_checked));
            rest = later;
            if rest.is_empty() {
                break;
            }
        }
        // One of 65,536 wrong checksums fits by accident.
        prop_assume!(found.iter().all(|f| valid.contains(f)));
        prop_assert_eq!(found, valid);
    }

    #[test]
    fn no_bytes_break_the_reader(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        for frame in read(&bytes).0 {
            let _ = (frame.message(), frame.signature(), frame.payload(), format!("{frame:?}"));
        }
    }
}
