//! The two forms of the observation.

use firmware_core::observation::cells::Cells;
use firmware_core::observation::{BuildObservation, Observation};
use serde::{Deserialize, Serialize};

/// A form of the observation, chosen at run time. See `docs/observation.md` and `docs/observation-cells.md`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ObservationForm {
    /// [`Observation`]: engineered features, a few dozen numbers.
    #[default]
    Compact,
    /// [`Cells`]: the paper's grid of cells around the UAV.
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

    /// Length of the network's input vector.
    #[must_use]
    pub const fn len(self) -> usize {
        match self {
            Self::Compact => <Observation as BuildObservation>::LEN,
            Self::Cells => Cells::LEN,
        }
    }

    /// Always false: every form has numbers.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.len() == 0
    }
}
