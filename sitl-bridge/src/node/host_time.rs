//! The time of the host computer.

use crate::signing::Timestamp;

/// A reading of the host's clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HostTime {
    /// Monotonic clock, ms; where it begins does not matter.
    pub wall_ms: u64,
    /// Unix time, µs.
    pub unix_us: u64,
}

impl HostTime {
    /// The Unix time as MAVLink's signatures count it.
    pub(super) const fn timestamp(self) -> Timestamp {
        Timestamp::from_unix_us(self.unix_us)
    }
}
