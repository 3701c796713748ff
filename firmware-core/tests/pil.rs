//! The PIL protocol's frames and the board's end of it, byte by byte.

mod common;

use common::sample_actor;
use firmware_core::actor::{Actor, Aggregation, LoadError, fingerprint};
use firmware_core::neighbour_table::{MessageOutcome, Moment};
use firmware_core::pil::{
    ActorError, Decided, Deframer, FrameError, Hear, MAX_CASES, MAX_POIS, MAX_REPLY, MAX_REQUEST, Observe, Observed,
    Reply, Report, Request, RequestError, Server, Setup, Status, VERSION, decode_frame, encode_frame, frame_len,
};
use proptest::collection::vec;
use proptest::prelude::*;
use std::sync::LazyLock;

static ACTOR: LazyLock<Vec<u8>> = LazyLock::new(|| sample_actor(Aggregation::Gat, 3));

const SETUP: Setup = Setup { id: 7, seed: 10, argmax: false, step_ms: 2000, half_side: 102_400 };
/// `Hello(SETUP)` with tag 1, as `docs/pil.md` has it.
const HELLO: &str = "0003010103070a0ad00f80c00cafbc911900";

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap()).collect()
}

fn sealed(tag: u8, request: &Request<'_>) -> Vec<u8> {
    encode_frame(tag, request, &mut [0; frame_len(MAX_REQUEST)]).unwrap().to_vec()
}

/// What comes out of a stream: contents of intact frames, and errors.
fn found(stream: &[u8]) -> Vec<Result<Vec<u8>, FrameError>> {
    let mut deframer = Deframer::<600>::new();
    stream.iter().filter_map(|&b| deframer.push(b).map(|r| r.map(<[u8]>::to_vec))).collect()
}

/// The frame of a content that may be none of ours, made by another COBS encoder.
fn foreign_frame(content: &[u8]) -> Vec<u8> {
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(content).to_le_bytes();
    let plain = [content, &crc].concat();
    let mut coded = vec![0; cobs::max_encoding_length(plain.len())];
    let n = cobs::encode(&plain, &mut coded);
    coded.truncate(n);
    coded.push(0);
    coded
}

/// A server that was told to fly, and its answers.
fn started() -> Server<'static> {
    let mut server = booted();
    assert!(ask(&mut server, 1, &Request::Hello(SETUP), |r| matches!(r, Reply::Report(_))));
    server
}

fn booted() -> Server<'static> {
    let mut server = Server::new();
    server.boot(&ACTOR);
    server
}

/// Feeds a stream; tag and record of every answer.
fn feed(server: &mut Server<'_>, stream: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let mut answers = Vec::new();
    for &byte in stream {
        if let Some(answer) = server.push(byte) {
            let content = found(answer).pop().unwrap().unwrap();
            let (tag, record) = decode_frame(&content).unwrap();
            answers.push((tag, record.to_vec()));
        }
    }
    answers
}

fn ask<T>(server: &mut Server<'_>, tag: u8, request: &Request<'_>, look: impl FnOnce(Reply<'_>) -> T) -> T {
    let answers = feed(server, &sealed(tag, request));
    assert_eq!(answers.len(), 1);
    assert_eq!(answers[0].0, tag);
    look(postcard::from_bytes(&answers[0].1).unwrap())
}

fn refused(server: &mut Server<'_>, request: &Request<'_>) -> Option<RequestError> {
    ask(server, 9, request, |r| if let Reply::Refused(why) = r { Some(why) } else { None })
}

fn observe(step: u32, pois: &[u8]) -> Request<'_> {
    let now = Moment { step, time_ms: step * 2000 };
    Request::Observe(Observe { now, position: [50_000, 60_000], velocity: [100, -200], pois })
}

#[test]
fn the_committed_frame_holds() {
    assert_eq!(sealed(1, &Request::Hello(SETUP)), bytes(HELLO));
    assert!(include_str!("../../docs/pil.md").contains(HELLO));
}

