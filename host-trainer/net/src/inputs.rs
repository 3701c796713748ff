//! What the networks see of some world-steps.

use crate::active::ActiveRows;
use crate::kernel::{padded, unpack};
use crate::matrix::Rows;
use covey_env::{Neighbourhood, ObservationForm, ObservationSlice};
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
    seen: InputRows,
    links: Vec<Neighbourhood>,
}

/// What the first layer takes, a row a UAV.
#[derive(Clone, Debug)]
pub enum InputRows {
    /// Compact observations over 127.
    Numbers(Rows),
    /// Observations in cells.
    Active(ActiveRows),
}

impl Inputs {
    /// For networks that take the first `width` numbers of an observation; none yet.
    ///
    /// # Panics
    /// When an observation has not so many.
    #[must_use]
    pub fn new(width: usize) -> Self {
        assert!(width <= LEN, "an observation has {LEN} numbers, not {width}");
        Self { uavs: 1, seen: InputRows::Numbers(Rows::new(width)), links: Vec::new() }
    }

    /// For networks that take whole observations of this form; none yet.
    #[must_use]
    pub fn of(form: ObservationForm) -> Self {
        match form {
            ObservationForm::Compact => Self::new(LEN),
            ObservationForm::Cells => {
                Self { uavs: 1, seen: InputRows::Active(ActiveRows::new(form.len())), links: Vec::new() }
            }
        }
    }

    /// Begins anew, with worlds of `uavs` UAVs.
    pub fn clear(&mut self, uavs: usize) {
        self.uavs = uavs;
        match &mut self.seen {
            InputRows::Numbers(rows) => rows.resize(0),
            InputRows::Active(rows) => rows.clear(),
        }
        self.links.clear();
    }

    /// Adds world-steps: an observation and the neighbours of every UAV.
    ///
    /// # Panics
    /// When they are not whole world-steps, or of another form than these inputs.
    pub fn push<'s>(&mut self, observations: impl Into<ObservationSlice<'s>>, links: &[Neighbourhood]) {
        let before = self.links.len();
        self.links.extend_from_slice(links);
        let count = match (&mut self.seen, observations.into()) {
            (InputRows::Numbers(rows), ObservationSlice::Compact(all)) => {
                push_numbers(rows, before, all);
                all.len()
            }
            (InputRows::Active(rows), ObservationSlice::Cells(all)) => {
                all.iter().for_each(|cells| rows.push(cells));
                all.len()
            }
            _ => panic!("observations of another form than the network's"),
        };
        assert!(count == links.len() && count.is_multiple_of(self.uavs), "whole world-steps");
    }

    /// What the first layer takes.
    pub(crate) const fn seen(&self) -> &InputRows {
        &self.seen
    }

    /// UAVs in a world.
    #[must_use]
    pub const fn uavs(&self) -> usize {
        self.uavs
    }

    /// Neighbours, UAV by UAV.
    #[must_use]
    pub fn links(&self) -> &[Neighbourhood] {
        &self.links
    }
}

/// Adds rows behind the first `before`.
fn push_numbers(rows: &mut Rows, before: usize, observations: &[Observation]) {
    rows.resize(before + observations.len());
    let (step, width) = (rows.step(), rows.width());
    let words = width.div_ceil(64);
    let (values, masks) = rows.parts_mut();
    let values = values[before * step..].chunks_exact_mut(step);
    let masks = masks[before * words..].chunks_exact_mut(words);
    for (observation, (values, masks)) in observations.iter().zip(values.zip(masks)) {
        unpack(&observation[..padded(width)], 1.0 / 127.0, values, masks);
        // What the network does not take.
        values[width..].fill(0.0);
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
