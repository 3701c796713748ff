//! How old a message is, on clocks that wrap around.

/// Greatest age of a beacon or a feature in use, steps (the limit is inside).
pub const MAX_AGE_STEPS: i32 = 2;
/// How far ahead of the own clock a beacon or a feature may be, steps (the limit is inside).
pub const MAX_AHEAD_STEPS: i32 = 1;
/// How old something is, in classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Age {
    Ahead,
    Usable,
    Late,
}

/// Classes the difference of two wrapping times; `step` is the length of a step in their unit.
pub(super) const fn age(now: u32, then: u32, step: i32) -> Age {
    let age = now.wrapping_sub(then) as i32;
    if age < -MAX_AHEAD_STEPS * step {
        Age::Ahead
    } else if age > MAX_AGE_STEPS * step {
        Age::Late
    } else {
        Age::Usable
    }
}