#[test]
fn a_server_is_small() {
    // With pointers of 64 bits; less on a board.
    assert!(size_of::<Server<'_>>() <= 5900, "{}", size_of::<Server<'_>>());
}

#[test]
fn the_longest_records_fit() {
    let message = [0xff; 82];
    let pois = [0xff; MAX_POIS * 4];
    let now = Moment { step: u32::MAX, time_ms: u32::MAX };
    let observe = Observe { now, position: [i32::MIN; 2], velocity: [i32::MIN; 2], pois: &pois };
    let mut long = [0; frame_len(MAX_REQUEST)];
    assert!(encode_frame(1, &Request::Observe(observe), &mut long).unwrap().len() <= frame_len(MAX_REQUEST));
    let mut short = [0; frame_len(MAX_REPLY)];
    let counters = firmware_core::pil::Counters {
        done: u32::MAX,
        refused: u32::MAX,
        too_long: u32::MAX,
        broken: u32::MAX,
        too_short: u32::MAX,
        checksum: u32::MAX,
        version: u32::MAX,
    };
    for reply in [
        Reply::Observed(Observed { step: u32::MAX, degree: 17, tie: -127, message: &message }),
        Reply::Decided(Decided { step: u32::MAX, action: 16, features: 16, logits: [i16::MIN; 17] }),
        Reply::Status(Status { started: true, observed: Some(u32::MAX), kept: 16, decisions: u32::MAX, counters }),
    ] {
        assert!(encode_frame(255, &reply, &mut short).is_some());
    }
}

#[test]
fn each_bad_frame_has_its_error() {
    let good = sealed(1, &Request::Status);
    assert_eq!(found(&good).len(), 1);
    assert_eq!(found(&good[..good.len() - 1]), []);
    let cut = [&good[..good.len() - 2], &[0]].concat();
    assert_eq!(found(&cut), [Err(FrameError::Broken)]);
    assert_eq!(found(&[0, 3, 1, 1, 0, 0, 0]), [Err(FrameError::TooShort)]);
    assert_eq!(found(&foreign_frame(&[0; 600])), [Err(FrameError::TooLong)]);
    let mut damaged = good.clone();
    damaged[3] ^= 0x40;
    assert_eq!(found(&damaged), [Err(FrameError::Checksum)]);
    assert_eq!(decode_frame(&[VERSION]), Err(FrameError::TooShort));
    assert_eq!(decode_frame(&[VERSION + 1, 4, 9]), Err(FrameError::Version(VERSION + 1)));
}

#[test]
fn a_board_without_a_sound_actor_says_so_and_flies_nothing() {
    let mut server = Server::new();
    assert_eq!(
        refused(&mut server, &Request::Sign { from: 0, cases: 1 }),
        Some(RequestError::Actor(ActorError::NotLoaded))
    );
    let mut damaged = ACTOR.clone();
    damaged[100] ^= 1;
    assert!(matches!(Actor::load(&damaged), Err(LoadError::Checksum { .. })));
    let report = found(server.boot(&damaged)).pop().unwrap().unwrap();
    let (tag, record) = decode_frame(&report).unwrap();
    let report: Reply<'_> = postcard::from_bytes(record).unwrap();
    let expected = Report { software: env!("CARGO_PKG_VERSION"), actor: Err(ActorError::Checksum) };
    assert_eq!((tag, report), (0, Reply::Report(expected)));
    assert!(!server.is_sound());
    ask(&mut server, 1, &Request::Hello(SETUP), |r| assert_eq!(r, Reply::Report(expected)));
    assert_eq!(refused(&mut server, &observe(0, &[])), Some(RequestError::Actor(ActorError::Checksum)));
    assert_eq!(refused(&mut server, &Request::Decide { step: 0 }), Some(RequestError::Actor(ActorError::Checksum)));
}

