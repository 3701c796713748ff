//! The link between the UAVs of a swarm: neighbour messages inside MAVLink frames.
//!
//! Each message travels in a V2_EXTENSION (#248) of its own, to everybody, with the message type
//! [`MESSAGE_TYPE`]. The frame's system id is the sender's id plus one, and the id in the message
//! must agree with it. [`SwarmLink`] wraps, unwraps and judges; [`SwarmSocket`] moves the
//! datagrams by multicast, broadcast or to a list of peers.

mod address;
mod socket;

pub use address::{SwarmAddress, SwarmAddressError};
pub use socket::SwarmSocket;

use crate::frame::{Counts, EncodeError, Encoder, Frame, Reader, Rejected, Source};
use crate::signing::{LinkSigning, Session, SigningError, Timestamp};
use firmware_core::message::{self, BEACON_LEN, FEATURE_HEAD_LEN, Message, MessageError};
use std::collections::VecDeque;
use thiserror::Error;

/// The message type of neighbour messages in V2_EXTENSION. Types from 32768 on are for private
/// use.
pub const MESSAGE_TYPE: u16 = 0xC056;
/// The sending component: MAV_COMP_ID_ONBOARD_COMPUTER.
pub const COMPONENT: u8 = 191;
/// The highest id of a UAV that can take part: MAVLink's system ids end at 255.
pub const MAX_ID: u16 = 254;

/// V2_EXTENSION.
const V2_EXTENSION: u32 = 248;
/// Message type, target network, system and component.
const EXTENSION_HEAD: usize = 5;
/// How many of our own frames are remembered, to know them when they come back.
const REMEMBERED: usize = 64;
/// Offsets in a neighbour message (docs/messages.md).
const KIND: usize = 1;
const WIDTH: usize = 17;
/// The kind of a feature.
const FEATURE: u8 = 2;

/// Why a neighbour message was not sent, or cannot be.
#[derive(Debug, Error)]
pub enum SwarmError {
    /// MAVLink has no system id for it.
    #[error("id {0} cannot fly over MAVLink: ids go up to {MAX_ID}")]
    Id(u16),
    /// The frame could not be made.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// The frame could not be signed.
    #[error(transparent)]
    Sign(#[from] SigningError),
}

/// A message that a neighbour sent.
#[derive(Clone, Debug)]
pub struct Neighbour {
    /// The message.
    pub message: Message,
    /// The frame it came in.
    pub frame: Frame,
}

/// One UAV's end of the swarm link, without the socket.
#[derive(Debug)]
pub struct SwarmLink {
    encoder: Encoder,
    signing: LinkSigning,
    reader: Reader,
    sent: VecDeque<Frame>,
    counts: Counts,
}

/// The MAVLink system id of a UAV; `None` above [`MAX_ID`].
#[must_use]
pub fn system_of(id: u16) -> Option<u8> {
    u8::try_from(id).ok()?.checked_add(1)
}

impl SwarmLink {
    /// The end of the UAV with this id.
    ///
    /// # Errors
    /// [`SwarmError::Id`] above [`MAX_ID`].
    pub fn new(id: u16, signing: LinkSigning) -> Result<Self, SwarmError> {
        let system = system_of(id).ok_or(SwarmError::Id(id))?;
        Ok(Self {
            encoder: Encoder::new(system, COMPONENT),
            signing,
            reader: Reader::new(Source::Datagrams),
            sent: VecDeque::with_capacity(REMEMBERED),
            counts: Counts::new(),
        })
    }

    /// The frame that carries a message of this UAV to all others, signed where the link is.
    ///
    /// # Errors
    /// See [`SwarmError`].
    pub fn wrap(&mut self, message: &Message, session: &mut Session, now: Timestamp) -> Result<Frame, SwarmError> {
        let mut buffer = [0; message::MAX_LEN];
        let bytes = message.encode(&mut buffer);
        let mut payload = [0; EXTENSION_HEAD + message::MAX_LEN];
        payload[..2].copy_from_slice(&MESSAGE_TYPE.to_le_bytes());
        payload[EXTENSION_HEAD..EXTENSION_HEAD + bytes.len()].copy_from_slice(bytes);
        let frame = self.encoder.encode_payload(V2_EXTENSION, &payload[..EXTENSION_HEAD + bytes.len()])?;
        let frame = session.seal(&self.signing, frame, now)?;
        if self.sent.len() == REMEMBERED {
            self.sent.pop_front();
        }
        self.sent.push_back(frame);
        Ok(frame)
    }

    /// Adds a datagram from the swarm; then take its messages with [`Self::next_message`].
    pub fn push(&mut self, datagram: &[u8]) {
        self.reader.push(datagram);
    }

    /// The next message of a neighbour. What is none is counted and passed over.
    pub fn next_message(&mut self, session: &mut Session, now: Timestamp) -> Option<Neighbour> {
        while let Some(frame) = self.reader.next_frame() {
            match self.unwrap(&frame, session, now) {
                Ok(message) => return Some(Neighbour { message, frame }),
                Err(reason) => self.counts.count(reason),
            }
        }
        None
    }

    /// What was not used, by reason. [`Rejected::IdCollision`] means that somebody else flies
    /// with our id.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let mut counts = self.counts;
        counts += self.reader.counts();
        counts
    }

    fn unwrap(&self, frame: &Frame, session: &mut Session, now: Timestamp) -> Result<Message, Rejected> {
        let ours = frame.system() == self.encoder.system();
        if ours && self.sent.contains(frame) {
            return Err(Rejected::OwnEcho);
        }
        session.check(&self.signing, frame, now)?;
        if ours {
            return Err(Rejected::IdCollision);
        }
        let bytes = neighbour_bytes(frame, self.encoder.system())?;
        let message = Message::decode(&bytes).map_err(|error| match error {
            MessageError::UnknownVersion(_) => Rejected::OtherVersion,
            _ => Rejected::Malformed,
        })?;
        if system_of(message.header().id) == Some(frame.system()) { Ok(message) } else { Err(Rejected::SpoofedId) }
    }
}

/// The neighbour message that a frame of anybody carries, if it carries one.
#[must_use]
pub fn neighbour_message(frame: &Frame) -> Option<Message> {
    Message::decode(&neighbour_bytes(frame, 0).ok()?).ok()
}

/// The neighbour message in a frame. MAVLink leaves out zeros at the end of a payload, so the
/// length is what the message's own head says.
fn neighbour_bytes(frame: &Frame, own: u8) -> Result<Vec<u8>, Rejected> {
    let (head, body) = frame.payload().split_at(frame.payload().len().min(EXTENSION_HEAD));
    if frame.message_id() != V2_EXTENSION || head.get(..2) != Some(&MESSAGE_TYPE.to_le_bytes()) {
        return Err(Rejected::NotNeighbour);
    }
    let at = |i: usize| head.get(i).copied().unwrap_or(0);
    if at(2) != 0 || (at(3) != 0 && at(3) != own) {
        return Err(Rejected::Addressed);
    }
    let used = body.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
    let byte = |i: usize| body.get(i).copied().unwrap_or(0);
    let len = match byte(KIND) {
        FEATURE => FEATURE_HEAD_LEN + usize::from(byte(WIDTH)),
        _ => BEACON_LEN,
    };
    if used > len {
        return Err(Rejected::Malformed);
    }
    let mut bytes = body[..used].to_vec();
    bytes.resize(len, 0);
    Ok(bytes)
}
