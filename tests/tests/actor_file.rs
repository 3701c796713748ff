//! The actor file: pinned by committed bytes, read by a second reader, and refused in
//! every way in which it can be wrong.

mod plain_actor;

use crc::{CRC_32_ISO_HDLC, Crc};
use firmware_core::action::ACTIONS;
use firmware_core::actor::file::{Body, LoadError};
use firmware_core::actor::layer::MAX_BIAS;
use firmware_core::actor::{
    Actor, ActorInput, Aggregation, CellsActor, Dimensions, FINGERPRINT_CASES, QuantisedActor, SelfTestError,
    fingerprint,
};
use firmware_core::observation::{self, LEN};
use plain_actor::{HEADER, PlainActor, TRAILER, fnv};
use proptest::prelude::*;
use std::path::Path;

/// The committed actors, and the number that their aggregation has in a file.
const KINDS: [(&str, Aggregation, u64); 5] = [
    ("sample-none", Aggregation::None, plain_actor::NONE),
    ("sample-gcn", Aggregation::Gcn, plain_actor::GCN),
    ("sample-gat", Aggregation::Gat, plain_actor::GAT),
    ("sample-gatv2", Aggregation::GatV2, plain_actor::GATV2),
    ("sample-sage", Aggregation::Sage, plain_actor::SAGE),
];

fn committed(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware-core/tests/data");
    std::fs::read(folder.join(format!("{name}.actor"))).expect("a committed sample actor")
}

fn gat() -> Vec<u8> {
    committed("sample-gat")
}

/// Length, FNV-1a of the bytes, content hash and signature over all cases of every
/// committed actor, as `data/actors.pins` has them. When this fails, the format, the
/// loader or the arithmetic has changed: actor files in the field will not fly, or not
/// the same, with the new code. `COVEY_BLESS=1` writes the pins anew after a deliberate
/// change (and after firmware-core's own tests have written the files anew).
#[test]
fn committed_files_are_the_same_bytes_and_the_same_function() {
    let mut found = String::from("# actor, bytes, FNV-1a, content hash, signature\n");
    for (name, _, _) in KINDS {
        let file = committed(name);
        found += &pin(name, &file, &Actor::load(&file).unwrap_or_else(|e| panic!("{name}: {e}")));
    }
    let cells = committed("cells-gcn");
    found += &pin("cells-gcn", &cells, &CellsActor::load(&cells).expect("sound"));
    let pins = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/actors.pins");
    if std::env::var_os("COVEY_BLESS").is_some() {
        std::fs::write(&pins, &found).expect("pins written");
    }
    assert_eq!(found, std::fs::read_to_string(&pins).expect("data/actors.pins"));
}

/// The line of an actor.
fn pin<O: ActorInput>(name: &str, file: &[u8], actor: &QuantisedActor<'_, O>) -> String {
    actor.self_test().unwrap_or_else(|e| panic!("{name}: {e}"));
    let numbers = [fnv(file), actor.content_hash(), fingerprint(actor, FINGERPRINT_CASES)];
    let [digest, content, signature] = numbers.map(|n| format!("{n:016x}"));
    format!("{name} {} {digest} {content} {signature}\n", file.len())
}

#[test]
fn a_reader_written_from_the_description_finds_the_same() {
    for (name, aggregation, number) in KINDS {
        let file = committed(name);
        let (plain, actor) = (PlainActor::read(&file), Actor::load(&file).expect("sound"));
        assert_eq!((plain.aggregation, actor.aggregation()), (number, aggregation));
        assert_eq!(plain.observation_id, u64::from(observation::ID));
        let d = actor.dimensions();
        let widths = [d.observation, d.hidden, d.feature, d.head, d.actions].map(usize::from);
        assert_eq!((plain.widths, widths), ([LEN, 24, 16, 24, ACTIONS], [LEN, 24, 16, 24, ACTIONS]));
        assert_eq!((plain.tie_period, actor.tie_period()), (4, 4));
        assert_eq!(plain.aggregate_multiplier, if number == plain_actor::NONE { 0 } else { 1 << 17 });
        let p = actor.provenance();
        assert_eq!((plain.trainer.as_str(), plain.scenario.as_str()), (p.trainer, p.scenario));
        let numbers = [p.uavs.into(), p.seed, p.episodes.into(), p.worlds.into()];
        assert_eq!(plain.numbers[..4], numbers);
        assert_eq!(plain.numbers[4..], [p.float_coverage.into(), p.int8_coverage.into()]);
        assert_eq!([plain.computed_hash(&file), plain.content_hash], [actor.content_hash(); 2]);
        assert_eq!(plain.weights_at.start % 4, 0, "weights lie where word reads are aligned");
    }
}

