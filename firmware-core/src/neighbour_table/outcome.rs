//! What becomes of a message that a table hears.

use serde::{Deserialize, Serialize};

/// What became of a message. The order of the variants is part of the PIL protocol (see [`crate::pil`]).
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MessageOutcome {
    /// Taken: the first beacon of this sender.
    New,
    /// Taken: the first beacon of this sender, in the place of a farther one (its id).
    Replaced(u16),
    /// Taken: the sender's beacon or feature is the new one.
    Updated,
    /// Taken: a second beacon confirms a jump that looked impossible.
    Confirmed,
    /// Waiting: the sender moved farther than it can fly. The old beacon stays until
    /// another one confirms the jump.
    Suspicious,
    /// Not taken: it carries the own id.
    OwnId,
    /// Not taken: this very sequence number was heard before.
    Repeated,
    /// Not taken: a newer one of the same sender was heard before.
    Older,
    /// Not taken: more than [`MAX_AGE_STEPS`](super::MAX_AGE_STEPS) old.
    Late,
    /// Not taken: more than [`MAX_AHEAD_STEPS`](super::MAX_AHEAD_STEPS) in the future; a clock is wrong.
    Ahead,
    /// Not taken: the table is full of nearer neighbours.
    TooFar,
    /// Not taken: a feature of a sender without a beacon in the table.
    UnknownSender,
    /// Not taken: a feature of another policy.
    ForeignActor,
    /// Not taken: a feature of the own policy with a wrong number of values.
    WrongWidth,
}

impl MessageOutcome {
    /// Whether the table now holds the message.
    #[must_use]
    pub const fn is_taken(self) -> bool {
        matches!(self, Self::New | Self::Replaced(_) | Self::Updated | Self::Confirmed)
    }
}
