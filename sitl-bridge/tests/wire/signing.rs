use super::{frame, position, read};
use mavlink::dialects::common::{MavMessage, RADIO_STATUS_DATA};
use proptest::prelude::*;
use sitl_bridge::frame::{Encoder, Frame, Rejected, Version};
use sitl_bridge::signing::{Key, LinkSigning, Session, SigningError, Timestamp, Unsigned};
use std::time::Duration;

const NOW: Timestamp = Timestamp::from_unix_us(1_790_000_000_000_000);

fn at(seconds: i64) -> Timestamp {
    let span = Duration::from_secs(seconds.unsigned_abs());
    if seconds < 0 { NOW.before(span) } else { NOW.after(span) }
}

fn link(key: u8, link_id: u8) -> LinkSigning {
    LinkSigning::new(Key::new([key; 32]), link_id, Unsigned::Refuse)
}

/// A frame signed by a sender with a fresh session.
fn signed(link: &LinkSigning, now: Timestamp) -> Frame {
    Session::new().sign(link, frame(1), now).expect("a signed frame")
}

#[test]
fn a_signed_frame_is_a_sound_frame_that_the_same_key_believes() {
    let sealed = signed(&link(1, 5), NOW);
    let (frames, reader) = read(sealed.bytes());
    assert_eq!((frames.as_slice(), reader.counts().total()), (&[sealed][..], 0));
    assert!(sealed.is_signed() && sealed.bytes().len() == frame(1).bytes().len() + 13);
    assert_eq!(sealed.message().unwrap(), position(1));
    let signature = sealed.signature().unwrap();
    assert_eq!((signature.link_id, signature.timestamp), (5, NOW));
    assert_eq!(Session::new().verify(&link(1, 0), &sealed, NOW), Ok(()));
}

#[test]
fn unsigned_frames_and_wrong_keys_are_refused() {
    let mut session = Session::new();
    let ours = link(1, 0);
    assert_eq!(session.verify(&ours, &frame(1), NOW), Err(Rejected::Unsigned));
    assert_eq!(session.verify(&ours, &signed(&link(2, 0), NOW), NOW), Err(Rejected::WrongKey));
    // Telemetry radios have no key.
    let radio = MavMessage::RADIO_STATUS(RADIO_STATUS_DATA::default());
    let radio = Encoder::new(51, 68).encode(&radio).unwrap();
    assert_eq!(session.verify(&ours, &radio, NOW), Ok(()));
    // Whoever takes unsigned frames takes no wrong signature.
    let lenient = LinkSigning::new(Key::new([1; 32]), 0, Unsigned::Accept);
    assert_eq!(session.verify(&lenient, &frame(1), NOW), Ok(()));
    assert_eq!(session.verify(&lenient, &signed(&link(2, 0), NOW), NOW), Err(Rejected::WrongKey));
    // Without a key nothing can be refused.
    assert_eq!(session.verify(&LinkSigning::off(), &signed(&link(2, 0), NOW), NOW), Ok(()));
}

/// Neither a checksum nor anything else vouches for it; with a signature that does not matter.
#[test]
fn an_unknown_message_is_believed_only_when_signed() {
    let unknown = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        bytes[7..10].copy_from_slice(&[0x60, 0xEA, 0]);
        read(&bytes).0[0]
    };
    let lenient = LinkSigning::new(Key::new([1; 32]), 0, Unsigned::Accept);
    let plain = unknown(frame(1).bytes());
    assert!(!plain.is_checked());
    for link in [LinkSigning::off(), lenient.clone()] {
        assert_eq!(Session::new().verify(&link, &plain, NOW), Err(Rejected::UnknownMessage));
    }
    assert_eq!(Session::new().verify(&link(1, 0), &plain, NOW), Err(Rejected::Unsigned));
    let signature_of_another = unknown(signed(&lenient, NOW).bytes());
    assert_eq!(Session::new().verify(&lenient, &signature_of_another, NOW), Err(Rejected::WrongKey));
    // Made by somebody who knows this message: one byte of payload, signed with our key at NOW.
    let genuine = [
        0xFD, 1, 1, 0, 0, 1, 1, 0x60, 0xEA, 0, 7, 0x12, 0x34, 0, 0x00, 0x70, 0x3d, 0x18, 0xa5, 0x21, 0x37, 0xd1, 0x89,
        0x99, 0x67, 0x4d,
    ];
    let genuine = read(&genuine).0[0];
    assert!(!genuine.is_checked());
    assert_eq!(Session::new().verify(&lenient, &genuine, NOW), Ok(()));
}

#[test]
fn a_flipped_bit_anywhere_is_refused() {
    let sealed = signed(&link(1, 0), NOW);
    for bit in 0..sealed.bytes().len() * 8 {
        let mut bytes = sealed.bytes().to_vec();
        bytes[bit / 8] ^= 1 << (bit % 8);
        for found in read(&bytes).0 {
            assert!(Session::new().verify(&link(1, 0), &found, NOW).is_err(), "bit {bit}");
        }
    }
}

