//! What the networks see of some world-steps.

use crate::kernel::{Vectorised, vectorised};
use crate::matrix::Rows;
use covey_env::Links;
use firmware_core::observation::{LEN, Observation};

/// Samples of a pass: few enough that what it touches stays in a core's second-level
/// cache, enough that weights are not fetched too often. Measured.
const PASS: usize = 128;

/// World-steps to a pass when there are `total` of `uavs` UAVs each.
#[must_use]
pub fn worlds_in_pass(uavs: usize, total: usize) -> usize {
    let most = (PASS / uavs.max(1)).max(1);
    // As even as can be: a last pass of a few samples would cost nearly as much as a full one.
    let passes = total.div_ceil(most).max(1);
    total.div_ceil(passes).max(1)
}

/// Observations and links of some world-steps of N UAVs each.
#[derive(Clone, Debug)]
pub struct Inputs {
    uavs: usize,
    rows: Rows,
    links: Vec<Links>,
}

impl Inputs {
    /// For networks that take the first `width` numbers of an observation; none yet.
    ///
    /// # Panics
    /// When an observation has not so many.
    #[must_use]
    pub fn new(width: usize) -> Self {
        assert!(width <= LEN, "an observation has {LEN} numbers, not {width}");
        Self { uavs: 1, rows: Rows::new(width), links: Vec::new() }
    }

    /// Begins anew, with worlds of `uavs` UAVs.
    pub fn clear(&mut self, uavs: usize) {
        self.uavs = uavs;
        self.rows.resize(0);
        self.links.clear();
    }

    /// Adds world-steps: an observation and the neighbours of every UAV.
    ///
    /// # Panics
    /// When they are not whole world-steps.
    pub fn push(&mut self, observations: &[Observation], links: &[Links]) {
        assert!(observations.len() == links.len() && links.len().is_multiple_of(self.uavs), "whole world-steps");
        let first = self.rows.rows();
        self.rows.resize(first + observations.len());
        self.links.extend_from_slice(links);
        let (step, width) = (self.rows.step(), self.rows.width());
        let words = width.div_ceil(64);
        let (values, masks) = self.rows.parts_mut();
        let (values, masks) = (&mut values[first * step..], &mut masks[first * words..]);
        vectorised(Unpack { observations, width, step, values, words, masks });
    }

    /// Observations over 127, a row a UAV.
    #[must_use]
    pub const fn rows(&self) -> &Rows {
        &self.rows
    }

    /// UAVs in a world.
    #[must_use]
    pub const fn uavs(&self) -> usize {
        self.uavs
    }

    /// Neighbours, UAV by UAV.
    #[must_use]
    pub fn links(&self) -> &[Links] {
        &self.links
    }
}

/// Bytes to floats over 127, with marks.
struct Unpack<'a> {
    observations: &'a [Observation],
    width: usize,
    step: usize,
    values: &'a mut [f32],
    words: usize,
    masks: &'a mut [u64],
}

impl Vectorised for Unpack<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        const SCALE: f32 = 1.0 / 127.0;
        let rows = self.values.chunks_exact_mut(self.step).zip(self.masks.chunks_exact_mut(self.words));
        for (observation, (row, masks)) in self.observations.iter().zip(rows) {
            masks.fill(0);
            let (eights, _) = observation.as_chunks::<8>();
            for (k, (part, eight)) in row.chunks_exact_mut(8).zip(eights).enumerate() {
                part.iter_mut().zip(eight).for_each(|(x, &o)| *x = f32::from(o) * SCALE);
                masks[k / 8] |= not_zero(*eight) << (8 * (k % 8));
            }
            // Numbers that the network does not take.
            row[self.width..].fill(0.0);
            if !self.width.is_multiple_of(64) {
                masks[self.words - 1] &= (1 << (self.width % 64)) - 1;
            }
        }
    }
}

/// Bit k: whether byte k is not zero.
#[inline(always)]
fn not_zero(bytes: [i8; 8]) -> u64 {
    const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
    let w = u64::from_le_bytes(bytes.map(|b| b as u8));
    // The top bit of each byte that is not zero, moved to its lowest; the product gathers
    // these in the top byte.
    let bits = ((((w & LOW) + LOW) | w) & !LOW) >> 7;
    bits.wrapping_mul(0x0102_0408_1020_4080) >> 56
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bytes_that_are_not_zero_are_found(bytes in proptest::array::uniform8(prop_oneof![Just(0i8), any::<i8>()])) {
            let expected = bytes.iter().enumerate().fold(0, |m, (k, &b)| m | u64::from(b != 0) << k);
            prop_assert_eq!(not_zero(bytes), expected);
        }
    }

    #[test]
    fn passes_are_even() {
        assert_eq!(worlds_in_pass(20, 50), 6);
        assert_eq!(worlds_in_pass(20, 7), 4);
        assert_eq!(worlds_in_pass(1000, 7), 1);
        assert_eq!(worlds_in_pass(20, 0), 1);
    }
}
