//! Steps since something happened.

/// Steps since something happened, in one byte: up to 254, or never, which counts as longest ago.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Since(u8);

impl Since {
    /// It happened in this step.
    pub(super) const NOW: Self = Self(0);
    /// It never happened.
    pub(super) const NEVER: Self = Self(u8::MAX);

    /// The same `steps` later.
    pub(super) fn advance(&mut self, steps: u8) {
        if *self != Self::NEVER {
            self.0 = self.0.saturating_add(steps).min(u8::MAX - 1);
        }
    }
}