// --- Damage ---------------------------------------------------------------------------

fn flipped(file: &[u8], bit: usize) -> Vec<u8> {
    let mut file = file.to_vec();
    file[bit / 8] ^= 1 << (bit % 8);
    file
}

fn refusal(file: &[u8]) -> LoadError {
    Actor::load(file).expect_err("a sound actor")
}

#[test]
fn every_flipped_bit_of_header_and_trailer_is_refused() {
    for (name, _, _) in KINDS {
        let file = committed(name);
        for bit in 0..8 * HEADER {
            let error = refusal(&flipped(&file, bit));
            let fits = match bit / 8 {
                0..8 => error == LoadError::NotAnActor,
                8..10 => matches!(error, LoadError::Version { found } if found == 1 ^ 1 << (bit - 64)),
                10..12 => matches!(error, LoadError::Checksum { .. }),
                _ => matches!(error, LoadError::Truncated { .. } | LoadError::Extended { .. }),
            };
            assert!(fits, "{}: header bit {bit}: {error:?}", name);
        }
        for bit in 8 * (file.len() - TRAILER)..8 * file.len() {
            let error = refusal(&flipped(&file, bit));
            assert!(matches!(error, LoadError::Checksum { .. }), "{}: bit {bit}: {error:?}", name);
        }
    }
}

/// All 68,000 of them; the other kinds differ in nothing that matters here.
#[test]
fn every_flipped_bit_of_the_body_is_refused() {
    let mut file = gat();
    for bit in 8 * HEADER..8 * (file.len() - TRAILER) {
        file[bit / 8] ^= 1 << (bit % 8);
        let error = refusal(&file);
        assert!(matches!(error, LoadError::Checksum { .. }), "bit {bit}: {error:?}");
        file[bit / 8] ^= 1 << (bit % 8);
    }
    assert_eq!(file, gat());
}

#[test]
fn every_other_length_is_refused() {
    for (name, _, _) in KINDS {
        let file = committed(name);
        for found in 0..file.len() {
            let expected = if found < HEADER { HEADER + TRAILER } else { file.len() };
            assert_eq!(refusal(&file[..found]), LoadError::Truncated { expected, found });
        }
        for extra in 1..=64 {
            for filler in [0, 0xff] {
                let longer = [&file[..], &vec![filler; extra]].concat();
                assert_eq!(refusal(&longer), LoadError::Extended { extra });
            }
        }
        let twice = [&file[..], &file[..]].concat();
        assert_eq!(refusal(&twice), LoadError::Extended { extra: file.len() });
    }
}

proptest! {
    #[test]
    fn what_is_no_actor_is_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(Actor::load(&bytes).is_err());
    }

    /// Bursts and blocks of damage, with the checksum left as it was.
    #[test]
    fn overwritten_stretches_are_refused(
        at in any::<prop::sample::Index>(),
        new in proptest::collection::vec(any::<u8>(), 1..300),
    ) {
        let file = gat();
        let at = at.index(file.len());
        let mut damaged = file.clone();
        damaged.iter_mut().skip(at).zip(new).for_each(|(b, n)| *b = n);
        prop_assume!(damaged != file);
        prop_assert!(Actor::load(&damaged).is_err());
    }
}

// --- Files that are whole, but wrong --------------------------------------------------

/// Length and checksum made right again after the body was changed.
fn sealed(mut file: Vec<u8>) -> Vec<u8> {
    file.truncate(file.len() - TRAILER);
    let length = (file.len() - HEADER) as u32;
    file[12..16].copy_from_slice(&length.to_le_bytes());
    let sum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&file);
    file.extend(sum.to_le_bytes());
    file
}

