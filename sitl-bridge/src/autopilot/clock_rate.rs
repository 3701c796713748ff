//! Whether Unix time runs as fast as the vehicle's own clock.
//!
//! PX4's SYSTEM_TIME tells the host's time. In a simulation at another speed than 1 it runs away from
//! `time_boot_ms`, and a step would take another time than the vehicle's.

/// The rate is measured over so much of the vehicle's clock, ms …
const WINDOW_MS: i64 = 2000;
/// … and believed when so many in a row agree: a single correction of the clock is no rate.
const WINDOWS: u8 = 3;
/// The two clocks may differ by one part in so many: 10 %. PX4's SIH on a busy computer runs at 0.93 to 1 times
/// real time (seen on PX4 main); a step that is so much longer for one vehicle does no harm.
const TOLERANCE: i64 = 10;

/// Measures the rate of Unix time against the vehicle's clock.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClockRate {
    /// Where the present window began: Unix time and vehicle's clock, ms.
    began: Option<(i64, i64)>,
    /// Windows in a row that were too fast (above zero) or too slow, and those that were right.
    off: i8,
    right: u8,
    drifting: bool,
}

impl ClockRate {
    /// Whether the clocks run apart.
    pub const fn is_drifting(&self) -> bool {
        self.drifting
    }

    /// Takes in SYSTEM_TIME. Returns the rate in thousandths when it has changed between right and wrong.
    pub const fn update(&mut self, unix_ms: i64, vehicle_ms: i64) -> Option<i64> {
        let Some((unix_then, vehicle_then)) = self.began else {
            self.began = Some((unix_ms, vehicle_ms));
            return None;
        };
        let (unix, vehicle) = (unix_ms.saturating_sub(unix_then), vehicle_ms.saturating_sub(vehicle_then));
        if vehicle < WINDOW_MS {
            return None;
        }
        self.began = Some((unix_ms, vehicle_ms));
        let apart = unix.saturating_sub(vehicle);
        if apart.saturating_abs() <= vehicle / TOLERANCE {
            (self.off, self.right) = (0, self.right.saturating_add(1));
        } else {
            let sign = if apart > 0 { 1 } else { -1 };
            self.off = if self.off * sign > 0 { self.off.saturating_add(sign) } else { sign };
            self.right = 0;
        }
        let drifting = if self.drifting { self.right < WINDOWS } else { self.off.unsigned_abs() >= WINDOWS };
        if drifting == self.drifting {
            return None;
        }
        self.drifting = drifting;
        Some(unix.saturating_mul(1000) / vehicle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is reported over 20 s at a speed, with a correction on the way.
    fn reports(permille: i64, correction_ms: i64) -> Vec<i64> {
        let mut rate = ClockRate::default();
        let told = (0..100).filter_map(|i| {
            let jump = if i > 40 { correction_ms } else { 0 };
            rate.update(1_790_000_000_000 + i * 200 * permille / 1000 + jump, 10_000 + i * 200)
        });
        told.collect()
    }

    #[test]
    fn a_rate_is_told_once_and_a_correction_is_none() {
        assert_eq!(reports(2000, 0), [2000]);
        assert_eq!(reports(850, 0), [850]);
        assert!(reports(1000, 0).is_empty() && reports(1090, 0).is_empty() && reports(910, 0).is_empty());
        assert!(reports(1000, 7000).is_empty() && reports(1000, -7000).is_empty());
    }
}
