//! The neighbour messages: their committed form, every way to be wrong, and that no
//! bytes can do harm.

use firmware_core::geometry::{COORDINATE_LIMIT, State, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, MAX_LEN, Message, MessageError};
use proptest::collection::vec;
use proptest::prelude::*;

/// The examples of docs/messages.md. They were made by the Python code there; changing
/// them is a new version of the layout.
const BEACON: &str = "01010700ffff2a000000204801000090010000faffff001000fe9c";
const FEATURE: &str = "0102090001002b000000016745230100000380007f";
const WIDE_FEATURE: &str = "0102070001022a00000005efcdab89d4fe4080a5caef14395e83a8cdf2173c6186abd0f51a3f6489\
                            aed3f81d42678cb1d6fb20456a8fb4d9fe23486d92b7dc01264b7095badf04294e7398bde2072c51769b";

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap()).collect()
}

fn encoded(message: &Message) -> Vec<u8> {
    message.encode(&mut [0xee; MAX_LEN]).to_vec()
}

fn beacon() -> Message {
    let state = State { position: Vec2 { x: 102_400, y: -1536 }, velocity: Vec2 { x: 4096, y: -512 } };
    Message::Beacon(Beacon::new(Header { id: 7, sequence: 65_535, step: 42 }, 84_000, state, -100))
}

fn feature() -> Message {
    let header = Header { id: 9, sequence: 1, step: 43 };
    Message::Feature(FeatureMessage::new(header, 1, 0x0123_4567, 0, &[-128, 0, 127]).unwrap())
}

fn wide_feature() -> Message {
    let values: Vec<i8> = (0..64).map(|i| ((i * 37) % 256 - 128) as i8).collect();
    let header = Header { id: 7, sequence: 513, step: 42 };
    Message::Feature(FeatureMessage::new(header, 5, 0x89ab_cdef, -300, &values).unwrap())
}

#[test]
fn the_committed_bytes_hold() {
    for (message, hex) in [(beacon(), BEACON), (feature(), FEATURE), (wide_feature(), WIDE_FEATURE)] {
        assert_eq!(encoded(&message), bytes(hex));
        assert_eq!(Message::decode(&bytes(hex)), Ok(message));
    }
}

#[test]
fn the_document_shows_the_committed_bytes() {
    let document = include_str!("../../docs/messages.md");
    assert!(document.contains(BEACON));
    assert!(document.contains(FEATURE));
}

#[test]
fn a_message_fits_the_swarm_link() {
    assert_eq!(encoded(&wide_feature()).len(), MAX_LEN);
    const { assert!(MAX_LEN <= 100) };
}

/// `hex` with one byte set to something else, decoded.
fn with(hex: &str, at: usize, value: u8) -> Result<Message, MessageError> {
    let mut b = bytes(hex);
    b[at] = value;
    Message::decode(&b)
}

#[test]
fn every_cut_is_too_short_and_every_addition_too_long() {
    for hex in [BEACON, FEATURE, WIDE_FEATURE] {
        let mut b = bytes(hex);
        for len in 0..b.len() {
            assert!(matches!(Message::decode(&b[..len]), Err(MessageError::TooShort { len: l, .. }) if l == len));
        }
        let needed = b.len();
        b.push(0);
        assert_eq!(Message::decode(&b), Err(MessageError::TooLong { len: needed + 1, needed }));
    }
}

#[test]
fn each_field_out_of_range_has_its_error() {
    assert_eq!(with(BEACON, 0, 2), Err(MessageError::UnknownVersion(2)));
    assert_eq!(with(BEACON, 1, 3), Err(MessageError::UnknownKind(3)));
    assert_eq!(with(BEACON, 17, 0x7f), Err(MessageError::Position(0x7f01_9000)));
    assert_eq!(with(BEACON, 21, 0x80), Err(MessageError::Position(-0x7f00_0600)));
    assert_eq!(with(BEACON, 26, 0x80), Err(MessageError::Tie));
    assert_eq!(with(FEATURE, 10, 0), Err(MessageError::Degree(0)));
    assert_eq!(with(FEATURE, 10, 18), Err(MessageError::Degree(18)));
    assert_eq!(with(FEATURE, 17, 0), Err(MessageError::Width(0)));
    assert_eq!(with(FEATURE, 17, 65), Err(MessageError::Width(65)));
    assert_eq!(FeatureMessage::new(Header::default(), 1, 0, 0, &[]), Err(MessageError::Width(0)));
    assert_eq!(FeatureMessage::new(Header::default(), 1, 0, 0, &[0; 300]), Err(MessageError::Width(255)));
}

#[test]
fn coordinates_at_the_limit_are_valid() {
    let limit = Vec2 { x: COORDINATE_LIMIT, y: -COORDINATE_LIMIT };
    let state = State { position: limit, velocity: Vec2::default() };
    let message = Message::Beacon(Beacon::new(Header::default(), 0, state, 0));
    assert_eq!(Message::decode(&encoded(&message)), Ok(message));
}

#[test]
fn what_a_beacon_cannot_hold_becomes_the_nearest() {
    let far = Vec2 { x: i32::MIN, y: i32::MAX };
    let made = Beacon::new(Header::default(), 0, State { position: far, velocity: far }, -128);
    assert_eq!(made.state().position, Vec2 { x: -COORDINATE_LIMIT, y: COORDINATE_LIMIT });
    assert_eq!(made.state().velocity, Vec2 { x: -32_768, y: 32_767 });
    assert_eq!(made.tie(), -127);
}

fn any_header() -> impl Strategy<Value = Header> {
    any::<(u16, u16, u32)>().prop_map(|(id, sequence, step)| Header { id, sequence, step })
}

fn any_message() -> impl Strategy<Value = Message> {
    let vec2 = any::<(i32, i32)>().prop_map(|(x, y)| Vec2 { x, y });
    let beacon = (any_header(), any::<u32>(), vec2.clone(), vec2, any::<i8>())
        .prop_map(|(h, t, position, velocity, tie)| Beacon::new(h, t, State { position, velocity }, tie));
    let feature = (any_header(), 1..=17u8, any::<u32>(), any::<i16>(), vec(any::<i8>(), 1..=64))
        .prop_map(|(h, degree, actor, scalar, values)| FeatureMessage::new(h, degree, actor, scalar, &values).unwrap());
    prop_oneof![beacon.prop_map(Message::Beacon), feature.prop_map(Message::Feature)]
}

proptest! {
    #[test]
    fn a_message_survives_the_way(message in any_message()) {
        prop_assert_eq!(Message::decode(&encoded(&message)), Ok(message));
    }

    #[test]
    fn bytes_have_one_meaning_and_meanings_one_form(
        message in any_message(),
        flips in vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
    ) {
        let mut b = encoded(&message);
        for (at, value) in flips {
            let at = at.index(b.len());
            b[at] = value;
        }
        if let Ok(read) = Message::decode(&b) {
            prop_assert_eq!(encoded(&read), b);
        }
    }

    #[test]
    fn arbitrary_bytes_do_no_harm(b in vec(any::<u8>(), 0..200)) {
        if let Ok(read) = Message::decode(&b) {
            prop_assert_eq!(encoded(&read), b);
        }
    }
}
