//! Values of the autopilot's parameters that were told.

use std::collections::BTreeMap;

/// Values by the parameters' names.
#[derive(Clone, Debug)]
pub(super) struct ParameterValues(BTreeMap<&'static str, f64>);

impl ParameterValues {
    pub const fn new() -> Self {
        Self(BTreeMap::new())
    }

    /// A parameter's value, once it was told.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    pub fn set(&mut self, name: &'static str, value: f64) {
        self.0.insert(name, value);
    }
}
