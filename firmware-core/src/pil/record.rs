//! What host and board say to each other: postcard records.

use super::FrameError;
use crate::actor::{Aggregation, LoadError, Logits};
use crate::geometry::{State, Vec2};
use crate::neighbour_table::{Answer, Moment};
use serde::{Deserialize, Serialize};

/// What a host asks. The order of the variants is part of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request<'a> {
    /// Starts, or starts afresh with an empty neighbour table. Answer: [`Reply::Report`].
    Hello(Setup),
    /// A neighbour's message. Answer: [`Reply::Heard`].
    #[serde(borrow)]
    Hear(Hear<'a>),
    /// Builds the observation of a step and encodes it. Answer: [`Reply::Observed`].
    Observe(Observe<'a>),
    /// Decides the step that was observed last. Answer: [`Reply::Decided`].
    Decide {
        /// The step.
        step: u32,
    },
    /// Answer: [`Reply::Status`].
    Status,
    /// Runs the actor's self-test again. Answer: [`Reply::Report`].
    SelfTest,
    /// Goes on with the actor's signature, from 0 cases anew. Answer: [`Reply::Signature`].
    Sign {
        /// Cases so far; a board that has another number says so and adds none.
        from: u32,
        /// Cases to add, at most [`super::MAX_CASES`].
        cases: u16,
    },
}

/// Whom the board flies for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setup {
    /// Its id in the swarm.
    pub id: u16,
    /// Seed of tie-breakers and sampled actions.
    pub seed: u64,
    /// Always the action with the greatest logit, instead of sampling.
    pub argmax: bool,
    /// Length of a step, ms (see [`crate::neighbour_table::NeighbourTable::new`]).
    pub step_ms: u16,
    /// Half the side of the map, ticks.
    pub half_side: i32,
}

/// A neighbour's message as the radio brought it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hear<'a> {
    /// When it was heard.
    pub now: Moment,
    /// Own position then, x and y, ticks.
    pub position: [i32; 2],
    /// The message, see [`crate::message`].
    pub message: &'a [u8],
}

/// What a UAV measures at a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Observe<'a> {
    /// The step and its time.
    pub now: Moment,
    /// Own position, x and y, ticks.
    pub position: [i32; 2],
    /// Own velocity, x and y, ticks/step.
    pub velocity: [i32; 2],
    /// PoIs in view, up to [`super::MAX_POIS`] of [`super::POI_BYTES`] bytes.
    pub pois: &'a [u8],
}

impl Observe<'_> {
    /// Own state.
    #[must_use]
    pub const fn own(&self) -> State {
        let ([x, y], [vx, vy]) = (self.position, self.velocity);
        State { position: Vec2::from_ticks(x, y), velocity: Vec2::from_ticks(vx, vy) }
    }
}

/// What a board answers. The order of the variants is part of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reply<'a> {
    /// What the board runs; also sent unasked when it starts.
    #[serde(borrow)]
    Report(Report<'a>),
    /// A message was offered to the neighbour table.
    Heard {
        /// What became of it.
        answer: Answer,
        /// UAVs in the table now.
        kept: u8,
    },
    /// The step is observed and encoded.
    Observed(Observed<'a>),
    /// The step is decided.
    Decided(Decided),
    /// How the board and the line are.
    Status(Status),
    /// The signature in progress.
    Signature {
        /// Cases so far.
        cases: u32,
        /// Its value.
        value: u64,
    },
    /// The request was read but not done.
    Refused(Refusal),
}

/// What a board runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report<'a> {
    /// Version of the firmware.
    pub software: &'a str,
    /// Its actor, or why it has none that may fly.
    pub actor: Result<ActorInfo, Fault>,
}

/// An actor that passed its self-test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActorInfo {
    /// Content hash of the file.
    pub content_hash: u64,
    /// Form of its observation.
    pub observation: u16,
    /// How it combines features.
    pub aggregation: Aggregation,
    /// Values of the feature it broadcasts; 0 when it broadcasts none.
    pub width: u8,
    /// Steps for which a tie-breaker holds.
    pub tie_period: u32,
}

