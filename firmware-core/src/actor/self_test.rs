//! Self-test vectors: situations with their exact logits, kept in the actor file.
//!
//! A vector is, one after the other: the observation (160 int8; in cells the number of ones
//! as u8, two velocities as int8, and the index of each one as u16 little-endian), own degree (u8),
//! number k of neighbours (u8, at most 16), k times [degree (u8), attention_source score (i16
//! little-endian), feature (int8 × feature width)], and 17 logits (i16 little-endian).

use super::feature::{MAX_DEGREE, NeighbourFeature};
use super::input_layer::ActorInput;
use super::quantised::QuantisedActor;
use super::softmax::Logits;
use crate::action::ACTIONS;
use crate::observation::{MAX_NEIGHBOURS, Observation};
use core::marker::PhantomData;
use thiserror::Error;

/// Vectors in every actor file.
pub const SELF_TESTS: usize = 8;

/// The actor does not compute what it computed when it was exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "self-test vector {vector} of the actor gives other logits than when it was exported: do not fly; check the build and the memory"
)]
pub struct SelfTestError {
    /// The first vector that differs.
    pub vector: usize,
}

/// One vector, read in place.
#[derive(Clone, Copy, Debug)]
pub struct SelfTest<'a, O: ActorInput = Observation> {
    observation: &'a [u8],
    form: PhantomData<O>,
    degree: u8,
    neighbours: &'a [u8],
    feature: usize,
    logits: &'a [u8; 2 * ACTIONS],
}

/// Bytes of a neighbour before its feature.
const NEIGHBOUR_HEAD: usize = 3;

impl<'a, O: ActorInput> SelfTest<'a, O> {
    fn take(bytes: &mut &'a [u8], feature: usize) -> Option<Self> {
        let (observation, rest) = O::split_bytes(bytes)?;
        let (&[degree, count], rest) = rest.split_first_chunk::<2>()?;
        if !(1..=MAX_DEGREE).contains(&degree) || usize::from(count) > MAX_NEIGHBOURS {
            return None;
        }
        let (neighbours, rest) = rest.split_at_checked(usize::from(count) * (NEIGHBOUR_HEAD + feature))?;
        let (logits, rest) = rest.split_first_chunk::<{ 2 * ACTIONS }>()?;
        *bytes = rest;
        Some(Self { observation, form: PhantomData, degree, neighbours, feature, logits })
    }

    fn holds(&self, actor: &QuantisedActor<'_, O>) -> bool {
        let own = actor.encode(&O::from_bytes(self.observation));
        let neighbours =
            self.neighbours.chunks_exact((NEIGHBOUR_HEAD + self.feature).max(1)).map(|record| match record {
                &[degree, low, high, ref feature @ ..] => NeighbourFeature {
                    values: bytemuck::try_cast_slice(feature).unwrap_or_default(),
                    degree,
                    attention_source: i16::from_le_bytes([low, high]),
                },
                _ => NeighbourFeature { values: &[], degree: 1, attention_source: 0 },
            });
        let logits = actor.logits(&own, self.degree, neighbours);
        logits.iter().zip(self.logits.chunks_exact(2)).all(|(l, b)| l.to_le_bytes() == *b)
    }
}

/// The vectors in `bytes`, up to the first that cannot be read.
pub(super) fn vectors<O: ActorInput>(bytes: &[u8], feature: usize) -> impl Iterator<Item = SelfTest<'_, O>> {
    let mut rest = bytes;
    core::iter::from_fn(move || SelfTest::take(&mut rest, feature))
}

/// Bytes that [`SELF_TESTS`] vectors take, if there are as many.
pub(super) fn length<O: ActorInput>(bytes: &[u8], feature: usize) -> Option<usize> {
    let mut rest = bytes;
    for _ in 0..SELF_TESTS {
        SelfTest::<O>::take(&mut rest, feature)?;
    }
    Some(bytes.len() - rest.len())
}

/// Writes one vector into `out` and returns its length; `None` when it does not fit,
/// or when there are more than 16 neighbours.
pub fn write_self_test<O: ActorInput>(
    out: &mut [u8],
    observation: &O,
    degree: u8,
    neighbours: &[NeighbourFeature<'_>],
    logits: &Logits,
) -> Option<usize> {
    if neighbours.len() > MAX_NEIGHBOURS {
        return None;
    }
    let mut at = 0;
    let mut put = |byte: u8| {
        *out.get_mut(at)? = byte;
        at += 1;
        Some(())
    };
    observation.write_bytes(&mut put)?;
    put(degree)?;
    put(neighbours.len() as u8)?;
    for n in neighbours {
        put(n.degree)?;
        n.attention_source.to_le_bytes().into_iter().try_for_each(&mut put)?;
        n.values.iter().try_for_each(|&h| put(h as u8))?;
    }
    logits.iter().flat_map(|l| l.to_le_bytes()).try_for_each(put)?;
    Some(at)
}

impl<O: ActorInput> QuantisedActor<'_, O> {
    /// Recomputes the file's self-test vectors. An actor that fails must not fly.
    ///
    /// # Errors
    /// The first vector whose logits differ.
    pub fn self_test(&self) -> Result<(), SelfTestError> {
        let vectors = vectors(self.self_tests, usize::from(self.dimensions.feature));
        for (vector, test) in vectors.enumerate() {
            if !test.holds(self) {
                return Err(SelfTestError { vector });
            }
        }
        Ok(())
    }
}
