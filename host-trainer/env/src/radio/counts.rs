//! What happened to datagrams, counted.

use serde::{Deserialize, Serialize};

/// Counts of what happened to the datagrams of a channel. Always `sent + duplicated` is
/// `out_of_range + lost + delivered` + [`in_flight`](super::RadioChannel::in_flight).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DatagramCounts {
    /// Datagrams handed to [`send`](super::RadioChannel::send); one that is broadcast counts once a receiver.
    pub sent: u64,
    /// Lost because the receiver was too far away.
    pub out_of_range: u64,
    /// Lost on the channel.
    pub lost: u64,
    /// Second copies made.
    pub duplicated: u64,
    /// Held back until the next one has arrived.
    pub held: u64,
    /// Copies with flipped bits, each counted when it was sent.
    pub corrupted: u64,
    /// Handed out by [`poll`](super::RadioChannel::poll).
    pub delivered: u64,
}

impl DatagramCounts {
    /// The sum of two.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self {
            sent: self.sent + other.sent,
            out_of_range: self.out_of_range + other.out_of_range,
            lost: self.lost + other.lost,
            duplicated: self.duplicated + other.duplicated,
            held: self.held + other.held,
            corrupted: self.corrupted + other.corrupted,
            delivered: self.delivered + other.delivered,
        }
    }
}
