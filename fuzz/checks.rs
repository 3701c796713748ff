//! What must hold whatever the bytes are. The fuzz targets run these on new inputs, the
//! tests of firmware-core on the corpus.

use firmware_core::action::ACTIONS;
use firmware_core::actor::file::{Body, HEADER};
use firmware_core::actor::{
    Actor, ActorInput, CellsActor, MAX_FEATURE, NeighbourFeature, PolicyId, QuantisedActor, argmax, sample,
};
use firmware_core::geometry::Vec2;
use firmware_core::message::{MAX_LEN, Message};
use firmware_core::neighbour_table::{Moment, NeighbourTable};
use firmware_core::observation::cells::{Cells, MAX_ACTIVE};
use firmware_core::observation::{LEN, MAX_NEIGHBOURS, Neighbours};
use firmware_core::pil::{MAX_REQUEST, Request, Server, Setup, encode_frame, frame_len};
use serde::ser::{Serialize, SerializeTuple, Serializer};
use std::cell::RefCell;

/// Neither loading a file nor flying what loads does harm.
///
/// Checksum and content hash stop nearly every change, so the body is also taken by itself
/// and stored anew with fitting ones.
pub fn actor_file(data: &[u8]) {
    fly_either_form(data);
    let Some(body) = data.get(HEADER..) else { return };
    let Ok((body, _)) = postcard::take_from_bytes::<Body<'_>>(body) else { return };
    let mut file = vec![0; data.len() + 64];
    let Ok(n) = body.store(&mut file) else { return };
    fly_either_form(&file[..n]);
}

fn fly_either_form(file: &[u8]) {
    let fills = [-127, 0, 127];
    if let Ok(actor) = Actor::load(file) {
        fly(&actor, fills.map(|fill: i8| [fill; LEN]));
    }
    if let Ok(actor) = CellsActor::load(file) {
        fly(&actor, fills.map(|fill: i8| Cells::new([fill; 2], [fill.unsigned_abs().into(); MAX_ACTIVE])));
    }
}

/// Takes an actor to its extremes. Sums that overflow would panic here.
fn fly<O: ActorInput>(actor: &QuantisedActor<'_, O>, observations: [O; 3]) {
    let _ = actor.self_test();
    let width = usize::from(actor.dimensions().feature);
    for observation in observations {
        let own = actor.encode(&observation);
        assert!(own.own.iter().all(|&v| v >= 0) && own.values.iter().all(|&v| v >= -127));
        for (value, attention_source) in [(-128, i16::MIN), (127, i16::MAX)] {
            let values = [value; MAX_FEATURE];
            let neighbour = NeighbourFeature { values: &values[..width], degree: value as u8, attention_source };
            for count in [0, 1, MAX_NEIGHBOURS, MAX_NEIGHBOURS + 1] {
                let logits = actor.logits(&own, count as u8 + 1, std::iter::repeat_n(neighbour, count));
                assert!(usize::from(argmax(&logits).index()) < ACTIONS);
                assert!(usize::from(sample(&logits, u32::MAX).index()) < ACTIONS);
            }
        }
    }
}

/// A message that can be read has one form; a table stays sound whatever it hears.
///
/// The data are records: ms that pass (i16), length (u8), that many bytes heard.
pub fn neighbour_message(data: &[u8]) {
    let mut table = NeighbourTable::new(0, PolicyId { hash: 0x0101_0101, width: 2 }, 2000);
    let mut view = Neighbours::new();
    let (mut rest, mut time_ms) = (data, 0u32);
    check_message(data);
    while let [p0, p1, len, tail @ ..] = rest {
        let (bytes, next) = tail.split_at(usize::from(*len).min(tail.len()));
        rest = next;
        time_ms = time_ms.wrapping_add(i16::from_le_bytes([*p0, *p1]) as u32);
        let Some(message) = check_message(bytes) else { continue };
        let now = Moment { step: time_ms / 2000, time_ms };
        let own = Vec2 { x: i32::from(*p0) * 1024, y: i32::from(*p1) * 1024 };
        let answer = table.hear(&message, own, now);
        assert!(table.len() <= MAX_NEIGHBOURS);
        assert!(!(answer.is_taken() && table.is_empty()));
        table.view(own, now, &mut view);
        assert!(view.as_slice().len() <= table.len());
        let distances = || view.as_slice().iter().map(|n| n.offset.within(18 * 1024).unwrap());
        assert!(distances().is_sorted());
        assert!(view.as_slice().iter().all(|n| n.id != 0));
        assert!(table.features(&view, now.step).all(|(_, f)| f.values.len() == 2 && (1..=17).contains(&f.degree)));
    }
}

fn check_message(bytes: &[u8]) -> Option<Message> {
    let message = Message::decode(bytes).ok()?;
    assert_eq!(message.encode(&mut [0; MAX_LEN]), bytes);
    Some(message)
}

/// A board on a line with anything on it still answers.
///
/// The data are records: kind and length (u16: the top bit is the kind), that many bytes. They come over the
/// line as they are, or as the record of an intact frame.
pub fn pil(data: &[u8]) {
    BOARD.with_borrow_mut(|server| talk(server, data));
}

// Booted once, since that takes most of the time; Hello starts afresh.
thread_local!(static BOARD: RefCell<Server<'static>> = RefCell::new({
    let mut server = Server::new();
    server.boot(include_bytes!("../firmware-core/tests/data/tiny-gat.actor"));
    server
}));

fn talk(server: &mut Server<'_>, data: &[u8]) {
    const SETUP: Setup = Setup { id: 3, seed: 1, argmax: false, step_ms: 2000, half_side: 102_400 };
    let mut buffer = [0; frame_len(MAX_REQUEST + 16)];
    let hello = encode_frame(1, &Request::Hello(SETUP), &mut buffer).unwrap();
    assert_eq!(answers(server, hello), 1);
    let mut rest = data;
    while let [l0, l1, tail @ ..] = rest {
        let head = u16::from_le_bytes([*l0, *l1]);
        let (bytes, next) = tail.split_at(usize::from(head & 0x7fff).min(tail.len()));
        rest = next;
        if head & 0x8000 == 0 {
            answers(server, bytes);
            // The fuzzer does find intact frames; one left open would be answered with the next.
            answers(server, &[0]);
        } else if !is_slow(bytes)
            && let Some(frame) = encode_frame(*l0, &Plain(bytes), &mut buffer)
        {
            assert_eq!(answers(server, frame), usize::from(bytes.len() <= MAX_REQUEST - 2));
        }
    }
    let status = encode_frame(2, &Request::Status, &mut buffer).unwrap();
    assert_eq!(answers(server, status), 1);
}

fn answers(server: &mut Server<'_>, line: &[u8]) -> usize {
    line.iter().filter(|&&b| server.push(b).is_some()).count()
}

/// Signatures and self-tests take long and teach the fuzzer little.
fn is_slow(record: &[u8]) -> bool {
    match postcard::take_from_bytes(record) {
        Ok((Request::Sign { cases, .. }, _)) => cases > 1,
        Ok((Request::SelfTest, _)) => true,
        _ => false,
    }
}

/// Bytes that are a record already.
struct Plain<'a>(&'a [u8]);

impl Serialize for Plain<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|b| tuple.serialize_element(b))?;
        tuple.end()
    }
}
