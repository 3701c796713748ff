//! The vehicle's clock: whether it goes on as one clock does.

use super::limits::Limits;

/// How the vehicle's clock went since the last tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ClockStep {
    /// As it should.
    Steady,
    /// Back, by more than messages out of order explain.
    Back,
    /// Forward, by more than the time that passed or than may be missed.
    Ahead,
}

/// The last moment heard, and when it was heard.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct VehicleClock {
    now_ms: Option<u32>,
    /// The own computer's clock when the vehicle's last went on (or was first waited for).
    advanced_wall_ms: Option<u32>,
}

impl VehicleClock {
    /// Takes in both clocks.
    pub fn advance(&mut self, now_ms: Option<u32>, wall_ms: u32, limits: &Limits) -> ClockStep {
        let waited_ms = self.silence_ms(wall_ms);
        let Some(now) = now_ms else {
            self.advanced_wall_ms.get_or_insert(wall_ms);
            return ClockStep::Steady;
        };
        let outcome = match self.now_ms {
            None => ClockStep::Steady,
            Some(last) => {
                let step = now.wrapping_sub(last).cast_signed();
                if step <= 0 && step.unsigned_abs() <= limits.reorder_ms {
                    self.advanced_wall_ms.get_or_insert(wall_ms);
                    return ClockStep::Steady;
                }
                let step_ms = step.unsigned_abs();
                let slipped = limits.real_time && step_ms > limits.clock_slip_ms.saturating_add(waited_ms);
                match step {
                    ..0 => ClockStep::Back,
                    _ if slipped || step_ms > limits.max_gap_ms => ClockStep::Ahead,
                    _ => ClockStep::Steady,
                }
            }
        };
        (self.now_ms, self.advanced_wall_ms) = (Some(now), Some(wall_ms));
        outcome
    }

    /// The vehicle's time; nothing before the first. In real time it is taken to go on while nothing is heard.
    pub fn now_ms(&self, wall_ms: u32, limits: &Limits) -> Option<u32> {
        let silence_ms = if limits.real_time { self.silence_ms(wall_ms) } else { 0 };
        self.now_ms.map(|now| now.wrapping_add(silence_ms))
    }

    /// For how long the vehicle's clock has stood still, ms of the own computer's.
    pub fn silence_ms(&self, wall_ms: u32) -> u32 {
        self.advanced_wall_ms.map_or(0, |then| age_ms(wall_ms, then))
    }
}

/// How long ago `then_ms` was at `now_ms`; 0 when it is still to come (less than half a turn of the clock ahead).
pub(super) fn age_ms(now_ms: u32, then_ms: u32) -> u32 {
    now_ms.wrapping_sub(then_ms).cast_signed().max(0).unsigned_abs()
}
