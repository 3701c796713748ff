//! Two vehicles that send with one system id: their boot clocks come interleaved.

use super::clock::ClockUpdate;

/// So many restarts of the clock within 64 messages are no reboots: a vehicle needs seconds for one.
const RESTARTS: u32 = 6;
/// So many steps back within 64 messages come from another vehicle, or from a link that reorders badly.
const STEPS_BACK: u32 = 8;

/// What the boot clock tells of who sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Senders {
    /// One vehicle.
    One,
    /// Perhaps two, whose clocks are within seconds of each other.
    Doubtful,
    /// Two.
    Two,
}

/// Looks at the last 64 messages that carried `time_boot_ms`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SharedId {
    /// A bit a message, the newest lowest: it restarted the clock; it stepped back.
    restarts: u64,
    steps_back: u64,
    was_back: bool,
}

impl SharedId {
    /// Takes in how a message's `time_boot_ms` related to those before.
    pub fn update(&mut self, clock: ClockUpdate) {
        let back = clock == ClockUpdate::Reordered;
        self.restarts = self.restarts << 1 | u64::from(clock == ClockUpdate::Restarted);
        self.steps_back = self.steps_back << 1 | u64::from(back && !self.was_back);
        self.was_back = back;
    }

    pub const fn senders(&self) -> Senders {
        if self.restarts.count_ones() >= RESTARTS {
            Senders::Two
        } else if self.steps_back.count_ones() >= STEPS_BACK {
            Senders::Doubtful
        } else {
            Senders::One
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::clock::VehicleClock;
    use super::*;

    /// Two vehicles that speak in turn, three messages each, `apart_ms` from each other.
    fn interleaved(apart_ms: u32) -> Senders {
        let (mut clock, mut shared) = (VehicleClock::default(), SharedId::default());
        for tick in 0..30 {
            for boot_ms in [tick * 200 + 300_000, tick * 200 + 300_000 + apart_ms] {
                (0..3).for_each(|_| shared.update(clock.update(boot_ms)));
            }
        }
        shared.senders()
    }

    #[test]
    fn interleaved_clocks_are_two_vehicles() {
        assert_eq!([2_000, 30_000, 200_000].map(interleaved), [Senders::Doubtful, Senders::Two, Senders::Two]);
        assert_eq!(interleaved(0), Senders::One);
    }

    #[test]
    fn reboots_are_one_vehicle() {
        let (mut clock, mut shared) = (VehicleClock::default(), SharedId::default());
        for _ in 0..10 {
            (0..20).for_each(|tick| shared.update(clock.update(10_000 + tick * 200)));
        }
        assert_eq!(shared.senders(), Senders::One);
    }
}
