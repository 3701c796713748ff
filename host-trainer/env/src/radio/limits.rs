//! Limits of the channel model.

/// Most nodes of a channel: the state of every ordered pair of nodes is kept, 8 bytes each.
pub const MAX_NODES: usize = 2048;
/// Longest delay and longest jitter, ms: ten minutes.
pub(super) const MAX_DELAY_MS: u32 = 600_000;
