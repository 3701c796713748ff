//! Names and limits of the channel model's parameters.

/// Names of the parameters in text, in the order in which they are shown.
pub(super) const KEYS: [&str; 8] =
    ["loss", "burst", "delay_ms", "jitter_ms", "duplicate", "reorder", "corrupt", "range_u"];

/// Most nodes of a channel: the state of every ordered pair of nodes is kept, 8 bytes each.
pub const MAX_NODES: usize = 2048;
/// Longest delay and longest jitter, ms: ten minutes.
pub(super) const MAX_DELAY_MS: u32 = 600_000;
