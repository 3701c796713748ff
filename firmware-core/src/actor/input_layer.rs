//! The first layer of an actor: it depends on what the actor observes.

use super::layer::{Activations, Layer, LayerError, MAX_INPUTS, MAX_ROWS, Rectified};
use crate::observation::cells::{self, Cells, MAX_ACTIVE, VELOCITY};
use crate::observation::{BuildObservation, LEN, Observation};
use core::fmt::Debug;
use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// A form of the observation that an actor can fly with.
pub trait ActorInput: BuildObservation {
    /// The first layer of an actor with this form, read in place.
    type InputLayer<'a>: Copy + Debug + Send + Sync;
    /// The length, for people.
    const LEN_IN_WORDS: &'static str;

    /// Bytes of weights of a first layer of this many rows.
    fn weight_bytes(rows: usize) -> usize;

    /// Takes a first layer of this many rows off the front of `weights` and `tables`.
    ///
    /// # Errors
    /// [`LayerError`] when they end before it does, or hold a number out of bounds.
    fn take_layer<'a>(
        weights: &mut &'a [u8],
        tables: &mut &'a [u8],
        rows: usize,
    ) -> Result<Self::InputLayer<'a>, LayerError>;

    /// Writes what the first layer makes of this observation: int8, from 0 on.
    fn apply(&self, first: &Self::InputLayer<'_>, out: &mut [i16]);

    /// The bytes of an observation that a self-test vector begins with, and those behind it.
    fn split_bytes(bytes: &[u8]) -> Option<(&[u8], &[u8])>;

    /// The observation of bytes that [`Self::split_bytes`] gave.
    fn from_bytes(bytes: &[u8]) -> Self;

    /// Writes it as [`Self::split_bytes`] reads it, byte by byte, until `put` refuses one.
    fn write_bytes(&self, put: &mut impl FnMut(u8) -> Option<()>) -> Option<()>;

    /// A pseudo-random observation, for fingerprints.
    fn random(random: &mut Xoshiro128PlusPlus) -> Self;
}

impl ActorInput for Observation {
    type InputLayer<'a> = Layer<'a>;
    const LEN_IN_WORDS: &'static str = "160";

    fn weight_bytes(rows: usize) -> usize {
        Layer::weight_bytes(rows, LEN)
    }

    #[inline]
    fn take_layer<'a>(weights: &mut &'a [u8], tables: &mut &'a [u8], rows: usize) -> Result<Layer<'a>, LayerError> {
        Layer::take(weights, tables, rows, LEN)
    }

    #[inline]
    fn apply(&self, first: &Layer<'_>, out: &mut [i16]) {
        let mut x = Activations::<MAX_INPUTS>::zero();
        for (x, &o) in x.0.iter_mut().zip(self) {
            *x = i16::from(o);
        }
        first.apply(&x.0, out);
    }

    #[inline]
    fn split_bytes(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
        bytes.split_at_checked(LEN)
    }

    #[inline]
    fn from_bytes(bytes: &[u8]) -> Self {
        let mut observation = [0; LEN];
        for (o, &b) in observation.iter_mut().zip(bytes) {
            *o = b as i8;
        }
        observation
    }

    fn write_bytes(&self, put: &mut impl FnMut(u8) -> Option<()>) -> Option<()> {
        self.iter().try_for_each(|&o| put(o as u8))
    }

    #[inline]
    fn random(random: &mut Xoshiro128PlusPlus) -> Self {
        let mut observation = [0; LEN];
        // One number in four is zero, as in real observations with absent entries.
        observation.iter_mut().for_each(|o| {
            let r = random.next_u32();
            *o = if r & 3 == 0 { 0 } else { ((r >> 8) as u8 as i8).max(-127) };
        });
        observation
    }
}

/// Rows that are summed at a time.
const BLOCK: usize = 8;

/// The first layer of an actor that observes cells, read in place: of each number the weights
/// of all rows lie together, so that of the numbers that are zero none is read.
#[derive(Clone, Copy, Debug)]
pub struct SparseLayer<'a> {
    /// Weights in blocks of rows, as many blocks a number as hold all rows.
    blocks: &'a [[u8; BLOCK]],
    biases: &'a [[u8; 4]],
    multipliers: &'a [[u8; 4]],
}

impl SparseLayer<'_> {
    fn add(&self, sums: &mut [i32; BLOCK], number: usize, block: usize, times: i32) {
        let at = number * self.biases.len().div_ceil(BLOCK) + block;
        if let Some(weights) = self.blocks.get(at) {
            for (sum, &w) in sums.iter_mut().zip(weights) {
                *sum += times * i32::from(w as i8);
            }
        }
    }
}

impl ActorInput for Cells {
    type InputLayer<'a> = SparseLayer<'a>;
    const LEN_IN_WORDS: &'static str = "1116";

    fn weight_bytes(rows: usize) -> usize {
        cells::LEN * rows.next_multiple_of(BLOCK)
    }

