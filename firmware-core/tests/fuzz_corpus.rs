//! Runs the fuzz targets' checks on the stable compiler: over their corpus, so that what they
//! once found stays fixed, and over twenty thousand inputs each made of it.

#[path = "../../fuzz/checks.rs"]
mod checks;
mod common;
#[path = "../../fuzz/made_inputs.rs"]
mod made_inputs;

use common::{cells_actor, tiny_actor};
use firmware_core::actor::{Actor, Aggregation};
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, MAX_LEN, Message};
use firmware_core::neighbour_table::Moment;
use firmware_core::pil::{Hear, MAX_REQUEST, Observe, Request, Setup};
use made_inputs::{corpus, run};
use std::fs;

#[test]
fn actor_files() {
    run("actor_file", checks::actor_file);
}

#[test]
fn neighbour_messages() {
    run("neighbour_message", checks::neighbour_message);
}

#[test]
fn pil_frames() {
    run("pil", checks::pil);
}

const NOW: Moment = Moment { step: 3, time_ms: 6000 };

fn message_bytes(message: &Message) -> Vec<u8> {
    message.encode(&mut [0; MAX_LEN]).to_vec()
}

fn beacon(id: u16, sequence: u16, time_ms: u32) -> Vec<u8> {
    let state = State { position: Vec2 { x: 2000 * i32::from(id), y: 500 }, velocity: Vec2 { x: 900, y: -4000 } };
    message_bytes(&Message::Beacon(Beacon::new(Header { id, sequence, step: 3 }, time_ms, state, 5)))
}

fn feature(id: u16, actor: u32) -> Vec<u8> {
    let header = Header { id, sequence: 1, step: 3 };
    message_bytes(&Message::Feature(FeatureMessage::new(header, 3, actor, -9, &[100, 7]).unwrap()))
}

/// Records of `checks::neighbour_message`.
fn heard(messages: &[Vec<u8>]) -> Vec<u8> {
    messages.iter().flat_map(|m| [&[0xc0, 0x05, m.len() as u8][..], m].concat()).collect()
}

/// Records of `checks::pil`.
fn asked(requests: &[Request<'_>]) -> Vec<u8> {
    let mut out = Vec::new();
    for request in requests {
        let record = postcard::to_slice(request, &mut [0; MAX_REQUEST]).unwrap().to_vec();
        out.extend((record.len() as u16 | 0x8000).to_le_bytes());
        out.extend(record);
    }
    out.extend([5, 0, 0, 3, 1, 1, 0]);
    out
}

/// `COVEY_BLESS=1 cargo test -p firmware-core --test fuzz_corpus` writes the first inputs
/// anew, from which the fuzzer starts.
#[test]
fn seeds_are_what_this_code_writes() {
    let tiny = tiny_actor(Aggregation::Gat, 3);
    let hash = Actor::load(&tiny).unwrap().message_hash();
    let wide = FeatureMessage::new(Header::default(), 1, 9, 4, &[-1; 64]).unwrap();
    let mut crowd: Vec<_> = (1..20).map(|id| beacon(id, 0, 1472 * u32::from(id))).collect();
    crowd.push(feature(19, 0x0101_0101));
    let hear = |message| Request::Hear(Hear { now: NOW, position: [0; 2], message });
    let (near, far, heard_feature) = (beacon(4, 1, 6000), beacon(5, 1, 4000), feature(4, hash));
    let observe = Observe { now: NOW, position: [9000, 900], velocity: [4096, 0], pois: &[0, 8, 0, 252, 0, 20, 0, 9] };
    let setup = Setup { id: 9, seed: 77, argmax: true, step_ms: 1000, half_side: 50_000 };
    let flight = [
        hear(&near),
        hear(&far),
        Request::Observe(observe),
        hear(&heard_feature),
        Request::Decide { step: 3 },
        Request::Status,
        Request::Hello(setup),
        Request::Sign { from: 0, cases: 1 },
    ];
    let seeds = [
        ("actor_file", "tiny-none", tiny_actor(Aggregation::None, 1)),
        ("actor_file", "tiny-gcn", tiny_actor(Aggregation::Gcn, 2)),
        ("actor_file", "tiny-gat", tiny),
        ("actor_file", "tiny-gatv2", tiny_actor(Aggregation::GatV2, 5)),
        ("actor_file", "tiny-sage", tiny_actor(Aggregation::Sage, 6)),
        ("actor_file", "cells-gcn", cells_actor(Aggregation::Gcn, 4)),
        ("neighbour_message", "beacon", beacon(7, 65_535, 84_000)),
        ("neighbour_message", "wide-feature", message_bytes(&Message::Feature(wide))),
        ("neighbour_message", "crowd", heard(&crowd)),
        ("neighbour_message", "jump", heard(&[beacon(1, 0, 1472), beacon(9, 1, 2944), beacon(9, 2, 4416)])),
        ("pil", "flight", asked(&flight)),
        ("pil", "status", asked(&[Request::Status, Request::SelfTest])),
    ];
    for (target, name, bytes) in seeds {
        let path = corpus(target).join(name);
        if std::env::var_os("COVEY_BLESS").is_some() {
            fs::create_dir_all(corpus(target)).unwrap();
            fs::write(&path, &bytes).unwrap();
        }
        assert!(fs::read(&path).unwrap() == bytes, "{} differs", path.display());
    }
}
