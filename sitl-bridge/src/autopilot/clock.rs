//! The vehicle's clock, and the swarm's common clock by it.

/// A clock that goes back by less than this was overtaken on its way, ms.
const REORDERED_MS: i32 = 5_000;
/// A clock that goes ahead by more than this at once is another clock, ms.
const LEAP_MS: i32 = 60_000;
/// The common clock is set anew when the autopilot's idea of it moved by more than this, ms.
const DRIFT_MS: i64 = 5;

/// What a time from the vehicle was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tick {
    /// Newer than, or as new as, the newest so far.
    Newer,
    /// Older, by a little: overtaken on its way.
    Older,
    /// Another clock: the vehicle booted anew, or its clock jumped.
    Restarted,
}

/// `time_boot_ms`, which wraps after 49.7 days, as a time that does not.
#[derive(Clone, Copy, Debug, Default)]
pub struct VehicleClock {
    newest: Option<u32>,
    /// Of the newest.
    extended_ms: i64,
    /// Common clock (Unix time, ms) less extended time.
    offset_ms: Option<i64>,
    host_offset: bool,
}

impl VehicleClock {
    /// Takes in a time of the vehicle.
    pub fn hear(&mut self, boot_ms: u32) -> Tick {
        let Some(newest) = self.newest else {
            (self.newest, self.extended_ms) = (Some(boot_ms), i64::from(boot_ms));
            return Tick::Newer;
        };
        let ahead = boot_ms.wrapping_sub(newest) as i32;
        if !(-REORDERED_MS..=LEAP_MS).contains(&ahead) {
            *self = Self { newest: Some(boot_ms), extended_ms: i64::from(boot_ms), ..Self::default() };
            return Tick::Restarted;
        }
        if ahead < 0 {
            return Tick::Older;
        }
        (self.newest, self.extended_ms) = (Some(boot_ms), self.extended_ms + i64::from(ahead));
        Tick::Newer
    }

    /// The newest time heard, as the vehicle says it.
    #[must_use]
    pub const fn newest(&self) -> Option<u32> {
        self.newest
    }

    /// A time of the vehicle near the newest, extended.
    #[must_use]
    pub fn extend(&self, boot_ms: u32) -> Option<i64> {
        let newest = self.newest?;
        Some(self.extended_ms + i64::from(boot_ms.wrapping_sub(newest) as i32))
    }

    /// Takes in what the autopilot says about Unix time: ms of it at `boot_ms`. Returns by how
    /// much the common clock was corrected, if it was.
    pub fn set_unix(&mut self, unix_ms: i64, boot_ms: u32) -> Option<i64> {
        let offset = unix_ms - self.extend(boot_ms)?;
        let moved = offset - self.offset_ms.unwrap_or(offset);
        if self.offset_ms.is_none() || self.host_offset || moved.abs() > DRIFT_MS {
            self.offset_ms = Some(offset);
            self.host_offset = false;
            return (moved != 0).then_some(moved);
        }
        None
    }

    /// Takes the host's Unix time (ms) for the vehicle's newest, for want of a better one.
    pub fn set_host(&mut self, unix_ms: i64) {
        if self.offset_ms.is_none() && self.newest.is_some() {
            self.offset_ms = Some(unix_ms - self.extended_ms);
            self.host_offset = true;
        }
    }

    /// Whether the common clock is known.
    #[must_use]
    pub const fn is_set(&self) -> bool {
        self.offset_ms.is_some()
    }

    /// The common clock at a time of the vehicle: Unix time, ms.
    #[must_use]
    pub fn common_ms(&self, boot_ms: u32) -> Option<i64> {
        Some(self.extend(boot_ms)? + self.offset_ms?)
    }

    /// The vehicle's time at a moment of the common clock, wrapped as the vehicle wraps it.
    #[must_use]
    pub fn boot_ms(&self, common_ms: i64) -> Option<u32> {
        let ahead = common_ms - self.offset_ms? - self.extended_ms;
        Some(self.newest?.wrapping_add(ahead as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on_over_the_wrap() {
        let mut clock = VehicleClock::default();
        assert_eq!(clock.hear(u32::MAX - 99), Tick::Newer);
        assert_eq!(clock.set_unix(1_790_000_000_000, u32::MAX - 99), None);
        assert_eq!(clock.hear(100), Tick::Newer);
        assert_eq!(clock.common_ms(100), Some(1_790_000_000_200));
        assert_eq!(clock.hear(u32::MAX), Tick::Older);
        assert_eq!(clock.common_ms(u32::MAX), Some(1_790_000_000_099));
        assert_eq!(clock.boot_ms(1_790_000_000_099), Some(u32::MAX));
        // The autopilot says the same after the wrap, so nothing moves.
        assert_eq!(clock.set_unix(1_790_000_000_201, 101), None);
        assert_eq!(clock.set_unix(1_790_000_001_201, 101), Some(1000));
        assert_eq!(clock.common_ms(100), Some(1_790_000_001_200));
    }

    #[test]
    fn a_reboot_forgets_the_common_clock() {
        let mut clock = VehicleClock::default();
        clock.hear(100_000);
        clock.set_host(5_000_000);
        assert_eq!(clock.common_ms(100_000), Some(5_000_000));
        assert_eq!(clock.hear(200), Tick::Restarted);
        assert_eq!(clock.common_ms(200), None);
        assert_eq!(clock.set_unix(6_000_000, 200), None);
        assert_eq!(clock.common_ms(300), Some(6_000_100));
        assert_eq!(clock.hear(100_000), Tick::Restarted);
    }
}
