//! A mission that was read, and remarks on it.

use super::definition::Mission;
use super::format::Format;
use std::fmt;

/// A mission that was read, and what its operator should know of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The mission.
    pub mission: Mission,
    /// The format of its file.
    pub format: Format,
    /// What was read otherwise than it stands there, and what may go wrong in flight.
    pub remarks: Vec<Remark>,
}

/// A word on a mission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// Whether something may go wrong in flight.
    pub warning: bool,
    /// The word.
    pub text: String,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", if self.warning { "warning" } else { "note" }, self.text)
    }
}
