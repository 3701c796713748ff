//! Datagrams between sender and receiver, in the order of their arrival.

use std::cmp::Ordering;

/// A copy of a datagram between sender and receiver.
#[derive(Clone, Debug, Default)]
pub(super) struct InTransit {
    /// When it arrives, ms.
    pub due_ms: u64,
    /// The sender.
    pub from: u16,
    /// The receiver.
    pub to: u16,
    /// Its number among those that `from` sent to `to`.
    pub sequence: u32,
    /// Order of those of one sequence number: 0 the first copy, 1 the second, 2 the one that was held back until then.
    pub rank: u8,
    /// Content, with the bit errors it arrives with.
    pub bytes: Vec<u8>,
}

impl InTransit {
    const fn key(&self) -> (u64, u16, u32, u8) {
        (self.due_ms, self.from, self.sequence, self.rank)
    }
}

impl PartialEq for InTransit {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for InTransit {}

impl PartialOrd for InTransit {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The earliest is the greatest, since `BinaryHeap` pops the greatest.
impl Ord for InTransit {
    fn cmp(&self, other: &Self) -> Ordering {
        other.key().cmp(&self.key())
    }
}
