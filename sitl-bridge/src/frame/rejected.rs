//! Why received bytes, frames and messages were rejected, and how often.

use std::ops::AddAssign;

/// Why bytes, a frame or a message were rejected: one list for framing, signing and the swarm link, so
/// that one table of counts describes a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Rejected {
    /// A run of bytes that belong to no frame.
    Garbage,
    /// A frame that the datagram ends in the middle of.
    Truncated,
    /// A frame whose checksum does not fit.
    BadChecksum,
    /// A MAVLink 2 frame with an undefined incompatibility flag.
    UnknownFlags,
    /// An unsigned frame of a message that is in no known dialect, so that its checksum cannot be
    /// verified.
    UnknownMessage,
    /// No signature where one is required.
    Unsigned,
    /// A signature by another key, or a forged signature.
    WrongKey,
    /// Its timestamp is not newer than the last one of the same system, component and link id.
    Replayed,
    /// The first frame of its stream, more than a minute old.
    OldTimestamp,
    /// On the swarm link: not a neighbour message.
    NotNeighbour,
    /// On the swarm link: a neighbour message addressed to another network or system.
    Addressed,
    /// The own message, looped back by multicast or broadcast.
    OwnEcho,
    /// A message of another sender with the own id.
    IdCollision,
    /// The id in the message is not that of the system that sent the frame.
    SpoofedId,
    /// A neighbour message of another version.
    OtherVersion,
    /// Bytes that do not parse as a neighbour message.
    Malformed,
}

impl Rejected {
    /// All reasons, in the order of the checks.
    pub const ALL: [Self; 16] = [
        Self::Garbage,
        Self::Truncated,
        Self::BadChecksum,
        Self::UnknownFlags,
        Self::UnknownMessage,
        Self::Unsigned,
        Self::WrongKey,
        Self::Replayed,
        Self::OldTimestamp,
        Self::NotNeighbour,
        Self::Addressed,
        Self::OwnEcho,
        Self::IdCollision,
        Self::SpoofedId,
        Self::OtherVersion,
        Self::Malformed,
    ];

    /// The name in summaries: the variant's in snake case.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Garbage => "garbage",
            Self::Truncated => "truncated",
            Self::BadChecksum => "bad_checksum",
            Self::UnknownFlags => "unknown_flags",
            Self::UnknownMessage => "unknown_message",
            Self::Unsigned => "unsigned",
            Self::WrongKey => "wrong_key",
            Self::Replayed => "replayed",
            Self::OldTimestamp => "old_timestamp",
            Self::NotNeighbour => "not_neighbour",
            Self::Addressed => "addressed",
            Self::OwnEcho => "own_echo",
            Self::IdCollision => "id_collision",
            Self::SpoofedId => "spoofed_id",
            Self::OtherVersion => "other_version",
            Self::Malformed => "malformed",
        }
    }
}

/// Counts by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts([u64; Rejected::ALL.len()]);

impl Counts {
    /// All counts zero.
    #[must_use]
    pub const fn new() -> Self {
        Self([0; Rejected::ALL.len()])
    }

    /// Adds one case.
    pub const fn count(&mut self, reason: Rejected) {
        self.0[reason as usize] += 1;
    }

    /// The count of one reason.
    #[must_use]
    pub const fn get(&self, reason: Rejected) -> u64 {
        self.0[reason as usize]
    }

    /// The sum over all reasons.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    /// The reasons with a count above zero, and their counts.
    pub fn iter(&self) -> impl Iterator<Item = (Rejected, u64)> {
        Rejected::ALL.into_iter().map(|r| (r, self.get(r))).filter(|&(_, n)| n > 0)
    }
}

impl AddAssign<&Self> for Counts {
    fn add_assign(&mut self, other: &Self) {
        for (sum, n) in self.0.iter_mut().zip(other.0) {
            *sum += n;
        }
    }
}