/// A file with another body; lengths, content hash and checksum are right.
fn rebuilt<'b>(file: &'b [u8], change: impl FnOnce(&mut Body<'b>)) -> Vec<u8> {
    let mut body: Body<'b> = postcard::from_bytes(&file[HEADER..file.len() - TRAILER]).expect("a body");
    change(&mut body);
    let mut out = vec![0; 2 * file.len()];
    let n = body.store(&mut out).expect("room");
    out.truncate(n);
    out
}

/// The GAT sample with another body.
fn altered(change: impl for<'b> FnOnce(&mut Body<'b>)) -> Vec<u8> {
    rebuilt(&gat(), change)
}

/// The GAT sample with other tables.
fn with_tables(change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    with_tables_of(&gat(), change)
}

/// A file with other tables.
fn with_tables_of(file: &[u8], change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut tables = file[PlainActor::read(file).tables_at].to_vec();
    change(&mut tables);
    rebuilt(file, |body| body.tables = &tables)
}

#[test]
fn sealing_and_altering_nothing_changes_nothing() {
    assert_eq!(sealed(gat()), gat());
    assert_eq!(altered(|_| {}), gat());
    assert_eq!(with_tables(|_| {}), gat());
}

#[test]
fn another_format_is_named() {
    let with = |at: usize, bytes: &[u8]| {
        let mut file = gat();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        refusal(&sealed(file))
    };
    assert_eq!(with(0, b"COVEYRUN"), LoadError::NotAnActor);
    assert_eq!(with(0, b"\x7fELF"), LoadError::NotAnActor);
    assert_eq!(with(8, &[2, 0]), LoadError::Version { found: 2 });
    assert_eq!(with(8, &[0, 0]), LoadError::Version { found: 0 });
    assert_eq!(with(10, &[0, 1]), LoadError::Malformed);
    let error = with(8, &[2, 0]).to_string();
    assert!(error.contains("format 2") && error.contains("format 1") && error.contains("export"), "{error}");
}

#[test]
fn a_record_that_cannot_be_read_is_malformed() {
    let plain = PlainActor::read(&gat());
    let mut file = gat();
    // An align length that runs far beyond the file.
    file[HEADER] = 0x7f;
    assert_eq!(refusal(&sealed(file)), LoadError::Malformed);
    // A byte of padding that is not zero.
    let mut file = gat();
    let padding = HEADER + 1..plain.weights_at.start - 2;
    assert!(!padding.is_empty(), "the sample has padding to spoil");
    file[padding.start] = 1;
    assert_eq!(refusal(&sealed(file)), LoadError::Malformed);
    // An aggregation that does not exist: it follows the observation's id.
    let mut file = gat();
    assert_eq!(file[plain.tables_at.end + 1], 2);
    file[plain.tables_at.end + 1] = 5;
    assert_eq!(refusal(&sealed(file)), LoadError::Malformed);
    // Bytes behind the record, inside the body.
    let mut file = gat();
    file.insert(file.len() - TRAILER, 0);
    assert_eq!(refusal(&sealed(file)), LoadError::Malformed);
    // The record ends too soon.
    let mut file = gat();
    file.remove(file.len() - TRAILER - 1);
    assert_eq!(refusal(&sealed(file)), LoadError::Malformed);
    // No body at all.
    let mut file = gat();
    file.drain(HEADER..file.len() - TRAILER);
    assert_eq!(refusal(&sealed(file)), LoadError::Malformed);
}

#[test]
fn another_observation_is_named() {
    let error = refusal(&altered(|b| b.observation = observation::ID + 1));
    assert_eq!(error, LoadError::Observation { found: observation::ID + 1, built: observation::ID });
    assert!(error.to_string().contains("train one of that form"), "{error}");
}

#[test]
fn every_width_has_its_bounds() {
    let dimension = |change: fn(&mut Dimensions, u16), width: u16| match refusal(&altered(|b| {
        change(&mut b.dimensions, width);
    })) {
        LoadError::Dimension { what, found, .. } => {
            assert_eq!(found, width);
            what
        }
        other => panic!("{width}: {other:?}"),
    };
    for width in [0, LEN as u16 - 1, LEN as u16 + 1, u16::MAX] {
        assert_eq!(dimension(|d, w| d.observation = w, width), "observation length");
    }
    for width in [0, 129, u16::MAX] {
        assert_eq!(dimension(|d, w| d.hidden = w, width), "first hidden width");
        assert_eq!(dimension(|d, w| d.head = w, width), "head width");
    }
    for width in [0, 1, 15, 63, 65, 66, u16::MAX] {
        assert_eq!(dimension(|d, w| d.feature = w, width), "feature width");
    }
    for width in [0, ACTIONS as u16 - 1, ACTIONS as u16 + 1, u16::MAX] {
        assert_eq!(dimension(|d, w| d.actions = w, width), "number of actions");
    }
}

