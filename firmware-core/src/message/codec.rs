//! Messages as bytes.

use super::beacon::Beacon;
use super::error::MessageError;
use super::feature::FeatureMessage;
use super::header::{Header, VERSION};
use crate::actor::MAX_FEATURE;
use crate::geometry::{COORDINATE_LIMIT, Vec2};
use core::cmp::Ordering;

/// Length of a beacon, bytes.
pub const BEACON_LEN: usize = 27;
/// Length of a feature without its values, bytes.
pub const FEATURE_HEAD_LEN: usize = 18;
/// Length of the longest message, bytes.
pub const MAX_LEN: usize = FEATURE_HEAD_LEN + MAX_FEATURE;

const KIND_BEACON: u8 = 1;
const KIND_FEATURE: u8 = 2;

/// A message of either kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Message {
    /// Where a UAV is.
    Beacon(Beacon),
    /// What its encoder made of its observation.
    Feature(FeatureMessage),
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

fn decode_feature(bytes: &[u8]) -> Result<FeatureMessage, MessageError> {
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
    FeatureMessage::new(decode_header(head), degree, actor, attention_source, signed)
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
        Ordering::Less => Err(MessageError::TooShort { len, needed }),
        Ordering::Equal => Ok(()),
        Ordering::Greater => Err(MessageError::TooLong { len, needed }),
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