    fn take_layer<'a>(
        weights: &mut &'a [u8],
        tables: &mut &'a [u8],
        rows: usize,
    ) -> Result<SparseLayer<'a>, LayerError> {
        let (own, rest) = weights.split_at_checked(Self::weight_bytes(rows)).ok_or(LayerError::Short)?;
        *weights = rest;
        let Rectified { biases, multipliers } = Rectified::take(tables, rows)?;
        Ok(SparseLayer { blocks: own.as_chunks().0, biases, multipliers })
    }

    // With at most 120 ones and two velocities a sum is within 122·127² < 2²¹, and the biased
    // one within 2²⁵.
    fn apply(&self, first: &SparseLayer<'_>, out: &mut [i16]) {
        let tables = first.biases.chunks(BLOCK).zip(first.multipliers.chunks(BLOCK));
        for (block, (out, (biases, multipliers))) in out.chunks_mut(BLOCK).zip(tables).enumerate() {
            let mut sums = [0; BLOCK];
            for &one in self.active() {
                first.add(&mut sums, usize::from(one), block, 1);
            }
            sums = sums.map(|s| 127 * s);
            for (k, v) in self.velocity().into_iter().enumerate() {
                first.add(&mut sums, VELOCITY + k, block, i32::from(v));
            }
            for ((y, sum), (&b, &m)) in out.iter_mut().zip(sums).zip(biases.iter().zip(multipliers)) {
                *y = Rectified::finish(sum, b, m);
            }
        }
    }

    fn split_bytes(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
        let count = usize::from(*bytes.first()?);
        let (own, rest) = bytes.split_at_checked(3 + 2 * count)?;
        let read = Self::from_bytes(own);
        // Whatever a list may not hold is left out there.
        (count <= MAX_ACTIVE && read.active().len() == count).then_some((own, rest))
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        match bytes {
            &[_, x, y, ref ones @ ..] => {
                Self::new([x as i8, y as i8], ones.as_chunks().0.iter().map(|&b| u16::from_le_bytes(b)))
            }
            _ => Self::ZERO,
        }
    }

    fn write_bytes(&self, put: &mut impl FnMut(u8) -> Option<()>) -> Option<()> {
        let [x, y] = self.velocity();
        put(self.active().len() as u8)?;
        put(x as u8)?;
        put(y as u8)?;
        self.active().iter().flat_map(|one| one.to_le_bytes()).try_for_each(put)
    }

    fn random(random: &mut Xoshiro128PlusPlus) -> Self {
        let mut below = |n: usize| ((u64::from(random.next_u32()) * n as u64) >> 32) as usize;
        let velocity = [below(255), below(255)].map(|v| (v as i32 - 127) as i8);
        let count = below(MAX_ACTIVE + 1);
        // Past the two velocities.
        let ones = (0..count).map(|_| below(cells::LEN - 2)).map(|i| if i < VELOCITY { i } else { i + 2 });
        Self::new(velocity, ones.map(|i| i as u16))
    }
}

const _: () = assert!(LEN <= MAX_INPUTS && MAX_ROWS.is_multiple_of(BLOCK));

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use rand_xoshiro::rand_core::SeedableRng;
    use std::vec::Vec;

    fn noise(k: usize) -> u8 {
        ((k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as u8
    }

    /// Every number of the observation times its weight.
    #[test]
    fn a_sparse_layer_is_the_dense_layer() {
        for rows in [1usize, 2, 8, 13, 128] {
            let stride = rows.next_multiple_of(8);
            let weights: Vec<u8> = (0..1116 * stride).map(noise).collect();
            let bias = |r: usize| (i32::from(noise(r)) - 128) * 3000;
            let multiplier = |r: usize| 90_000 + 1_000 * r as i32;
            let tables: Vec<u8> =
                (0..rows).map(bias).chain((0..rows).map(multiplier)).flat_map(i32::to_le_bytes).collect();
            let (mut w, mut t) = (&weights[..], &tables[..]);
            let layer = Cells::take_layer(&mut w, &mut t, rows).unwrap();
            assert!(w.is_empty() && t.is_empty());
            for seed in 0..20 {
                let cells = Cells::random(&mut Xoshiro128PlusPlus::seed_from_u64(seed));
                let mut out = [-1i16; MAX_ROWS];
                cells.apply(&layer, &mut out);
                for (r, &out) in out.iter().enumerate().take(rows) {
                    let weight = |i: usize| i64::from(weights[i * stride + r] as i8);
                    let [x, y] = cells.velocity().map(i64::from);
                    let ones: i64 = cells.active().iter().map(|&i| 127 * weight(i.into())).sum();
                    let sum = ones + x * weight(24) + y * weight(25) + i64::from(bias(r));
                    let scaled = (sum * i64::from(multiplier(r)) + (1 << 31)) >> 32;
                    assert_eq!(i64::from(out), scaled.clamp(0, 127), "row {r} of {rows}");
                }
                assert!(out[rows..].iter().all(|&o| o == -1), "{rows} rows");
            }
        }
    }

    #[test]
    fn what_is_written_is_read() {
        for seed in 0..50 {
            let cells = Cells::random(&mut Xoshiro128PlusPlus::seed_from_u64(seed));
            let mut bytes = Vec::new();
            cells.write_bytes(&mut |b| {
                bytes.push(b);
                Some(())
            });
            bytes.push(9);
            let (own, rest) = Cells::split_bytes(&bytes).unwrap();
            assert_eq!((Cells::from_bytes(own), rest), (cells, &[9][..]));
        }
        assert!(Cells::split_bytes(&[]).is_none() && Cells::split_bytes(&[1, 0, 0, 5]).is_none(), "cut short");
        assert!(Cells::split_bytes(&[1, 0, 0, VELOCITY as u8, 0]).is_none(), "a velocity is no one");
        assert!(Cells::split_bytes(&[1, 0, 0, 0xff, 0xff]).is_none(), "no such number");
        assert!(Cells::split_bytes(&[121; 300]).is_none(), "too many");
    }
}
