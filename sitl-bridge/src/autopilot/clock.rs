//! The vehicle's boot clock, and the swarm's common clock (Unix time) derived from it.

use super::clock_rate::ClockRate;

/// A `time_boot_ms` older than the newest by less than this comes from a reordered message, ms.
const REORDERED_MS: i32 = 5_000;
/// A `time_boot_ms` ahead of the newest by more than this comes from another boot, ms.
const LEAP_MS: i32 = 60_000;
/// The common clock is set again when SYSTEM_TIME moved against it by more than this, ms.
const DRIFT_MS: i64 = 5;

/// How a received `time_boot_ms` relates to those before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockUpdate {
    /// As new as the newest so far, or newer.
    Newer,
    /// A little older: its message was overtaken by another.
    Reordered,
    /// The vehicle rebooted, or its clock jumped.
    Restarted,
}

/// The vehicle's `time_boot_ms`, which wraps after 49.7 days, extended to a time that does not wrap, and
/// the offset of Unix time to it.
#[derive(Clone, Copy, Debug, Default)]
pub struct VehicleClock {
    newest: Option<u32>,
    /// Extended time of the newest.
    extended_ms: i64,
    /// Common clock (Unix time, ms) less extended time.
    offset_ms: Option<i64>,
    /// The offset comes from the host's clock and gives way to the vehicle's.
    host_offset: bool,
    rate: ClockRate,
}

impl VehicleClock {
    /// Takes in a `time_boot_ms`.
    pub fn update(&mut self, boot_ms: u32) -> ClockUpdate {
        let Some(newest) = self.newest else {
            (self.newest, self.extended_ms) = (Some(boot_ms), i64::from(boot_ms));
            return ClockUpdate::Newer;
        };
        let ahead = boot_ms.wrapping_sub(newest) as i32;
        if !(-REORDERED_MS..=LEAP_MS).contains(&ahead) {
            *self = Self { newest: Some(boot_ms), extended_ms: i64::from(boot_ms), ..Self::default() };
            return ClockUpdate::Restarted;
        }
        if ahead < 0 {
            return ClockUpdate::Reordered;
        }
        (self.newest, self.extended_ms) = (Some(boot_ms), self.extended_ms + i64::from(ahead));
        ClockUpdate::Newer
    }

    /// The newest `time_boot_ms`.
    #[must_use]
    pub const fn newest(&self) -> Option<u32> {
        self.newest
    }

    /// A `time_boot_ms` near the newest, extended.
    #[must_use]
    pub fn extend(&self, boot_ms: u32) -> Option<i64> {
        let newest = self.newest?;
        Some(self.extended_ms + i64::from(boot_ms.wrapping_sub(newest) as i32))
    }

    /// Takes in SYSTEM_TIME before [`Self::set_unix`]: whether Unix time, ms, still runs as fast as the
    /// vehicle's clock. Returns its rate in thousandths when that has changed. While it does not, there is
    /// no common clock.
    pub fn check_rate(&mut self, unix_ms: i64, boot_ms: u32) -> Option<i64> {
        let changed = self.rate.update(unix_ms, self.extend(boot_ms)?);
        if self.rate.is_drifting() {
            self.offset_ms = None;
        }
        changed
    }

    /// Whether Unix time runs at another rate than the vehicle's clock.
    #[must_use]
    pub const fn is_drifting(&self) -> bool {
        self.rate.is_drifting()
    }

    /// Takes in SYSTEM_TIME: Unix time, ms, at `boot_ms`. Returns the correction of the common
    /// clock, ms, if it was corrected.
    pub fn set_unix(&mut self, unix_ms: i64, boot_ms: u32) -> Option<i64> {
        if self.is_drifting() {
            return None;
        }
        let offset = unix_ms - self.extend(boot_ms)?;
        let moved = offset - self.offset_ms.unwrap_or(offset);
        if self.offset_ms.is_none() || self.host_offset || moved.abs() > DRIFT_MS {
            self.offset_ms = Some(offset);
            self.host_offset = false;
            return (moved != 0).then_some(moved);
        }
        None
    }

    /// Sets the common clock by the host's Unix time, ms, where no SYSTEM_TIME has set it.
    pub fn set_host(&mut self, unix_ms: i64) {
        if self.offset_ms.is_none() && self.newest.is_some() && !self.is_drifting() {
            self.offset_ms = Some(unix_ms - self.extended_ms);
            self.host_offset = true;
        }
    }

    /// Whether the common clock is known.
    #[must_use]
    pub const fn is_set(&self) -> bool {
        self.offset_ms.is_some()
    }

    /// The common clock at a `time_boot_ms`: Unix time, ms.
    #[must_use]
    pub fn common_ms(&self, boot_ms: u32) -> Option<i64> {
        Some(self.extend(boot_ms)? + self.offset_ms?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on_over_the_wrap() {
        let mut clock = VehicleClock::default();
        assert_eq!(clock.update(u32::MAX - 99), ClockUpdate::Newer);
        assert_eq!(clock.set_unix(1_790_000_000_000, u32::MAX - 99), None);
        assert_eq!(clock.update(100), ClockUpdate::Newer);
        assert_eq!(clock.common_ms(100), Some(1_790_000_000_200));
        assert_eq!(clock.update(u32::MAX), ClockUpdate::Reordered);
        assert_eq!(clock.common_ms(u32::MAX), Some(1_790_000_000_099));
        // The autopilot says the same after the wrap, so nothing moves.
        assert_eq!(clock.set_unix(1_790_000_000_201, 101), None);
        assert_eq!(clock.set_unix(1_790_000_001_201, 101), Some(1000));
        assert_eq!(clock.common_ms(100), Some(1_790_000_001_200));
    }

    #[test]
    fn a_reboot_forgets_the_common_clock() {
        let mut clock = VehicleClock::default();
        clock.update(100_000);
        clock.set_host(5_000_000);
        assert_eq!(clock.common_ms(100_000), Some(5_000_000));
        assert_eq!(clock.update(200), ClockUpdate::Restarted);
        assert_eq!(clock.common_ms(200), None);
        assert_eq!(clock.set_unix(6_000_000, 200), None);
        assert_eq!(clock.common_ms(300), Some(6_000_100));
        assert_eq!(clock.update(100_000), ClockUpdate::Restarted);
    }
}
