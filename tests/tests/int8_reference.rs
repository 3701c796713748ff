//! The on-board actor against the network written down in 64-bit integers, bit by bit.

mod plain_actor;

use firmware_core::action::ACTIONS;
use firmware_core::actor::file::Body;
use firmware_core::actor::layer::{Layer, MAX_BIAS};
use firmware_core::actor::{
    Actor, Aggregation, Dimensions, Logits, NeighbourFeature, Provenance, SELF_TESTS, argmax, sample, write_self_test,
};
use firmware_core::observation::{self, LEN, Observation};
use plain_actor::{PlainActor, PlainNeighbour, power};
use proptest::collection::vec;
use proptest::prelude::*;
use std::path::Path;

const SAMPLES: [&str; 5] = ["sample-none", "sample-gcn", "sample-gat", "sample-gatv2", "sample-sage"];

fn committed(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware-core/tests/data");
    std::fs::read(folder.join(format!("{name}.actor"))).expect("a committed sample actor")
}

/// More neighbours than count, with any feature that a message can carry.
fn neighbours(width: usize) -> impl Strategy<Value = Vec<PlainNeighbour>> {
    let one = (vec(any::<i8>(), width), 1..=17u8, prop_oneof![any::<i16>(), -600..600i16])
        .prop_map(|(values, degree, attention_source)| PlainNeighbour { values, degree, attention_source });
    vec(one, 0..20)
}

fn observation() -> impl Strategy<Value = Observation> {
    vec(prop_oneof![3 => -127..=127i8, 1 => Just(0)], LEN).prop_map(|o| o.try_into().expect("LEN numbers"))
}

/// One decision, by both.
fn check(
    file: &[u8],
    observation: &Observation,
    degree: u8,
    neighbours: &[PlainNeighbour],
) -> Result<(), TestCaseError> {
    let (actor, plain) = (Actor::load(file).expect("a sound actor"), PlainActor::read(file));
    let own = actor.encode(observation);
    let feature = plain.encode(observation);
    for (found, written) in [(&own.own, &feature.own), (&own.values, &feature.values)] {
        let found: Vec<i64> = found.iter().map(|&v| v.into()).collect();
        prop_assert_eq!(&found[..written.len()], &written[..]);
        prop_assert!(found[written.len()..].iter().all(|&v| v == 0));
    }
    prop_assert_eq!([own.attention_destination, own.attention_source].map(i64::from), feature.halves);
    let heard = neighbours.iter().map(|n| NeighbourFeature {
        values: &n.values,
        degree: n.degree,
        attention_source: n.attention_source,
    });
    let logits = actor.logits(&own, degree, heard).map(i64::from);
    prop_assert_eq!(&logits[..], &plain.logits(observation, degree, neighbours)[..]);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn committed_actors_compute_what_is_written_down(
        observation in observation(),
        degree in 1..=17u8,
        neighbours in neighbours(16),
    ) {
        for name in SAMPLES {
            check(&committed(name), &observation, degree, &neighbours)?;
        }
    }
}

/// Widths that a file may have, odd ones too, and numbers up to their bounds.
#[derive(Clone, Debug)]
struct Recipe {
    aggregation: Aggregation,
    dimensions: Dimensions,
    weights: Vec<u8>,
    tables: Vec<u8>,
    aggregate_multiplier: i32,
}

fn recipe() -> impl Strategy<Value = Recipe> {
    let widths = (1..=128u16, (1..=32u16).prop_map(|h| 2 * h), 1..=128u16);
    (prop::sample::select(&Aggregation::ALL[..]), widths).prop_flat_map(|(aggregation, (hidden, feature, head))| {
        let dimensions = Dimensions { observation: LEN as u16, hidden, feature, head, actions: ACTIONS as u16 };
        let shapes: Vec<_> = dimensions.layers(aggregation).collect();
        let weights = shapes.iter().map(|&(r, c)| Layer::weight_bytes(r, c)).sum::<usize>();
        let tables = shapes.iter().map(|&(rows, _)| table(rows)).collect::<Vec<_>>();
        // Extremes among the weights: 0xff and 0x00 are −1, 0 in a first row, 127, −128 in a second.
        let weight = prop_oneof![4 => any::<u8>(), 1 => prop::sample::select(vec![0u8, 0x7f, 0x80, 0xff])];
        let multiplier = prop_oneof![Just(0), 1..=1 << 20, Just(i32::MAX)];
        (vec(weight, weights), tables, multiplier).prop_map(move |(weights, tables, aggregate_multiplier)| Recipe {
            aggregation,
            dimensions,
            weights,
            tables: tables.concat(),
            aggregate_multiplier,
        })
    })
}

/// Biases and multipliers of a layer: usual ones, and now and then the greatest.
fn table(rows: usize) -> impl Strategy<Value = Vec<u8>> {
    let bias = prop_oneof![6 => -2000..2000i32, 1 => -MAX_BIAS..=MAX_BIAS, 1 => Just(MAX_BIAS), 1 => Just(-MAX_BIAS)];
    let multiplier = prop_oneof![8 => 1_000_000..20_000_000i32, 1 => 0..=i32::MAX, 1 => Just(i32::MAX), 1 => Just(0)];
    (vec(bias, rows), vec(multiplier, rows))
        .prop_map(|(b, m)| b.into_iter().chain(m).flat_map(i32::to_le_bytes).collect())
}

impl Recipe {
    fn file(&self) -> Vec<u8> {
        // Any readable vectors will do: nobody runs them here.
        let mut vector = [0; 512];
        let n = write_self_test(&mut vector, &[0; LEN], 1, &[], &[0; ACTIONS]).expect("room");
        let body = Body {
            align: &[],
            weights: &self.weights,
            tables: &self.tables,
            observation: observation::ID,
            aggregation: self.aggregation,
            dimensions: self.dimensions,
            tie_period: 1,
            aggregate_multiplier: self.aggregate_multiplier,
            provenance: Provenance::default(),
            self_tests: &vector[..n].repeat(SELF_TESTS),
            content_hash: 0,
        };
        let mut file = vec![0; self.weights.len() + self.tables.len() + 4096];
        let n = body.store(&mut file).expect("room");
        file.truncate(n);
        file
    }
}

proptest! {
    #![proptest_config(ProptestConfig { max_shrink_iters: 200, ..ProptestConfig::with_cases(150) })]

    #[test]
    fn any_actor_that_loads_computes_what_is_written_down(
        recipe in recipe(),
        observation in observation(),
        degree in 1..=17u8,
        around in neighbours(64),
    ) {
        let mut around = around;
        around.iter_mut().for_each(|n| n.values.truncate(usize::from(recipe.dimensions.feature)));
        check(&recipe.file(), &observation, degree, &around)?;
    }

    #[test]
    fn actions_are_drawn_as_written_down(
        logits in proptest::array::uniform17(prop_oneof![any::<i16>(), -500..500i16]),
        draw: u32,
    ) {
        let logits: Logits = logits;
        let top = logits.iter().max().map_or(0, |&l| i64::from(l));
        let weights: Vec<i64> = logits.iter().map(|&l| power(top - i64::from(l))).collect();
        let place = (i128::from(draw) * i128::from(weights.iter().sum::<i64>())) >> 32;
        let ends = weights.iter().scan(0, |end, w| { *end += i128::from(*w); Some(*end) });
        let drawn = ends.take_while(|&end| end <= place).count();
        prop_assert_eq!(usize::from(sample(&logits, draw).index()), drawn);
        let first = logits.iter().position(|&l| i64::from(l) == top);
        prop_assert_eq!(Some(usize::from(argmax(&logits).index())), first);
    }
}
