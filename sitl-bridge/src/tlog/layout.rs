//! Numbers of a tlog's records.

/// Length of a record's time, bytes.
pub(super) const TIME: usize = 8;
/// SETUP_SIGNING, the message that hands over a key.
pub(super) const SETUP_SIGNING: u32 = 256;
