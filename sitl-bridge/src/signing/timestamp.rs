//! The timestamps of MAVLink 2 signatures.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// 2015-01-01 00:00:00 UTC, where timestamps begin, seconds after 1970.
const EPOCH_S: u64 = 1_420_070_400;
/// Timestamps have 48 bits on the wire.
const MAX: u64 = (1 << 48) - 1;

/// A time in units of 10 µs since the beginning of 2015 (UTC), 48 bits: enough until 2104.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Timestamp(u64);

impl Timestamp {
    /// A time in units of 10 µs; what 48 bits cannot hold becomes the last that they can.
    #[must_use]
    pub const fn from_ticks(ticks: u64) -> Self {
        Self(if ticks < MAX { ticks } else { MAX })
    }

    /// The time of the system's clock. Times before 2015 become the beginning of 2015.
    #[must_use]
    pub fn now() -> Self {
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self::from_unix_us(u64::try_from(unix.as_micros()).unwrap_or(u64::MAX))
    }

    /// A time in microseconds since 1970. Times before 2015 become the beginning of 2015.
    #[must_use]
    pub const fn from_unix_us(us: u64) -> Self {
        Self::from_ticks(us.saturating_sub(EPOCH_S * 1_000_000) / 10)
    }

    /// Units of 10 µs since the beginning of 2015.
    #[must_use]
    pub const fn ticks(self) -> u64 {
        self.0
    }

    /// This much later.
    #[must_use]
    pub const fn after(self, span: Duration) -> Self {
        Self::from_ticks(self.0.saturating_add(ticks_of(span)))
    }

    /// This much earlier, but not before 2015.
    #[must_use]
    pub const fn before(self, span: Duration) -> Self {
        Self(self.0.saturating_sub(ticks_of(span)))
    }

    /// The next one.
    #[must_use]
    pub const fn next(self) -> Self {
        Self::from_ticks(self.0 + 1)
    }

    /// How much later than `other`; zero when it is not.
    #[must_use]
    pub const fn since(self, other: Self) -> Duration {
        Duration::from_micros(self.0.saturating_sub(other.0) * 10)
    }
}

const fn ticks_of(span: Duration) -> u64 {
    let ticks = span.as_micros() / 10;
    if ticks > MAX as u128 { MAX } else { ticks as u64 }
}
