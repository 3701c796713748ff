//! Names of the parameters of the channel model.

/// Names of the parameters in text, in the order in which they are shown.
pub(super) const KEYS: [&str; 8] =
    ["loss", "burst", "delay_ms", "jitter_ms", "duplicate", "reorder", "corrupt", "range_u"];
