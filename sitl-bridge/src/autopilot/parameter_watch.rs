//! What is known of one autopilot's parameters, and what the node wants of them.

use super::parameters::Parameters;
use super::standing::Speeds;
use std::collections::BTreeMap;

/// What a node wants of the autopilot's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reliance {
    /// Whether a start is refused where a warning is due.
    pub strict: bool,
    /// The scenario's greatest speed and acceleration.
    pub speeds: Speeds,
}

/// The parameters of one autopilot.
#[derive(Clone, Debug)]
pub(super) struct ParameterWatch {
    pub reliance: Reliance,
    pub parameters: Parameters,
    /// Values that were warned of, by the rule's first name; `None` where the autopilot does not tell it.
    pub told: BTreeMap<&'static str, Option<f64>>,
    /// The strict check of this start was passed.
    pub passed: bool,
}

impl ParameterWatch {
    pub const fn new(reliance: Reliance) -> Self {
        Self { reliance, parameters: Parameters::new(), told: BTreeMap::new(), passed: false }
    }

    /// Begins anew, as for another start.
    pub fn restart(&mut self) {
        self.parameters.ask_again();
        self.passed = false;
    }
}
