//! Whether the times of a recording can be times.

use super::error::RecordingError;

/// The year 2200, microseconds since 1970.
const LATEST_US: u64 = 7_258_118_400_000_000;
/// From this many records on, a single time for all of them is none.
const MANY_RECORDS: u64 = 100;

/// Times met in a log.
#[derive(Debug, Default)]
pub(super) struct Times {
    records: u64,
    same: u64,
    late: u64,
    last_us: Option<u64>,
}

impl Times {
    pub(super) fn take(&mut self, unix_us: u64) {
        self.records += 1;
        self.same += u64::from(self.last_us == Some(unix_us));
        self.late += u64::from(unix_us > LATEST_US);
        self.last_us = Some(unix_us);
    }

    /// Refuses times that cannot be.
    pub(super) fn check(&self) -> Result<(), RecordingError> {
        // One damaged time among many is borne.
        if self.late * 2 > self.records {
            return Err(RecordingError::Times("they lie beyond the year 2200: is the lowest byte first?"));
        }
        if self.records >= MANY_RECORDS && self.same + 1 == self.records {
            return Err(RecordingError::Times("they are all the same"));
        }
        Ok(())
    }
}