#[test]
fn widths_that_fit_must_also_fit_the_weights() {
    let changes: [fn(&mut Body<'_>); 8] = [
        |b| b.dimensions.hidden += 2,
        |b| b.dimensions.hidden -= 2,
        |b| b.dimensions.feature += 2,
        |b| b.dimensions.head -= 1,
        |b| b.aggregation = Aggregation::Gcn,
        |b| b.aggregation = Aggregation::None,
        |b| b.aggregation = Aggregation::GatV2,
        |b| b.aggregation = Aggregation::Sage,
    ];
    for (k, change) in changes.into_iter().enumerate() {
        assert_eq!(refusal(&altered(change)), LoadError::Length, "change {k}");
    }
    for (name, aggregation, _) in KINDS {
        let file = committed(name);
        for (k, change) in changes[..4].iter().enumerate() {
            assert_eq!(refusal(&rebuilt(&file, change)), LoadError::Length, "{name}: change {k}");
        }
        // A GCN and GraphSAGE have the same layers: there the self-test tells them apart.
        let same = |other: Aggregation| {
            let shapes = |a| Actor::load(&file).expect("sound").dimensions().layers(a).collect::<Vec<_>>();
            shapes(aggregation) == shapes(other)
        };
        for other in Aggregation::ALL.into_iter().filter(|&other| other != aggregation) {
            let changed = rebuilt(&file, |b| b.aggregation = other);
            if same(other) {
                Actor::load(&changed).expect("it loads").self_test().expect_err("another function");
            } else {
                assert_eq!(refusal(&changed), LoadError::Length, "{name} as {other:?}");
            }
        }
    }
}

#[test]
fn weights_and_tables_of_another_length_are_refused() {
    fn cut(bytes: &[u8], less: usize) -> &[u8] {
        &bytes[..bytes.len() - less]
    }
    for less in [1, 2, 4, 100, 1000] {
        assert_eq!(refusal(&altered(|b| b.weights = cut(b.weights, less))), LoadError::Length, "weights − {less}");
    }
    for less in [1, 4, 8, 100] {
        assert_eq!(refusal(&altered(|b| b.tables = cut(b.tables, less))), LoadError::Length, "tables − {less}");
    }
    assert_eq!(refusal(&altered(|b| b.weights = &[])), LoadError::Length);
    assert_eq!(refusal(&altered(|b| b.tables = &[])), LoadError::Length);
    let file = gat();
    let plain = PlainActor::read(&file);
    for extra in [1, 4, 8] {
        let longer = [&file[plain.weights_at.clone()], &vec![0; extra]].concat();
        assert_eq!(refusal(&rebuilt(&file, |b| b.weights = &longer)), LoadError::Length, "weights + {extra}");
        assert_eq!(refusal(&with_tables(|t| t.extend(vec![0; extra]))), LoadError::Length, "tables + {extra}");
    }
}

#[test]
fn every_bias_and_multiplier_is_bounded() {
    for (name, aggregation, _) in KINDS {
        numbers_are_bounded(&committed(name), aggregation);
    }
    assert_eq!(refusal(&altered(|b| b.aggregate_multiplier = -1)), LoadError::OutOfRange);
    assert_eq!(refusal(&altered(|b| b.aggregate_multiplier = i32::MIN)), LoadError::OutOfRange);
}

fn numbers_are_bounded(file: &[u8], aggregation: Aggregation) {
    let shapes: Vec<_> = Actor::load(file).expect("sound").dimensions().layers(aggregation).collect();
    let put =
        |at: usize, value: i32| with_tables_of(file, |t| t[4 * at..4 * at + 4].copy_from_slice(&value.to_le_bytes()));
    let mut at = 0;
    for (rows, _) in shapes {
        for row in [0, rows - 1] {
            for bias in [MAX_BIAS + 1, -MAX_BIAS - 1, i32::MAX, i32::MIN] {
                assert_eq!(refusal(&put(at + row, bias)), LoadError::OutOfRange, "bias {bias} at {}", at + row);
            }
            for bias in [MAX_BIAS, -MAX_BIAS] {
                assert!(Actor::load(&put(at + row, bias)).is_ok(), "bias {bias} at {}", at + row);
            }
            for multiplier in [-1, i32::MIN] {
                assert_eq!(refusal(&put(at + rows + row, multiplier)), LoadError::OutOfRange, "{multiplier}");
            }
            assert!(Actor::load(&put(at + rows + row, i32::MAX)).is_ok());
        }
        at += 2 * rows;
    }
}

#[test]
fn self_tests_must_be_eight_readable_vectors() {
    let file = gat();
    let vectors = file[PlainActor::read(&file).self_tests_at].to_vec();
    let with = |vectors: &[u8]| refusal(&rebuilt(&file, |b| b.self_tests = vectors));
    assert_eq!(with(&[]), LoadError::SelfTests);
    assert_eq!(with(&vectors[..vectors.len() - 1]), LoadError::SelfTests);
    assert_eq!(with(&[&vectors[..], &[0]].concat()), LoadError::SelfTests);
    // The first vector has no neighbours: a ninth copy of it is one too many.
    let first = LEN + 2 + 2 * ACTIONS;
    assert_eq!(with(&[&vectors[..], &vectors[..first]].concat()), LoadError::SelfTests);
    for (at, byte, what) in [(LEN, 0, "degree 0"), (LEN, 18, "degree 18"), (LEN + 1, 17, "17 neighbours")] {
        let mut bad = vectors.clone();
        bad[at] = byte;
        assert_eq!(with(&bad), LoadError::SelfTests, "{what}");
    }
}

#[test]
fn a_content_hash_of_other_content_is_refused() {
    let plain = PlainActor::read(&gat());
    for at in [plain.weights_at.start, plain.weights_at.end - 1, plain.tables_at.start] {
        let mut file = gat();
        file[at] ^= 1;
        assert_eq!(refusal(&sealed(file)), LoadError::ContentHash, "byte {at}");
    }
    // The hash itself: its varint ends the body.
    let mut file = gat();
    let last = file.len() - TRAILER - 1;
    file[last] ^= 1;
    assert_eq!(refusal(&sealed(file)), LoadError::ContentHash);
}

/// The file loads, because its envelope and its bounds are right; the self-test sees
/// that it no longer computes what it computed when it was exported.
#[test]
fn a_self_test_that_does_not_hold_names_its_vector() {
    let file = gat();
    let place = PlainActor::read(&file).self_tests_at;
    let broken = |at: usize| {
        let mut file = file.clone();
        file[at] ^= 1;
        sealed(file)
    };
    let logits = 2 * ACTIONS;
    let first = place.start + LEN + 2;
    for (at, vector) in [(first, 0), (first + logits - 1, 0), (place.end - 1, 7), (place.end - logits, 7)] {
        let file = broken(at);
        let error = Actor::load(&file).expect("it loads").self_test().expect_err("it differs");
        assert_eq!(error, SelfTestError { vector }, "byte {at}");
        assert!(error.to_string().contains("do not fly"), "{error}");
    }
    // Another function with a right hash: a bias of the output moved.
    let moved = with_tables(|tables| {
        let at = tables.len() - 8 * ACTIONS;
        for bias in tables[at..at + 4 * ACTIONS].as_chunks_mut().0 {
            *bias = (i32::from_le_bytes(*bias) + 100_000).to_le_bytes();
        }
    });
    assert!(Actor::load(&moved).expect("it loads").self_test().is_err());
}

#[test]
fn provenance_is_no_part_of_the_content() {
    let file = altered(|b| {
        b.provenance.trainer = "someone else";
        b.provenance.int8_coverage = 5600;
    });
    let (actor, original) = (Actor::load(&file).expect("sound"), gat());
    assert_eq!(actor.provenance().trainer, "someone else");
    assert_eq!(actor.content_hash(), Actor::load(&original).expect("sound").content_hash());
    actor.self_test().expect("the same function");
}
