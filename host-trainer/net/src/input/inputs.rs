//! Observations and neighbours of a micro-batch.

use super::multi_hot::MultiHotRows;
use crate::kernel::{dequantise, padded};
use crate::matrix::Rows;
use covey_env::{Neighbourhood, ObservationForm, ObservationSlice};
use firmware_core::observation::{LEN, Observation};

/// Samples of a micro-batch, at most: few enough that what a pass touches stays in a core's
/// second-level cache, enough that weights are not fetched too often. Measured.
const MICRO_BATCH: usize = 128;

/// World-steps to a micro-batch when there are `total` of `uavs` UAVs each.
#[must_use]
pub fn micro_batch_size(uavs: usize, total: usize) -> usize {
    let most = (MICRO_BATCH / uavs.max(1)).max(1);
    // As even as can be: a last one of a few samples would cost nearly as much as a full one.
    let count = total.div_ceil(most).max(1);
    total.div_ceil(count).max(1)
}

/// The micro-batch that networks take: observations and neighbours of some world-steps of N UAVs
/// each, a row a UAV.
#[derive(Clone, Debug)]
pub struct Inputs {
    uavs: usize,
    rows: InputRows,
    neighbours: Vec<Neighbourhood>,
}

/// What the input layer takes, a row a UAV.
#[derive(Clone, Debug)]
pub enum InputRows {
    /// Compact observations over 127.
    Dense(Rows),
    /// Observations in cells.
    MultiHot(MultiHotRows),
}

impl Inputs {
    /// Empty, for networks that take the first `width` numbers of a compact observation.
    ///
    /// # Panics
    /// When an observation has not so many.
    #[must_use]
    pub fn new(width: usize) -> Self {
        assert!(width <= LEN, "an observation has {LEN} numbers, not {width}");
        Self { uavs: 1, rows: InputRows::Dense(Rows::new(width)), neighbours: Vec::new() }
    }

    /// Empty, for networks that take whole observations of this form.
    #[must_use]
    pub fn of(form: ObservationForm) -> Self {
        match form {
            ObservationForm::Compact => Self::new(LEN),
            ObservationForm::Cells => {
                Self { uavs: 1, rows: InputRows::MultiHot(MultiHotRows::new(form.len())), neighbours: Vec::new() }
            }
        }
    }

    /// Removes all world-steps; those to come are of `uavs` UAVs each.
    pub fn clear(&mut self, uavs: usize) {
        self.uavs = uavs;
        match &mut self.rows {
            InputRows::Dense(rows) => rows.resize(0),
            InputRows::MultiHot(rows) => rows.clear(),
        }
        self.neighbours.clear();
    }

    /// Adds world-steps: an observation and the neighbours of every UAV.
    ///
    /// # Panics
    /// When they are not whole world-steps, or of another form than these inputs.
    pub fn push<'s>(&mut self, observations: impl Into<ObservationSlice<'s>>, neighbours: &[Neighbourhood]) {
        let before = self.neighbours.len();
        self.neighbours.extend_from_slice(neighbours);
        let count = match (&mut self.rows, observations.into()) {
            (InputRows::Dense(rows), ObservationSlice::Compact(all)) => {
                push_dense(rows, before, all);
                all.len()
            }
            (InputRows::MultiHot(rows), ObservationSlice::Cells(all)) => {
                all.iter().for_each(|cells| rows.push(cells));
                all.len()
            }
            _ => panic!("observations of another form than the network's"),
        };
        assert!(count == neighbours.len() && count.is_multiple_of(self.uavs), "whole world-steps");
    }

    /// What the input layer takes.
    pub(crate) const fn rows(&self) -> &InputRows {
        &self.rows
    }

    /// UAVs in a world.
    #[must_use]
    pub const fn uavs(&self) -> usize {
        self.uavs
    }

    /// The kept neighbours of each UAV, as indices into its world.
    #[must_use]
    pub fn neighbours(&self) -> &[Neighbourhood] {
        &self.neighbours
    }
}

/// Adds compact observations behind the first `before` rows.
fn push_dense(rows: &mut Rows, before: usize, observations: &[Observation]) {
    rows.resize(before + observations.len());
    let (stride, width, words) = (rows.stride(), rows.width(), rows.words());
    let (values, masks) = rows.values_and_masks_mut();
    let values = values[before * stride..].chunks_exact_mut(stride);
    let masks = masks[before * words..].chunks_exact_mut(words);
    for (observation, (values, masks)) in observations.iter().zip(values.zip(masks)) {
        dequantise(&observation[..padded(width)], 1.0 / 127.0, values, masks);
        // What the network does not take.
        values[width..].fill(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn micro_batches_are_even() {
        assert_eq!(micro_batch_size(20, 50), 6);
        assert_eq!(micro_batch_size(20, 7), 4);
        assert_eq!(micro_batch_size(1000, 7), 1);
        assert_eq!(micro_batch_size(20, 0), 1);
    }
}
