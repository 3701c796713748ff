//! Debouncing: a condition counts only once it has lasted, both ways.

use super::clock::age_ms;

/// Raised when its condition has held for a while; cleared when it has not held for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Debounce {
    raised: bool,
    /// Since when the condition has been the opposite of `raised`.
    turning_ms: Option<u32>,
}

impl Debounce {
    pub const RAISED: Self = Self { raised: true, turning_ms: None };
    pub const CLEAR: Self = Self { raised: false, turning_ms: None };

    /// Takes in the condition at `now_ms` (a clock that wraps); says whether it counts. It is raised when it
    /// has held for `confirm_ms`, cleared when it has not held for `clear_ms`; 0 means at once.
    pub fn update(&mut self, holds: bool, now_ms: u32, confirm_ms: u32, clear_ms: u32) -> bool {
        if holds == self.raised {
            self.turning_ms = None;
        } else {
            let since = *self.turning_ms.get_or_insert(now_ms);
            if age_ms(now_ms, since) >= if holds { confirm_ms } else { clear_ms } {
                *self = Self { raised: holds, turning_ms: None };
            }
        }
        self.raised
    }

    pub const fn is_raised(self) -> bool {
        self.raised
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raised_and_cleared_after_a_while_over_the_wrap_of_the_clock() {
        let mut debounce = Debounce::CLEAR;
        let start = u32::MAX - 250;
        let mut at = |ms: u32, holds| debounce.update(holds, start.wrapping_add(ms), 500, 1000);
        assert!(!at(0, true));
        assert!(!at(499, true));
        assert!(at(500, true));
        assert!(at(600, false));
        // Interrupted: counted anew.
        assert!(at(700, true));
        assert!(at(800, false));
        assert!(at(1799, false));
        assert!(!at(1800, false));
    }

    #[test]
    fn zero_means_at_once() {
        let mut debounce = Debounce::RAISED;
        assert!(!debounce.update(false, 7, 0, 0));
        assert!(debounce.update(true, 7, 0, 0));
    }
}