/// Why a board has no actor that may fly. All but the first two and the last are those of
/// [`LoadError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, thiserror::Error)]
pub enum Fault {
    /// Not started yet.
    #[error("the board has not loaded its actor")]
    NotLoaded,
    /// Something else.
    #[error("the board cannot load its actor")]
    Other,
    /// Too few bytes.
    #[error("the board's actor file is cut short; flash it again")]
    Truncated,
    /// Too many bytes.
    #[error("the board's actor file is too long; flash it again")]
    Extended,
    /// Something else is in its place.
    #[error("the board holds no actor file; flash one")]
    NotAnActor,
    /// Another format.
    #[error("the board's actor file is of another format; export it with the firmware's version")]
    Version,
    /// A damaged file.
    #[error("the board's actor file is damaged; flash it again")]
    Checksum,
    /// An unreadable record.
    #[error("the board's actor file cannot be read; export it again")]
    Malformed,
    /// Another observation.
    #[error("the board's actor wants another form of observation; train it again")]
    Observation,
    /// Unfit widths.
    #[error("the board's actor has widths that the firmware cannot fly; train it again")]
    Dimension,
    /// Weights do not fit the widths.
    #[error("the weights of the board's actor do not fit its widths; export it again")]
    Length,
    /// A number out of bounds.
    #[error("the board's actor has a number out of bounds; export it again")]
    OutOfRange,
    /// Unreadable self-test vectors.
    #[error("the self-test vectors of the board's actor cannot be read; export it again")]
    SelfTests,
    /// A wrong content hash.
    #[error("the content hash of the board's actor is wrong; export it again")]
    ContentHash,
    /// The self-test gave other logits than at export, in this vector.
    #[error("self-test vector {0} gives other logits on the board than when the actor was exported: do not fly")]
    SelfTest(u8),
}

impl From<LoadError> for Fault {
    fn from(e: LoadError) -> Self {
        match e {
            LoadError::Truncated { .. } => Self::Truncated,
            LoadError::Extended { .. } => Self::Extended,
            LoadError::NotAnActor => Self::NotAnActor,
            LoadError::Version { .. } => Self::Version,
            LoadError::Checksum { .. } => Self::Checksum,
            LoadError::Malformed => Self::Malformed,
            LoadError::Observation { .. } => Self::Observation,
            LoadError::Dimension { .. } => Self::Dimension,
            LoadError::Length => Self::Length,
            LoadError::OutOfRange => Self::OutOfRange,
            LoadError::SelfTests => Self::SelfTests,
            LoadError::ContentHash => Self::ContentHash,
        }
    }
}

/// An observed step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Observed<'a> {
    /// The step.
    pub step: u32,
    /// Neighbours in view and the UAV itself, 1 to 17.
    pub degree: u8,
    /// The UAV's tie-breaker of the step, for its next beacons.
    pub tie: i8,
    /// The feature message to broadcast; empty when the policy broadcasts none. Its
    /// sequence number is the step's low half.
    pub message: &'a [u8],
}

/// A decided step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Decided {
    /// The step.
    pub step: u32,
    /// Index of the action, 0 to 16.
    pub action: u8,
    /// Neighbours whose features counted.
    pub features: u8,
    /// The logits.
    pub logits: Logits,
}

/// How the board and the line are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// Whether a [`Request::Hello`] came.
    pub started: bool,
    /// The step observed last.
    pub observed: Option<u32>,
    /// UAVs in the neighbour table.
    pub kept: u8,
    /// Decisions since the start.
    pub decisions: u32,
    /// What came over the line.
    pub counters: Counters,
}

/// What came over the line since the board started; each number wraps around.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Requests carried out.
    pub done: u32,
    /// Requests refused, unreadable ones and other versions' included.
    pub refused: u32,
    /// See [`FrameError::TooLong`].
    pub too_long: u32,
    /// See [`FrameError::Broken`].
    pub broken: u32,
    /// See [`FrameError::TooShort`].
    pub too_short: u32,
    /// See [`FrameError::Checksum`].
    pub checksum: u32,
    /// See [`FrameError::Version`].
    pub version: u32,
}

impl Counters {
    /// Frames that were dropped.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.too_long.wrapping_add(self.broken).wrapping_add(self.too_short).wrapping_add(self.checksum)
    }

    pub(super) fn count(&mut self, error: FrameError) {
        let counter = match error {
            FrameError::TooLong => &mut self.too_long,
            FrameError::Broken => &mut self.broken,
            FrameError::TooShort => &mut self.too_short,
            FrameError::Checksum => &mut self.checksum,
            FrameError::Version(_) => &mut self.version,
        };
        *counter = counter.wrapping_add(1);
    }
}

/// Why a request was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, thiserror::Error)]
pub enum Refusal {
    /// The frame is of another version than the board's, which is given.
    #[error("the board speaks protocol version {0}: update the older of the two")]
    Version(u8),
    /// The frame is intact, but its record cannot be read.
    #[error("the board cannot read the request: update the older of the two")]
    Unreadable,
    /// There is no actor that may fly.
    #[error(transparent)]
    Fault(Fault),
    /// No [`Request::Hello`] since the board started.
    #[error("the board was not told whom it flies for, or it restarted: say hello first")]
    NotStarted,
    /// The neighbour message is none.
    #[error("the board was passed bytes that are no neighbour message")]
    Message,
    /// Not a whole number of PoIs, or more than [`super::MAX_POIS`].
    #[error("the request holds no whole number of PoIs, or too many")]
    Pois,
    /// Another step was observed last, or none.
    #[error("the step to decide was not observed last: observe it first")]
    NotObserved,
}