#[test]
fn a_replayed_frame_is_refused_on_every_link_of_the_node() {
    let (autopilot, swarm) = (link(1, 0), link(1, 1));
    let (first, second) = {
        let mut sender = Session::new();
        (sender.sign(&link(1, 7), frame(1), NOW).unwrap(), sender.sign(&link(1, 7), frame(2), NOW).unwrap())
    };
    let mut session = Session::new();
    assert_eq!(session.verify(&autopilot, &first, NOW), Ok(()));
    assert_eq!(session.verify(&autopilot, &first, NOW), Err(Rejected::Replayed));
    assert_eq!(session.verify(&swarm, &first, NOW), Err(Rejected::Replayed));
    assert_eq!(session.verify(&swarm, &second, at(1)), Ok(()));
    // Overtaken by a newer one: refused too, on either link, however much later.
    for seconds in [1, 100, 1_000_000] {
        assert_eq!(session.verify(&autopilot, &first, at(seconds)), Err(Rejected::Replayed));
        assert_eq!(session.verify(&swarm, &second, at(seconds)), Err(Rejected::Replayed));
    }
}

/// A key that all share is no reason to believe an echo: whoever sends our own frames back to us
/// must not be taken for an autopilot.
#[test]
fn our_own_frames_are_refused_on_every_link() {
    let (autopilot, swarm) = (link(1, 0), link(1, 1));
    let mut session = Session::new();
    let own: Vec<_> = [&autopilot, &swarm, &autopilot].map(|l| session.sign(l, frame(1), NOW).unwrap()).into();
    for frame in &own {
        assert_eq!(session.verify(&autopilot, frame, NOW), Err(Rejected::Replayed));
        assert_eq!(session.verify(&swarm, frame, NOW), Err(Rejected::Replayed));
    }
}

/// The link id is part of what is signed: a recording cannot be moved to another stream.
#[test]
fn streams_are_kept_apart_by_system_component_and_link() {
    let mut session = Session::new();
    let ours = link(1, 0);
    for (system, component, link_id) in [(1, 1, 0), (2, 1, 0), (1, 2, 0), (1, 1, 1)] {
        let frame = Encoder::new(system, component).encode(&position(1)).unwrap();
        let sealed = Session::new().sign(&link(1, link_id), frame, NOW).unwrap();
        assert_eq!(session.verify(&ours, &sealed, NOW), Ok(()));
        assert_eq!(session.verify(&ours, &sealed, NOW), Err(Rejected::Replayed));
        let mut moved = sealed.bytes().to_vec();
        let link_byte = moved.len() - 13;
        moved[link_byte] ^= 0x40;
        assert_eq!(session.verify(&ours, &read(&moved).0[0], NOW), Err(Rejected::WrongKey));
    }
}

#[test]
fn the_first_frame_of_a_stream_may_be_a_minute_old() {
    let ours = link(1, 0);
    for (age, expected) in [(0, Ok(())), (60, Ok(())), (61, Err(Rejected::OldTimestamp)), (-3600, Ok(()))] {
        assert_eq!(Session::new().verify(&ours, &signed(&ours, at(-age)), NOW), expected, "{age} s");
    }
    // A known stream may lag as it likes, as long as it goes on.
    let mut session = Session::new();
    let mut sender = Session::new();
    for seconds in 0..10 {
        let sealed = sender.sign(&ours, frame(1), at(0)).unwrap();
        assert_eq!(session.verify(&ours, &sealed, at(1000 * seconds)), Ok(()));
    }
}

/// A refused frame leaves no trace: nobody without the key moves our time or a stream.
#[test]
fn a_forger_moves_nothing() {
    let ours = link(1, 0);
    let mut session = Session::new();
    let forged = signed(&link(2, 0), at(1_000_000));
    assert_eq!(session.verify(&ours, &forged, NOW), Err(Rejected::WrongKey));
    assert_eq!(session.verify(&ours, &signed(&ours, NOW), NOW), Ok(()));
    assert_eq!(session.sign(&ours, frame(1), NOW).unwrap().signature().unwrap().timestamp, NOW);
}

#[test]
fn timestamps_advance_with_a_clock_that_stands_still_or_jumps_back() {
    let ours = link(1, 0);
    let (mut sender, mut receiver) = (Session::new(), Session::new());
    let mut last = Timestamp::default();
    let mut told = [at(0), at(0), at(0), at(10), at(-100_000), at(-100_000), at(-99_940), Timestamp::default(), at(5)];
    for now in &mut told {
        let sealed = sender.sign(&ours, frame(1), *now).unwrap();
        let timestamp = sealed.signature().unwrap().timestamp;
        assert!(timestamp > last);
        assert_eq!(receiver.verify(&ours, &sealed, NOW), Ok(()));
        last = timestamp;
    }
}

/// After a jump back of the clock time still passes, so a receiver that has just started
/// believes the sender an hour later.
#[test]
fn a_sender_whose_clock_jumped_back_does_not_go_stale() {
    let ours = link(1, 0);
    let mut sender = Session::new();
    sender.sign(&ours, frame(1), at(0)).unwrap();
    sender.sign(&ours, frame(1), at(-7200)).unwrap();
    // The sender's clock is two hours behind from now on; an hour passes.
    let sealed = sender.sign(&ours, frame(1), at(-7200 + 3600)).unwrap();
    assert_eq!(Session::new().verify(&ours, &sealed, at(3600)), Ok(()));
}

