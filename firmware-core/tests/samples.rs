//! The committed sample actors still read and still compute the same, and damaged files
//! are refused.

mod common;

use common::{cells_actor, sample_actor, tiny_actor};
use firmware_core::actor::file::at_start_of;
use firmware_core::actor::{Actor, Aggregation, CellsActor, LoadError, argmax, fingerprint};
use proptest::prelude::*;

const KINDS: [(Aggregation, &str); 5] = [
    (Aggregation::None, "sample-none"),
    (Aggregation::Gcn, "sample-gcn"),
    (Aggregation::Gat, "sample-gat"),
    (Aggregation::GatV2, "sample-gatv2"),
    (Aggregation::Sage, "sample-sage"),
];

fn path(name: &str) -> String {
    format!("{}/tests/data/{name}.actor", env!("CARGO_MANIFEST_DIR"))
}

/// Seeds tell the kinds apart.
fn made(aggregation: Aggregation) -> Vec<u8> {
    sample_actor(aggregation, 1 + aggregation as u64)
}

/// `COVEY_BLESS=1` writes the files anew, after a deliberate change of the format.
#[test]
fn the_committed_files_are_what_this_code_writes() {
    for (aggregation, name) in KINDS {
        let file = made(aggregation);
        if std::env::var_os("COVEY_BLESS").is_some() {
            std::fs::write(path(name), &file).unwrap();
        }
        assert!(std::fs::read(path(name)).unwrap() == file, "{name} differs");
    }
}

/// The fuzz targets fly the first; the second observes cells.
#[test]
fn the_other_committed_files_are_what_this_code_writes() {
    let (tiny, cells) = (tiny_actor(Aggregation::Gat, 3), cells_actor(Aggregation::Gcn, 4));
    for (file, name) in [(&tiny, "tiny-gat"), (&cells, "cells-gcn")] {
        if std::env::var_os("COVEY_BLESS").is_some() {
            std::fs::write(path(name), file).unwrap();
        }
        assert!(std::fs::read(path(name)).unwrap() == *file, "{name} differs");
    }
    Actor::load(&tiny).unwrap().self_test().unwrap();
    CellsActor::load(&cells).unwrap().self_test().unwrap();
    assert!(matches!(Actor::load(&cells), Err(LoadError::Observation { found: 100, .. })));
}

#[test]
fn samples_pass_their_self_test_and_differ() {
    let mut signatures: Vec<u64> = KINDS
        .iter()
        .map(|&(aggregation, _)| {
            let file = made(aggregation);
            let actor = Actor::load(&file).unwrap();
            actor.self_test().unwrap();
            fingerprint(&actor, 50)
        })
        .collect();
    signatures.sort_unstable();
    signatures.dedup();
    assert_eq!(signatures.len(), KINDS.len());
}

#[test]
fn samples_are_no_dead_networks() {
    for (aggregation, _) in KINDS {
        let file = made(aggregation);
        let actor = Actor::load(&file).unwrap();
        let mut features = Vec::new();
        let mut actions = Vec::new();
        for k in 0..64u8 {
            let own = actor.encode(&core::array::from_fn(|i| ((i as u8).wrapping_mul(k) as i8).max(-127)));
            features.push(own.values);
            actions.push(argmax(&actor.logits(&own, 1, [])).index());
        }
        features.sort_unstable();
        features.dedup();
        actions.sort_unstable();
        actions.dedup();
        assert!(features.len() > 32 && actions.len() > 2, "{aggregation:?} {actions:?}");
    }
}

#[test]
fn every_cut_and_addition_is_refused() {
    let mut file = made(Aggregation::Gat);
    for len in 0..file.len() {
        assert!(matches!(Actor::load(&file[..len]), Err(LoadError::Truncated { .. })), "{len}");
    }
    file.push(0);
    assert_eq!(Actor::load(&file).err(), Some(LoadError::Extended { extra: 1 }));
}

#[test]
fn a_file_is_found_at_the_start_of_erased_flash() {
    let file = made(Aggregation::Gcn);
    let mut region = file.clone();
    region.resize(1 << 17, 0xff);
    assert!(at_start_of(&region) == file);
    let expected = file.len();
    assert_eq!(Actor::load(at_start_of(&region[..500])).err(), Some(LoadError::Truncated { expected, found: 500 }));
    assert_eq!(Actor::load(at_start_of(&[0xff; 64])).err(), Some(LoadError::NotAnActor));
    assert_eq!(Actor::load(at_start_of(&[])).err(), Actor::load(&[]).err());
}

proptest! {
    #[test]
    fn every_flipped_bit_is_found(at in any::<prop::sample::Index>(), bit in 0..8u8) {
        let mut file = made(Aggregation::Gcn);
        let at = at.index(file.len());
        file[at] ^= 1 << bit;
        prop_assert!(Actor::load(&file).is_err());
    }
}