#[test]
fn nothing_is_flown_before_hello_nor_decided_before_observed() {
    let mut server = booted();
    assert_eq!(refused(&mut server, &observe(0, &[])), Some(RequestError::NotStarted));
    let mut server = started();
    assert_eq!(refused(&mut server, &Request::Decide { step: 0 }), Some(RequestError::NotObserved));
    assert_eq!(refused(&mut server, &observe(4, &[])), None);
    assert_eq!(refused(&mut server, &Request::Decide { step: 5 }), Some(RequestError::NotObserved));
    assert_eq!(refused(&mut server, &Request::Decide { step: 4 }), None);
    // Hello starts afresh.
    assert_eq!(refused(&mut server, &Request::Hello(SETUP)), None);
    assert_eq!(refused(&mut server, &Request::Decide { step: 4 }), Some(RequestError::NotObserved));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let mut server = started();
    let hear = |message| Request::Hear(Hear { now: Moment::default(), position: [0; 2], message });
    assert_eq!(refused(&mut server, &hear(&[1, 2, 3])), Some(RequestError::Message));
    assert_eq!(refused(&mut server, &observe(0, &[1, 2, 3])), Some(RequestError::Pois));
    assert_eq!(refused(&mut server, &observe(0, &[0; (MAX_POIS + 1) * 4])), Some(RequestError::Pois));
    for (content, why) in [
        (&[VERSION, 5, 200][..], RequestError::Unreadable),
        (&[VERSION, 5, 4, 4], RequestError::Unreadable),
        (&[VERSION, 5], RequestError::Unreadable),
        (&[VERSION + 1, 5, 4], RequestError::Version(VERSION)),
    ] {
        let answers = feed(&mut server, &foreign_frame(content));
        let reply: Reply<'_> = postcard::from_bytes(&answers[0].1).unwrap();
        assert_eq!((answers[0].0, reply), (5, Reply::Refused(why)));
    }
}

