//! The clock of a node's own timers, such as command timeouts.

/// Longest time by which one step of the vehicle's clock advances the node's, ms.
const LONGEST_MS: i64 = 2000;
/// Without the vehicle's clock for so long, the host's takes over, ms.
const SILENCE_MS: u64 = 1000;

/// A clock that follows the vehicle's, so that simulators may run at any speed, and the host's while
/// the vehicle is silent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Timebase {
    now_ms: i64,
    vehicle_ms: Option<i64>,
    /// Host time up to which time has been counted.
    wall_ms: Option<u64>,
}

impl Timebase {
    /// Advances the clock: `vehicle_ms` is the vehicle's newest extended time, `wall_ms` the host's
    /// monotonic time. Returns the node's time, ms.
    pub fn advance(&mut self, vehicle_ms: Option<i64>, wall_ms: u64) -> i64 {
        let accounted = *self.wall_ms.get_or_insert(wall_ms);
        if vehicle_ms != self.vehicle_ms {
            if let (Some(before), Some(now)) = (self.vehicle_ms, vehicle_ms) {
                self.now_ms += (now - before).clamp(0, LONGEST_MS);
            }
            (self.vehicle_ms, self.wall_ms) = (vehicle_ms, Some(wall_ms));
        } else if wall_ms.saturating_sub(accounted) > SILENCE_MS {
            // The first second of silence is not made up for.
            self.now_ms += (wall_ms - accounted - SILENCE_MS) as i64;
            self.wall_ms = Some(wall_ms - SILENCE_MS);
        }
        self.now_ms
    }

    /// The node's time, ms.
    pub const fn now_ms(&self) -> i64 {
        self.now_ms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_with_the_vehicle_and_without_it() {
        let mut t = Timebase::default();
        assert_eq!(t.advance(None, 100), 0);
        // Nobody is there: host time, after a second.
        assert_eq!(t.advance(None, 1600), 500);
        assert_eq!(t.advance(None, 1700), 600);
        // The vehicle runs twenty times as fast.
        assert_eq!(t.advance(Some(5000), 1710), 600);
        assert_eq!(t.advance(Some(5200), 1720), 800);
        assert_eq!(t.advance(Some(5200), 2720), 800);
        assert_eq!(t.advance(Some(5200), 2820), 900);
        // A clock that jumps moves it by little, one that goes back not at all.
        assert_eq!(t.advance(Some(90_000), 2830), 2900);
        assert_eq!(t.advance(Some(10), 2840), 2900);
    }
}
