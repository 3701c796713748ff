//! The host's clock as the common clock, where the autopilot sends no SYSTEM_TIME.

use crate::autopilot::{Notice, VehicleClock};

/// Without SYSTEM_TIME the host's clock is taken this long after the first position, ms of the node's
/// clock.
const FALLBACK_MS: i64 = 10_000;

/// Sets the common clock by the host's when the autopilot does not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HostClockFallback {
    /// When the first position arrived, ms of the node's clock.
    first_position_ms: Option<i64>,
}

impl HostClockFallback {
    /// To be called at each position, at `now_ms` of the node's clock and `unix_us` of the host's.
    /// Returns a notice when it has set the clock.
    pub fn update(&mut self, clock: &mut VehicleClock, now_ms: i64, unix_us: u64) -> Option<Notice> {
        let first = *self.first_position_ms.get_or_insert(now_ms);
        if clock.is_set() || clock.is_drifting() || now_ms - first < FALLBACK_MS {
            return None;
        }
        clock.set_host(i64::try_from(unix_us / 1000).unwrap_or(0));
        Some(Notice::warning("no SYSTEM_TIME from the autopilot: taking this computer's clock"))
    }
}
