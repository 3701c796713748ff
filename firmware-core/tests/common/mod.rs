//! A small actor with pseudo-random weights, for tests. It flies nowhere in particular.
#![allow(dead_code)] // Each test takes what it needs.

use firmware_core::action::ACTIONS;
use firmware_core::actor::file::Body;
use firmware_core::actor::layer::Layer;
use firmware_core::actor::{
    ActorInput, Aggregation, Dimensions, Logits, NeighbourFeature, Provenance, QuantisedActor, SELF_TESTS,
    write_self_test,
};
use firmware_core::observation::cells::{self, Cells, MAX_ACTIVE, VELOCITY};
use firmware_core::observation::{LEN, Observation};

/// splitmix64: tests need no better, and nothing else that could change under them.
pub struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }

    fn byte(&mut self) -> i8 {
        (self.next() >> 24) as i8
    }
}

/// Widths of the committed samples: small files.
const SMALL: Dimensions =
    Dimensions { observation: LEN as u16, hidden: 24, feature: 16, head: 24, actions: ACTIONS as u16 };

/// An observation for a self-test vector.
pub trait Sampled: ActorInput {
    /// A pseudo-random one.
    fn sampled(random: &mut Random) -> Self;

    /// Weights of a first layer of this many rows.
    fn weights(random: &mut Random, rows: usize) -> Vec<u8> {
        (0..Self::weight_bytes(rows)).map(|_| random.byte() as u8).collect()
    }
}

impl Sampled for Observation {
    fn sampled(random: &mut Random) -> Self {
        core::array::from_fn(|_| random.byte().max(-127))
    }
}

impl Sampled for Cells {
    fn sampled(random: &mut Random) -> Self {
        let velocity = [random.byte(), random.byte()].map(|v| v.max(-127));
        let count = random.next() as usize % (MAX_ACTIVE + 1);
        // Past the two velocities.
        let ones = (0..count).map(|_| random.next() as usize % (cells::LEN - 2));
        Self::new(velocity, ones.map(|i| if i < VELOCITY { i } else { i + 2 } as u16))
    }

    fn weights(random: &mut Random, rows: usize) -> Vec<u8> {
        let padded = rows.next_multiple_of(8);
        (0..Self::weight_bytes(rows)).map(|k| if k % padded < rows { random.byte() as u8 } else { 0 }).collect()
    }
}

/// One self-test vector with the logits that `logits` gives.
fn vector<O: Sampled>(
    random: &mut Random,
    width: u16,
    logits: impl Fn(&O, u8, &[NeighbourFeature<'_>]) -> Logits,
    neighbours: usize,
) -> Vec<u8> {
    let observation = O::sampled(random);
    let heads: Vec<(u8, i16)> =
        (0..neighbours).map(|_| (1 + (random.next() % 17) as u8, i16::from(random.byte()) * 16)).collect();
    let values: Vec<Vec<i8>> = heads.iter().map(|_| (0..width).map(|_| random.byte() & 127).collect()).collect();
    let neighbours: Vec<_> = heads
        .iter()
        .zip(&values)
        .map(|(&(degree, attention_source), values)| NeighbourFeature { values, degree, attention_source })
        .collect();
    let degree = neighbours.len() as u8 + 1;
    let mut out = [0; 2048];
    let n = write_self_test(&mut out, &observation, degree, &neighbours, &logits(&observation, degree, &neighbours));
    out[..n.unwrap()].to_vec()
}

/// A small actor file of this kind; another seed is another policy.
pub fn sample_actor(aggregation: Aggregation, seed: u64) -> Vec<u8> {
    actor_of(SMALL, aggregation, seed)
}

/// A small actor that observes cells. Its hidden rows are no multiple of 8: there is padding.
pub fn cells_actor(aggregation: Aggregation, seed: u64) -> Vec<u8> {
    let dimensions = Dimensions { observation: cells::LEN as u16, hidden: 5, feature: 4, head: 6, ..SMALL };
    made::<Cells>(dimensions, aggregation, seed)
}

/// The smallest actor there can be.
pub fn tiny_actor(aggregation: Aggregation, seed: u64) -> Vec<u8> {
    actor_of(Dimensions { hidden: 1, feature: 2, head: 1, ..SMALL }, aggregation, seed)
}

/// An actor file of any widths.
pub fn actor_of(dimensions: Dimensions, aggregation: Aggregation, seed: u64) -> Vec<u8> {
    made::<Observation>(dimensions, aggregation, seed)
}

fn made<O: Sampled>(dimensions: Dimensions, aggregation: Aggregation, seed: u64) -> Vec<u8> {
    let mut random = Random(seed);
    let (mut weights, mut tables) = (Vec::new(), Vec::new());
    for (k, (rows, columns)) in dimensions.layers(aggregation).enumerate() {
        if k == 0 {
            weights.extend(O::weights(&mut random, rows));
        } else {
            weights.extend((0..Layer::weight_bytes(rows, columns)).map(|_| random.byte() as u8));
        }
        // Multipliers bring a typical sum back into the range of int8.
        tables.extend((0..rows).flat_map(|_| (i32::from(random.byte()) * 8).to_le_bytes()));
        // GATv2's own layers have wide outputs, of 16 times the sum, and no rectifier that halves them.
        let shift = if aggregation == Aggregation::GatV2 && (2..5).contains(&k) { 4 } else { 0 };
        tables.extend((0..rows).flat_map(|_| ((4_000_000 + i32::from(random.byte()) * 8192) >> shift).to_le_bytes()));
    }
    let mut body = Body {
        align: &[],
        weights: &weights,
        tables: &tables,
        observation: O::ID,
        aggregation,
        dimensions,
        tie_period: 4,
        aggregate_multiplier: if aggregation == Aggregation::None { 0 } else { 1 << 17 },
        provenance: Provenance { trainer: "tests", scenario: "none", seed, ..Provenance::default() },
        self_tests: &[],
        content_hash: 0,
    };
    // Twice: the logits come from the actor itself, which first has to load.
    let vectors = |actor: Option<&QuantisedActor<'_, O>>| -> Vec<u8> {
        let mut random = Random(!seed);
        let logits = |o: &O, degree: u8, neighbours: &[NeighbourFeature<'_>]| {
            actor.map_or([0; ACTIONS], |a| a.logits(&a.encode(o), degree, neighbours.iter().copied()))
        };
        (0..SELF_TESTS).flat_map(|k| vector(&mut random, dimensions.feature, logits, 2 * k)).collect()
    };
    let store = |body: &Body<'_>| {
        let mut file = vec![0; 1 << 17];
        let n = body.store(&mut file).unwrap();
        file.truncate(n);
        file
    };
    let blank = vectors(None);
    body.self_tests = &blank;
    let draft = store(&body);
    let known = vectors(Some(&QuantisedActor::load(&draft).unwrap()));
    body.self_tests = &known;
    store(&body)
}
