//! Random numbers on board: a fresh stream for each UAV, step and purpose.
//!
//! A stream depends on the seed, the id and the step alone, not on what happened
//! before. So a restarted UAV, a replayed log and a processor in the loop all draw
//! the same numbers.

use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// What a stream is for; streams of different purpose are independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum Purpose {
    Action = 1,
    TieBreaker = 2,
}

fn stream(seed: u64, id: u16, step: u32, purpose: Purpose) -> Xoshiro128PlusPlus {
    let place = (u64::from(purpose as u8) << 48) | (u64::from(id) << 32) | u64::from(step);
    // An odd multiplier keeps different places different; seed_from_u64 mixes them.
    Xoshiro128PlusPlus::seed_from_u64(seed ^ place.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// The uniform 32-bit number that draws the action of UAV `id` at `step`.
#[must_use]
pub fn action_draw(seed: u64, id: u16, step: u32) -> u32 {
    stream(seed, id, step, Purpose::Action).next_u32()
}

/// The tie-breaker that UAV `id` announces for `step`, uniform in −127..=127: of two
/// neighbours the one with the higher number has priority (equal numbers: the higher id), so
/// that UAVs which observe the same do not do the same. It is drawn anew every `period` steps (0 counts as 1).
#[must_use]
pub fn tie_breaker(seed: u64, id: u16, step: u32, period: u32) -> i8 {
    let round = step / period.max(1);
    let draw = stream(seed, id, round, Purpose::TieBreaker).next_u32();
    // Multiply-shift: 0..255, then centred.
    (((u64::from(draw) * 255) >> 32) as i32 - 127) as i8
}
