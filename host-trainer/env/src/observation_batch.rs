//! Observations of either form, side by side.

use firmware_core::actor::ActorInput;
use firmware_core::observation::cells::Cells;
use firmware_core::observation::{BuildObservation, Observation};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A form of the observation, to be chosen when the program runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ObservationForm {
    /// [`Observation`]: numbers made for the task.
    #[default]
    Compact,
    /// [`Cells`]: the paper's.
    Cells,
}

impl ObservationForm {
    /// Every form.
    pub const ALL: [Self; 2] = [Self::Compact, Self::Cells];

    /// Its name in settings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Compact => "compact",
            Self::Cells => "cells",
        }
    }

    /// Numbers that a network takes.
    #[must_use]
    pub const fn len(self) -> usize {
        match self {
            Self::Compact => <Observation as BuildObservation>::LEN,
            Self::Cells => Cells::LEN,
        }
    }

    /// Never: a form has numbers.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.len() == 0
    }
}

/// Observations of one form.
#[derive(Clone, Debug, PartialEq)]
pub enum ObservationBatch {
    /// In the compact form.
    Compact(Vec<Observation>),
    /// In cells.
    Cells(Vec<Cells>),
}

/// Some of them, to read.
#[derive(Clone, Copy, Debug)]
pub enum ObservationSlice<'s> {
    /// In the compact form.
    Compact(&'s [Observation]),
    /// In cells.
    Cells(&'s [Cells]),
}

/// Some of them, to write.
#[derive(Debug)]
pub enum ObservationSliceMut<'s> {
    /// In the compact form.
    Compact(&'s mut [Observation]),
    /// In cells.
    Cells(&'s mut [Cells]),
}

impl ObservationBatch {
    /// So many blank ones.
    #[must_use]
    pub fn new(form: ObservationForm, count: usize) -> Self {
        match form {
            ObservationForm::Compact => Self::Compact(vec![BuildObservation::ZERO; count]),
            ObservationForm::Cells => Self::Cells(vec![BuildObservation::ZERO; count]),
        }
    }

    /// Sets their number; new ones are blank.
    pub fn resize(&mut self, count: usize) {
        match self {
            Self::Compact(v) => v.resize(count, BuildObservation::ZERO),
            Self::Cells(v) => v.resize(count, BuildObservation::ZERO),
        }
    }

    /// Copies those in `from` to the places from `to` on.
    ///
    /// # Panics
    /// When there are no such places.
    pub fn copy_within(&mut self, from: Range<usize>, to: usize) {
        match self {
            Self::Compact(v) => v.copy_within(from, to),
            Self::Cells(v) => v.copy_within(from, to),
        }
    }

    /// How many.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::Compact(v) => v.len(),
            Self::Cells(v) => v.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Those at these places.
    ///
    /// # Panics
    /// When there are no such places.
    #[must_use]
    pub fn part(&self, places: Range<usize>) -> ObservationSlice<'_> {
        match self {
            Self::Compact(v) => ObservationSlice::Compact(&v[places]),
            Self::Cells(v) => ObservationSlice::Cells(&v[places]),
        }
    }

    /// Those at these places, to write.
    ///
    /// # Panics
    /// When there are no such places.
    pub fn part_mut(&mut self, places: Range<usize>) -> ObservationSliceMut<'_> {
        match self {
            Self::Compact(v) => ObservationSliceMut::Compact(&mut v[places]),
            Self::Cells(v) => ObservationSliceMut::Cells(&mut v[places]),
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

/// A form of which [`ObservationBatch`] can be.
pub trait BatchedObservation: ActorInput {
    /// All observations; none when they are of another form.
    fn among(sights: &ObservationBatch) -> &[Self];
}

impl BatchedObservation for Observation {
    fn among(sights: &ObservationBatch) -> &[Self] {
        match sights {
            ObservationBatch::Compact(all) => all,
            ObservationBatch::Cells(_) => &[],
        }
    }
}

impl BatchedObservation for Cells {
    fn among(sights: &ObservationBatch) -> &[Self] {
        match sights {
            ObservationBatch::Cells(all) => all,
            ObservationBatch::Compact(_) => &[],
        }
    }
}
