//! What the networks see of some world-steps.

use crate::kernel::{padded, unpack};
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
        let values = values[first * step..].chunks_exact_mut(step);
        let masks = masks[first * words..].chunks_exact_mut(words);
        for (observation, (values, masks)) in observations.iter().zip(values.zip(masks)) {
            unpack(&observation[..padded(width)], 1.0 / 127.0, values, masks);
            // What the network does not take.
            values[width..].fill(0.0);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_even() {
        assert_eq!(worlds_in_pass(20, 50), 6);
        assert_eq!(worlds_in_pass(20, 7), 4);
        assert_eq!(worlds_in_pass(1000, 7), 1);
        assert_eq!(worlds_in_pass(20, 0), 1);
    }
}