#[test]
fn an_idle_sender_does_not_go_stale() {
    let ours = link(1, 0);
    let mut sender = Session::new();
    sender.sign(&ours, frame(1), at(0)).unwrap();
    let sealed = sender.sign(&ours, frame(1), at(3600)).unwrap();
    assert_eq!(Session::new().verify(&ours, &sealed, at(3600)), Ok(()));
}

/// A companion computer without a battery clock starts in 1970. It learns the time from the
/// first signed frame it hears, and is believed from then on.
#[test]
fn a_sender_without_a_clock_learns_the_time_from_others() {
    let ours = link(1, 0);
    let unset = Timestamp::from_unix_us(0);
    let mut companion = Session::new();
    let early = companion.sign(&ours, frame(1), unset).unwrap();
    assert_eq!(Session::new().verify(&ours, &early, NOW), Err(Rejected::OldTimestamp));
    assert_eq!(companion.verify(&ours, &signed(&ours, NOW), unset), Ok(()));
    let learned = companion.sign(&ours, frame(1), unset.after(Duration::from_secs(3600))).unwrap();
    assert_eq!(Session::new().verify(&ours, &learned, at(3600)), Ok(()));
}

/// One sender's clock that is years ahead does not carry everybody's timestamps with it.
#[test]
fn a_sender_from_the_far_future_moves_nobody() {
    let ours = link(1, 0);
    let mut session = Session::new();
    assert_eq!(session.verify(&ours, &signed(&ours, at(10 * 365 * 86_400)), NOW), Ok(()));
    assert_eq!(session.sign(&ours, frame(1), NOW).unwrap().signature().unwrap().timestamp, NOW);
    // Hours ahead are followed, or that sender would refuse our frames.
    let ahead = Encoder::new(2, 1).encode(&position(1)).unwrap();
    let ahead = Session::new().sign(&ours, ahead, at(3600)).unwrap();
    assert_eq!(session.verify(&ours, &ahead, NOW), Ok(()));
    assert!(session.sign(&ours, frame(1), NOW).unwrap().signature().unwrap().timestamp >= at(3600));
}

#[test]
fn mavlink_1_cannot_be_signed_and_nothing_is_signed_twice() {
    let ours = link(1, 0);
    let mut session = Session::new();
    let old = Encoder::new(1, 1).with_version(Version::V1).encode(&position(1)).unwrap();
    assert!(matches!(session.sign(&ours, old, NOW), Err(SigningError::NeedsVersion2)));
    assert_eq!(session.verify(&ours, &old, NOW), Err(Rejected::Unsigned));
    let once = session.sign(&ours, frame(1), NOW).unwrap();
    assert!(matches!(session.sign(&ours, once, NOW), Err(SigningError::AlreadySigned)));
    assert_eq!(session.sign(&LinkSigning::off(), old, NOW).unwrap(), old);
}

#[test]
fn timestamps_are_units_of_10_us_since_2015() {
    assert_eq!(Timestamp::from_unix_us(1_420_070_400_000_000).ticks(), 0);
    assert_eq!(Timestamp::from_unix_us(1_420_070_400_000_000 + 25).ticks(), 2);
    assert_eq!(Timestamp::from_unix_us(0).ticks(), 0);
    assert_eq!(Timestamp::from_unix_us(u64::MAX).ticks(), (1 << 48) - 1);
    assert_eq!(Timestamp::from_ticks(u64::MAX).next().ticks(), (1 << 48) - 1);
    assert!(Timestamp::now() > Timestamp::from_unix_us(1_700_000_000_000_000));
    assert_eq!(at(10).since(at(4)), Duration::from_secs(6));
    assert_eq!(at(4).since(at(10)), Duration::ZERO);
}

proptest! {
    /// Whatever a sender's clock does and whomever it hears, its timestamps go up, and a
    /// receiver that has heard it believes all of them.
    #[test]
    fn timestamps_only_go_up(
        told in prop::collection::vec((0u64..1 << 49, prop::option::of(0u64..1 << 48)), 1..50),
    ) {
        let ours = link(1, 0);
        let (mut sender, mut receiver) = (Session::new(), Session::new());
        let mut last = None;
        for (now, heard) in told {
            let now = Timestamp::from_ticks(now);
            if let Some(heard) = heard {
                // Believed or not.
                let _ = sender.verify(&ours, &signed(&ours, Timestamp::from_ticks(heard)), now);
            }
            let sealed = sender.sign(&ours, frame(1), now).unwrap();
            let timestamp = sealed.signature().unwrap().timestamp;
            // Until the 48 bits are used up, in 2104.
            if timestamp.ticks() == (1 << 48) - 1 {
                break;
            }
            prop_assert!(Some(timestamp) > last);
            prop_assert_eq!(receiver.verify(&ours, &sealed, Timestamp::default()), Ok(()));
            last = Some(timestamp);
        }
    }
}
