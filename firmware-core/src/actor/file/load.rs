//! Reading an actor file: every length and bound is checked before the first use.

use super::body::Body;
use super::envelope::{CRC, HEADER, MAGIC, TRAILER, VERSION};
use super::error::LoadError;
use crate::action::ACTIONS;
use crate::actor::aggregation::Aggregation;
use crate::actor::aggregator::Aggregator;
use crate::actor::dimensions::Dimensions;
use crate::actor::feature::MAX_FEATURE;
use crate::actor::input_layer::ActorInput;
use crate::actor::layer::{Layer, MAX_ROWS, even};
use crate::actor::quantised::QuantisedActor;
use crate::actor::self_test::{self, SELF_TESTS};
use crate::observation::{self, cells};

impl<'a, O: ActorInput> QuantisedActor<'a, O> {
    /// Reads an actor file in place. Every length and bound is checked before the first
    /// use; run [`Self::self_test`] next.
    ///
    /// # Errors
    /// The first thing found wrong, see [`LoadError`].
    pub fn load(file: &'a [u8]) -> Result<Self, LoadError> {
        let (body, rest): (Body<'a>, _) =
            postcard::take_from_bytes(open_envelope(file)?).map_err(|_| LoadError::Malformed)?;
        if !rest.is_empty() || body.align.iter().any(|&b| b != 0) {
            return Err(LoadError::Malformed);
        }
        if body.observation != O::ID {
            return Err(LoadError::Observation { found: body.observation, built: O::ID });
        }
        check_dimensions(body.dimensions, O::LEN, O::LEN_IN_WORDS)?;
        let d = body.dimensions;
        let hidden = usize::from(d.hidden);
        let first = (O::weight_bytes(hidden), Layer::table_bytes(hidden));
        let needed = d.layers(body.aggregation).skip(1).fold(first, |(weights, tables), (rows, columns)| {
            (weights + Layer::weight_bytes(rows, columns), tables + Layer::table_bytes(rows))
        });
        if (body.weights.len(), body.tables.len()) != needed {
            return Err(LoadError::Length);
        }
        let (mut weights, mut tables) = (body.weights, body.tables);
        let encoder1 = O::take_layer(&mut weights, &mut tables, hidden)?;
        let mut take = |rows, columns| Layer::take(&mut weights, &mut tables, rows, columns);
        let [feature, head_width] = [d.feature, d.head].map(usize::from);
        let encoder2 = take(feature, hidden)?;
        let aggregator = Aggregator::take(body.aggregation, feature, &mut take)?;
        let joined = if body.aggregation == Aggregation::None { feature } else { 2 * feature };
        let head = take(head_width, joined)?;
        let output = take(usize::from(d.actions), head_width)?;
        if body.aggregate_multiplier < 0 {
            return Err(LoadError::OutOfRange);
        }
        if self_test::vectors::<O>(body.self_tests, feature).count() != SELF_TESTS
            || self_test::length::<O>(body.self_tests, feature) != Some(body.self_tests.len())
        {
            return Err(LoadError::SelfTests);
        }
        if body.content_hash != body.content_hash() {
            return Err(LoadError::ContentHash);
        }
        Ok(Self {
            dimensions: d,
            tie_period: body.tie_period,
            content_hash: body.content_hash,
            provenance: body.provenance,
            self_tests: body.self_tests,
            encoder1,
            encoder2,
            aggregator,
            head,
            output,
            aggregate_multiplier: body.aggregate_multiplier,
        })
    }
}

const _: () = assert!(even(ACTIONS) <= MAX_ROWS);

/// Checks the envelope and returns the body's bytes.
fn open_envelope(file: &[u8]) -> Result<&[u8], LoadError> {
    let smallest = HEADER + TRAILER;
    let short = |expected| LoadError::Truncated { expected, found: file.len() };
    let magic = file.get(..MAGIC.len().min(file.len())).unwrap_or(&[]);
    if !MAGIC.starts_with(magic) {
        return Err(LoadError::NotAnActor);
    }
    let &[_, _, _, _, _, _, _, _, v0, v1, z0, z1, n0, n1, n2, n3] =
        file.first_chunk::<HEADER>().ok_or(short(smallest))?;
    let found = u16::from_le_bytes([v0, v1]);
    if found != VERSION {
        return Err(LoadError::Version { found });
    }
    let n = u32::from_le_bytes([n0, n1, n2, n3]) as usize;
    let expected = n.saturating_add(smallest);
    if file.len() < expected {
        return Err(short(expected));
    }
    if file.len() > expected {
        return Err(LoadError::Extended { extra: file.len() - expected });
    }
    let (content, trailer) = file.split_last_chunk::<TRAILER>().ok_or(short(smallest))?;
    let (found, computed) = (u32::from_le_bytes(*trailer), CRC.checksum(content));
    if found != computed {
        return Err(LoadError::Checksum { found, computed });
    }
    if [z0, z1] != [0, 0] {
        return Err(LoadError::Malformed);
    }
    content.get(HEADER..).ok_or(LoadError::Malformed)
}

// The messages of `check_dimensions` say these numbers.
const _: () =
    assert!(observation::LEN == 160 && cells::LEN == 1116 && MAX_ROWS == 128 && MAX_FEATURE == 64 && ACTIONS == 17);

fn check_dimensions(d: Dimensions, numbers: usize, allowed: &'static str) -> Result<(), LoadError> {
    let refuse = |what, found, allowed| Err(LoadError::Dimension { what, found, allowed });
    let fits = |n: u16, max: usize| n >= 1 && usize::from(n) <= max;
    if usize::from(d.observation) != numbers {
        return refuse("observation length", d.observation, allowed);
    }
    if !fits(d.hidden, MAX_ROWS) {
        return refuse("first hidden width", d.hidden, "1 to 128");
    }
    if !fits(d.feature, MAX_FEATURE) || !d.feature.is_multiple_of(2) {
        return refuse("feature width", d.feature, "even, 2 to 64");
    }
    if !fits(d.head, MAX_ROWS) {
        return refuse("head width", d.head, "1 to 128");
    }
    if usize::from(d.actions) != ACTIONS {
        return refuse("number of actions", d.actions, "17");
    }
    Ok(())
}
