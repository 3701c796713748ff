//! Why something that arrived was not used, and how often.

use std::ops::AddAssign;

/// Why bytes, a frame or a message were not used. One list for all of the wire, so that one
/// table of counts says what a link suffers from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Rejected {
    /// A run of bytes that belong to no frame.
    Garbage,
    /// A frame that the datagram ends in the middle of.
    Truncated,
    /// A frame whose checksum does not fit.
    BadChecksum,
    /// A MAVLink 2 frame with an incompatibility flag that nobody has defined.
    UnknownFlags,
    /// A frame of a message that is in no known dialect, so that its checksum cannot be known,
    /// without a signature that vouches for it.
    UnknownMessage,
    /// No signature where one is required.
    Unsigned,
    /// A signature by another key, or a forged one.
    WrongKey,
    /// Not newer than the last one of the same system, component and link id.
    Replayed,
    /// The first one of its stream, more than a minute old.
    OldTimestamp,
    /// On the swarm link: not a neighbour message.
    NotNeighbour,
    /// On the swarm link: a neighbour message addressed to somebody.
    Addressed,
    /// Our own message, come back.
    OwnEcho,
    /// A message of another sender that has our id.
    IdCollision,
    /// The id in the message is not that of the system that sent the frame.
    SpoofedId,
    /// A neighbour message of another version.
    OtherVersion,
    /// Bytes that are no neighbour message.
    Malformed,
}

impl Rejected {
    /// All of them, in the order in which they are met.
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

/// How often each reason was met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts([u64; Rejected::ALL.len()]);

impl Counts {
    /// None so far.
    #[must_use]
    pub const fn new() -> Self {
        Self([0; Rejected::ALL.len()])
    }

    /// One more.
    pub const fn count(&mut self, reason: Rejected) {
        self.0[reason as usize] += 1;
    }

    /// How often this reason was met.
    #[must_use]
    pub const fn get(&self, reason: Rejected) -> u64 {
        self.0[reason as usize]
    }

    /// All together.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    /// The reasons that were met, with how often.
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
