//! The two messages that UAVs of one swarm send each other.
//!
//! A [`Beacon`] tells where its sender is; it comes just before a step and as often as
//! the link allows. A [`Feature`] carries what the sender's encoder made of its
//! observation, once a step. Both have a fixed little-endian layout, described byte by
//! byte in `docs/messages.md`, and exactly one form: two different byte strings never
//! mean the same. There is no checksum inside; the link below has one.

use crate::actor::{self, ActorInput, MAX_DEGREE, MAX_FEATURE, QuantisedActor};
use crate::geometry::{COORDINATE_LIMIT, State, Vec2};
use crate::neighbour_table::PolicyId;
use heapless::Vec;

/// Version of both layouts, the first byte of a message.
pub const VERSION: u8 = 1;
/// Length of a beacon, bytes.
pub const BEACON_LEN: usize = 27;
/// Length of a feature without its values, bytes.
pub const FEATURE_HEAD_LEN: usize = 18;
/// Length of the longest message, bytes.
pub const MAX_LEN: usize = FEATURE_HEAD_LEN + MAX_FEATURE;

const KIND_BEACON: u8 = 1;
const KIND_FEATURE: u8 = 2;

/// Who sent a message and when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// The sender's id.
    pub id: u16,
    /// Counts the sender's messages of this kind and wraps around.
    pub sequence: u16,
    /// The step the message belongs to.
    pub step: u32,
}

/// Where a UAV is. Made by [`Beacon::new`], so every beacon can be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Beacon {
    header: Header,
    time_ms: u32,
    position: Vec2,
    velocity: [i16; 2],
    tie: i8,
}

impl Beacon {
    /// A beacon of the state measured at `time_ms` of the swarm's common clock.
    ///
    /// What the layout cannot hold becomes the nearest that it can: position ±
    /// [`COORDINATE_LIMIT`], velocity ± 32,767 ticks/step (32 u/step), tie-breaker ±127.
    #[must_use]
    pub fn new(header: Header, time_ms: u32, state: State, tie: i8) -> Self {
        let short = |v: i32| v.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
        Self {
            header,
            time_ms,
            position: Vec2::from_ticks(state.position.x, state.position.y),
            velocity: [short(state.velocity.x), short(state.velocity.y)],
            tie: tie.max(-127),
        }
    }

    /// Who sent it and when.
    #[must_use]
    pub const fn header(&self) -> Header {
        self.header
    }

    /// When the state was measured: ms of the swarm's common clock, which wraps around.
    #[must_use]
    pub const fn time_ms(&self) -> u32 {
        self.time_ms
    }

    /// The measured state, ticks and ticks/step.
    #[must_use]
    pub const fn state(&self) -> State {
        State { position: self.position, velocity: Vec2 { x: self.velocity[0] as i32, y: self.velocity[1] as i32 } }
    }

    /// The tie-breaker of the step, −127 to 127 (see [`crate::random::tie_breaker`]).
    #[must_use]
    pub const fn tie(&self) -> i8 {
        self.tie
    }
}

/// What a UAV's encoder made of its observation. Made by [`Feature::new`], so every
/// feature can be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Feature {
    header: Header,
    degree: u8,
    actor: u32,
    attention_source: i16,
    values: Vec<i8, MAX_FEATURE>,
}