#[test]
fn a_request_may_be_sent_again() {
    let mut server = started();
    let mut answers = Vec::new();
    for request in [observe(3, &[0, 4, 0, 8]), Request::Decide { step: 3 }, Request::Sign { from: 0, cases: 5 }] {
        let [first, second] = [1, 1].map(|tag| feed(&mut server, &sealed(tag, &request)));
        assert_eq!(first, second);
        answers.push(first);
    }
    let again = Request::Sign { from: 5, cases: 7 };
    let [first, second] = [1, 1].map(|tag| feed(&mut server, &sealed(tag, &again)));
    assert_eq!(first, second);
    let actor = Actor::load(&ACTOR).unwrap();
    let value = fingerprint(&actor, 12);
    assert_eq!(postcard::from_bytes::<Reply<'_>>(&first[0].1), Ok(Reply::Signature { cases: 12, value }));
}

#[test]
fn one_request_signs_only_so_much() {
    let mut server = booted();
    let request = Request::Sign { from: 0, cases: u16::MAX };
    ask(&mut server, 1, &request, |r| {
        assert!(matches!(r, Reply::Signature { cases, .. } if cases == u32::from(MAX_CASES)))
    });
}

#[test]
fn garbage_is_counted_by_reason() {
    let mut server = started();
    let good = sealed(2, &Request::Status);
    let mut damaged = good.clone();
    damaged[3] ^= 1;
    let long = [vec![0xaa; 5000], vec![0]].concat();
    for stream in [&damaged[..], &good[..good.len() - 3], &[0, 2, 2, 0], &long, &foreign_frame(&[9, 9, 9])] {
        feed(&mut server, stream);
    }
    let status = ask(&mut server, 3, &Request::Status, |r| if let Reply::Status(s) = r { s } else { panic!("{r:?}") });
    let c = status.counters;
    assert_eq!((c.checksum, c.broken, c.too_short, c.too_long, c.version), (1, 1, 1, 1, 1));
    assert_eq!((c.done, c.refused, c.dropped()), (1, 1, 4));
    assert!(status.started);
}

proptest! {
    #[test]
    fn records_survive_the_line(tag: u8, record in vec(prop_oneof![Just(0u8), any::<u8>()], 0..500)) {
        // A record of bytes is its length and the bytes.
        let mut out = [0; frame_len(600)];
        let frame = encode_frame(tag, &record, &mut out).unwrap();
        let inside = &frame[1..frame.len() - 1];
        prop_assert!(frame[0] == 0 && frame[frame.len() - 1] == 0 && !inside.contains(&0));
        let content = [&[VERSION, tag][..], &postcard::to_stdvec(&record).unwrap()].concat();
        prop_assert!(frame.len() <= frame_len(content.len()));
        let mut decoded = vec![0; inside.len()];
        let n = cobs::decode(inside, &mut decoded).unwrap();
        prop_assert_eq!(&decoded[..n - 4], &content[..]);
        prop_assert_eq!(found(frame), [Ok(content.clone())]);
        prop_assert_eq!(found(&foreign_frame(&content)), [Ok(content)]);
    }

    #[test]
    fn long_runs_survive_the_line(runs in vec((0..600usize, 0..3usize), 0..4)) {
        let record: Vec<u8> = runs.iter().flat_map(|&(n, zeros)| [vec![7; n], vec![0; zeros]].concat()).take(590).collect();
        let mut out = [0; frame_len(600)];
        let frame = encode_frame(1, &record, &mut out).unwrap();
        let content = [&[VERSION, 1][..], &postcard::to_stdvec(&record).unwrap()].concat();
        prop_assert_eq!(found(frame), [Ok(content.clone())]);
        prop_assert_eq!(found(&foreign_frame(&content)), [Ok(content)]);
    }

    #[test]
    fn a_frame_too_long_for_its_buffer_is_none(record in vec(any::<u8>(), 0..200), room in 0..250usize) {
        let mut out = vec![0; room];
        let fits = encode_frame(1, &record, &mut out).map(<[u8]>::len);
        let whole = encode_frame(1, &record, &mut [0; 300]).unwrap().len();
        prop_assert_eq!(fits, (whole <= room).then_some(whole));
    }

    #[test]
    fn damage_is_never_taken_for_a_request(flips in vec((any::<prop::sample::Index>(), 1..=255u8), 1..4)) {
        let mut frame = sealed(1, &observe(77, &[1, 2, 3, 4]));
        let whole = frame.clone();
        for (at, change) in flips {
            let at = at.index(frame.len());
            frame[at] ^= change;
        }
        prop_assume!(frame != whole);
        let mut server = started();
        let before = server.counters().done;
        let observed = feed(&mut server, &frame);
        prop_assert!(observed.is_empty() || frame[1..frame.len() - 1] == whole[1..whole.len() - 1]);
        prop_assert_eq!(server.counters().done, before + observed.len() as u32);
    }

    #[test]
    fn floods_cost_nothing_but_counters(floods in vec(vec(any::<u8>(), 0..1500), 1..5)) {
        let mut server = started();
        let expected = feed(&mut started(), &sealed(9, &observe(5, &[])));
        for flood in floods {
            feed(&mut server, &flood);
            prop_assert_eq!(feed(&mut server, &sealed(9, &observe(5, &[]))), expected.clone());
        }
    }

    #[test]
    fn arbitrary_records_do_no_harm(records in vec(vec(any::<u8>(), 0..60), 0..20)) {
        let mut server = started();
        for record in &records {
            let frame = foreign_frame(&[&[VERSION, 3][..], record].concat());
            prop_assert_eq!(feed(&mut server, &frame).len(), 1);
        }
        let c = server.counters();
        prop_assert_eq!(c.done + c.refused, 1 + records.len() as u32);
    }

    #[test]
    fn any_message_may_be_heard(message in vec(any::<u8>(), 0..90), step: u32, time_ms: u32, position: [i32; 2]) {
        let mut server = started();
        let request = Request::Hear(Hear { now: Moment { step, time_ms }, position, message: &message });
        ask(&mut server, 1, &request, |r| match r {
            Reply::Heard { kept: 0, outcome: MessageOutcome::Late | MessageOutcome::Ahead | MessageOutcome::UnknownSender | MessageOutcome::ForeignActor | MessageOutcome::OwnId } => {}
            Reply::Heard { kept: 1, outcome: MessageOutcome::New } | Reply::Refused(RequestError::Message) => {}
            other => panic!("{other:?}"),
        });
    }
}
