//! Batches of observations whose form is chosen at run time.

use super::form::ObservationForm;
use firmware_core::actor::ActorInput;
use firmware_core::observation::cells::Cells;
use firmware_core::observation::{BuildObservation, Observation};
use std::ops::Range;

/// Observations, all of one form; one for each UAV of one or many worlds.
#[derive(Clone, Debug, PartialEq)]
pub enum ObservationBatch {
    /// All in the compact form.
    Compact(Vec<Observation>),
    /// All in the form of cells.
    Cells(Vec<Cells>),
}

/// A range of an [`ObservationBatch`], to read.
#[derive(Clone, Copy, Debug)]
pub enum ObservationSlice<'s> {
    /// All in the compact form.
    Compact(&'s [Observation]),
    /// All in the form of cells.
    Cells(&'s [Cells]),
}

/// A range of an [`ObservationBatch`], to write.
#[derive(Debug)]
pub enum ObservationSliceMut<'s> {
    /// All in the compact form.
    Compact(&'s mut [Observation]),
    /// All in the form of cells.
    Cells(&'s mut [Cells]),
}

impl ObservationBatch {
    /// `count` blank observations.
    #[must_use]
    pub fn new(form: ObservationForm, count: usize) -> Self {
        match form {
            ObservationForm::Compact => Self::Compact(vec![BuildObservation::ZERO; count]),
            ObservationForm::Cells => Self::Cells(vec![BuildObservation::ZERO; count]),
        }
    }

    /// Changes their number; new ones are blank.
    pub fn resize(&mut self, count: usize) {
        match self {
            Self::Compact(v) => v.resize(count, BuildObservation::ZERO),
            Self::Cells(v) => v.resize(count, BuildObservation::ZERO),
        }
    }

    /// Copies the observations of the range `from` to the indices from `to` on.
    ///
    /// # Panics
    /// When an index is beyond the batch.
    pub fn copy_within(&mut self, from: Range<usize>, to: usize) {
        match self {
            Self::Compact(v) => v.copy_within(from, to),
            Self::Cells(v) => v.copy_within(from, to),
        }
    }

    /// Number of observations.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::Compact(v) => v.len(),
            Self::Cells(v) => v.len(),
        }
    }

    /// Whether there is no observation.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The observations of a range of indices.
    ///
    /// # Panics
    /// When an index is beyond the batch.
    #[must_use]
    pub fn part(&self, range: Range<usize>) -> ObservationSlice<'_> {
        match self {
            Self::Compact(v) => ObservationSlice::Compact(&v[range]),
            Self::Cells(v) => ObservationSlice::Cells(&v[range]),
        }
    }

    /// The observations of a range of indices, to write.
    ///
    /// # Panics
    /// When an index is beyond the batch.
    pub fn part_mut(&mut self, range: Range<usize>) -> ObservationSliceMut<'_> {
        match self {
            Self::Compact(v) => ObservationSliceMut::Compact(&mut v[range]),
            Self::Cells(v) => ObservationSliceMut::Cells(&mut v[range]),
        }
    }
}

impl<'s> From<&'s [Observation]> for ObservationSlice<'s> {
    fn from(all: &'s [Observation]) -> Self {
        Self::Compact(all)
    }
}

impl<'s> From<&'s Vec<Observation>> for ObservationSlice<'s> {
    fn from(all: &'s Vec<Observation>) -> Self {
        Self::Compact(all)
    }
}

impl<'s> From<&'s ObservationBatch> for ObservationSlice<'s> {
    fn from(all: &'s ObservationBatch) -> Self {
        all.part(0..all.len())
    }
}

/// An observation type that an [`ObservationBatch`] can hold.
pub trait BatchedObservation: ActorInput {
    /// All observations of `batch`; an empty slice when they are of the other form.
    fn among(batch: &ObservationBatch) -> &[Self];
}

impl BatchedObservation for Observation {
    fn among(batch: &ObservationBatch) -> &[Self] {
        match batch {
            ObservationBatch::Compact(all) => all,
            ObservationBatch::Cells(_) => &[],
        }
    }
}

impl BatchedObservation for Cells {
    fn among(batch: &ObservationBatch) -> &[Self] {
        match batch {
            ObservationBatch::Cells(all) => all,
            ObservationBatch::Compact(_) => &[],
        }
    }
}