impl Feature {
    /// A feature of 1 to [`MAX_FEATURE`] `values`.
    ///
    /// `degree` is the number of neighbours kept plus one for the sender itself (1 to
    /// [`MAX_DEGREE`]), `actor` the content hash of the policy, `attention_source` the sender's
    /// half of the attention score (0 where the policy has none).
    ///
    /// # Errors
    /// [`MessageError::Degree`] or [`MessageError::Width`] when one is out of range.
    pub fn new(
        header: Header,
        degree: u8,
        actor: u32,
        attention_source: i16,
        values: &[i8],
    ) -> Result<Self, MessageError> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(MessageError::Degree(degree));
        }
        let width = u8::try_from(values.len()).unwrap_or(u8::MAX);
        match Vec::from_slice(values) {
            Ok(values) if !values.is_empty() => Ok(Self { header, degree, actor, attention_source, values }),
            _ => Err(MessageError::Width(width)),
        }
    }

    /// What a UAV with this policy, own feature and degree (itself included, taken as 1 to
    /// [`MAX_DEGREE`]) broadcasts; `None` when the policy uses no features of others.
    #[must_use]
    pub fn of<O: ActorInput>(
        header: Header,
        degree: u8,
        actor: &QuantisedActor<'_, O>,
        own: &actor::Feature,
    ) -> Option<Self> {
        let width = usize::from(PolicyId::of(actor).width);
        let values = own.values.get(..width)?;
        Self::new(header, degree.clamp(1, MAX_DEGREE), actor.message_hash(), own.attention_source, values).ok()
    }

    /// Who sent it and when.
    #[must_use]
    pub const fn header(&self) -> Header {
        self.header
    }

    /// The sender's neighbours kept plus itself, 1 to [`MAX_DEGREE`].
    #[must_use]
    pub const fn degree(&self) -> u8 {
        self.degree
    }

    /// Content hash of the policy that made it: features of two policies do not mix.
    #[must_use]
    pub const fn actor(&self) -> u32 {
        self.actor
    }

    /// The sender's half of the attention score; 0 where the policy has none.
    #[must_use]
    pub const fn attention_source(&self) -> i16 {
        self.attention_source
    }

    /// The values, 1 to [`MAX_FEATURE`] of them.
    #[must_use]
    pub fn values(&self) -> &[i8] {
        &self.values
    }
}

/// A message of either kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Message {
    /// Where a UAV is.
    Beacon(Beacon),
    /// What its encoder made of its observation.
    Feature(Feature),
}

/// Why bytes are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// Fewer bytes than the message says, or than any message has.
    #[error("{len} bytes where the message needs {needed}")]
    TooShort {
        /// Bytes there are.
        len: usize,
        /// Bytes there should be.
        needed: usize,
    },
    /// More bytes than the message says.
    #[error("{len} bytes where the message ends after {needed}")]
    TooLong {
        /// Bytes there are.
        len: usize,
        /// Bytes there should be.
        needed: usize,
    },
    /// Written by a sender of another version.
    #[error("message version {0}, this one reads version {VERSION}: update the older of the two")]
    UnknownVersion(u8),
    /// Neither a beacon nor a feature.
    #[error("unknown message kind {0}")]
    UnknownKind(u8),
    /// A coordinate beyond ±[`COORDINATE_LIMIT`].
    #[error("coordinate {0} is beyond ±{COORDINATE_LIMIT} ticks")]
    Position(i32),
    /// The tie-breaker −128.
    #[error("tie-breaker -128, the least is -127")]
    Tie,
    /// Not 1 to [`MAX_DEGREE`].
    #[error("degree {0} is not 1 to {MAX_DEGREE}")]
    Degree(u8),
    /// Not 1 to [`MAX_FEATURE`] values (more than 255 read as 255).
    #[error("{0} values, a feature has 1 to {MAX_FEATURE}")]
    Width(u8),
}

impl Message {
    /// Who sent it and when.
    #[must_use]
    pub const fn header(&self) -> Header {
        match self {
            Self::Beacon(b) => b.header,
            Self::Feature(f) => f.header,
        }
    }

    /// Writes the message and returns the part of `buffer` that it takes.
    pub fn encode<'b>(&self, buffer: &'b mut [u8; MAX_LEN]) -> &'b [u8] {
        let Header { id, sequence, step } = self.header();
        put(buffer, 0, [VERSION]);
        put(buffer, 2, id.to_le_bytes());
        put(buffer, 4, sequence.to_le_bytes());
        put(buffer, 6, step.to_le_bytes());
        let len = match self {
            Self::Beacon(b) => {
                put(buffer, 1, [KIND_BEACON]);
                put(buffer, 10, b.time_ms.to_le_bytes());
                put(buffer, 14, b.position.x.to_le_bytes());
                put(buffer, 18, b.position.y.to_le_bytes());
                put(buffer, 22, b.velocity[0].to_le_bytes());
                put(buffer, 24, b.velocity[1].to_le_bytes());
                put(buffer, 26, b.tie.to_le_bytes());
                BEACON_LEN
            }
            Self::Feature(f) => {
                put(buffer, 1, [KIND_FEATURE]);
                put(buffer, 10, [f.degree]);
                put(buffer, 11, f.actor.to_le_bytes());
                put(buffer, 15, f.attention_source.to_le_bytes());
                put(buffer, 17, [f.values.len() as u8]);
                for (out, v) in buffer.iter_mut().skip(FEATURE_HEAD_LEN).zip(&f.values) {
                    *out = v.to_le_bytes()[0];
                }
                FEATURE_HEAD_LEN + f.values.len()
            }
        };
        // `len` is at most MAX_LEN, so the default is never taken.
        buffer.get(..len).unwrap_or_default()
    }

    /// Reads a message that fills `bytes`.
    ///
    /// # Errors
    /// The first thing that is wrong, see [`MessageError`].
    pub fn decode(bytes: &[u8]) -> Result<Self, MessageError> {
        let &[version, kind, ..] = bytes else {
            return Err(MessageError::TooShort { len: bytes.len(), needed: 2 });
        };
        if version != VERSION {
            return Err(MessageError::UnknownVersion(version));
        }
        match kind {
            KIND_BEACON => decode_beacon(bytes).map(Self::Beacon),
            KIND_FEATURE => decode_feature(bytes).map(Self::Feature),
            _ => Err(MessageError::UnknownKind(kind)),
        }
    }
}

fn decode_beacon(bytes: &[u8]) -> Result<Beacon, MessageError> {
    expect_len(bytes, BEACON_LEN)?;
    let coordinate = |at| {
        let ticks = i32::from_le_bytes(get(bytes, at));
        let fits = ticks.unsigned_abs() <= COORDINATE_LIMIT.unsigned_abs();
        if fits { Ok(ticks) } else { Err(MessageError::Position(ticks)) }
    };
    let position = Vec2 { x: coordinate(14)?, y: coordinate(18)? };
    let velocity = [i16::from_le_bytes(get(bytes, 22)), i16::from_le_bytes(get(bytes, 24))];
    let tie = i8::from_le_bytes(get(bytes, 26));
    if tie == i8::MIN {
        return Err(MessageError::Tie);
    }
    Ok(Beacon { header: decode_header(bytes), time_ms: u32::from_le_bytes(get(bytes, 10)), position, velocity, tie })
}

fn decode_feature(bytes: &[u8]) -> Result<Feature, MessageError> {
    let Some((head, values)) = bytes.split_at_checked(FEATURE_HEAD_LEN) else {
        return Err(MessageError::TooShort { len: bytes.len(), needed: FEATURE_HEAD_LEN });
    };
    let [width] = get(head, 17);
    if !(1..=MAX_FEATURE).contains(&usize::from(width)) {
        return Err(MessageError::Width(width));
    }
    expect_len(bytes, FEATURE_HEAD_LEN + usize::from(width))?;
    let [degree] = get(head, 10);
    let mut signed = [0i8; MAX_FEATURE];
    for (out, &v) in signed.iter_mut().zip(values) {
        *out = i8::from_le_bytes([v]);
    }
    let signed = signed.get(..values.len()).unwrap_or_default();
    let (actor, attention_source) = (u32::from_le_bytes(get(head, 11)), i16::from_le_bytes(get(head, 15)));
    Feature::new(decode_header(head), degree, actor, attention_source, signed)
}

fn decode_header(bytes: &[u8]) -> Header {
    Header {
        id: u16::from_le_bytes(get(bytes, 2)),
        sequence: u16::from_le_bytes(get(bytes, 4)),
        step: u32::from_le_bytes(get(bytes, 6)),
    }
}

fn expect_len(bytes: &[u8], needed: usize) -> Result<(), MessageError> {
    let len = bytes.len();
    match len.cmp(&needed) {
        core::cmp::Ordering::Less => Err(MessageError::TooShort { len, needed }),
        core::cmp::Ordering::Equal => Ok(()),
        core::cmp::Ordering::Greater => Err(MessageError::TooLong { len, needed }),
    }
}

/// Writes a field at a byte offset; what would lie outside is left out.
fn put<const N: usize>(buffer: &mut [u8], at: usize, field: [u8; N]) {
    for (out, b) in buffer.iter_mut().skip(at).zip(field) {
        *out = b;
    }
}

/// Reads a field at a byte offset; what would lie outside reads as 0. Lengths are
/// checked before, so neither happens.
fn get<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let mut field = [0; N];
    for (out, &b) in field.iter_mut().zip(bytes.iter().skip(at)) {
        *out = b;
    }
    field
}
