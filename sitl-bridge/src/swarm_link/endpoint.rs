//! One UAV's end of the swarm link: wraps its messages into frames and unwraps those of others.

use super::extension::{COMPONENT, MAX_ID, MESSAGE_TYPE, neighbour_bytes, system_of};
use crate::frame::{Counts, EncodeError, Encoder, Frame, Reader, Rejected, Source};
use crate::messages::{V2Extension, id};
use crate::signing::{LinkSigning, Session, SigningError, Timestamp};
use firmware_core::message::{self, Message, MessageError};
use std::collections::VecDeque;
use thiserror::Error;

/// How many of our own frames are remembered, to recognise them when multicast or broadcast loops
/// them back.
const REMEMBERED: usize = 64;

/// Why a neighbour message cannot be sent.
#[derive(Debug, Error)]
pub enum SwarmError {
    /// The UAV's id has no MAVLink system id.
    #[error("id {0} cannot fly over MAVLink: ids go up to {MAX_ID}")]
    Id(u16),
    /// The frame could not be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// The frame could not be signed.
    #[error(transparent)]
    Sign(#[from] SigningError),
}

/// A message of a neighbour.
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
        let payload = V2Extension::broadcast(MESSAGE_TYPE, bytes);
        let frame = self.encoder.encode_payload(id::V2_EXTENSION, &payload)?;
        let frame = session.sign(&self.signing, frame, now)?;
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

    /// The next message of a neighbour. Rejected frames are counted and skipped.
    pub fn next_message(&mut self, session: &mut Session, now: Timestamp) -> Option<Neighbour> {
        while let Some(frame) = self.reader.next_frame() {
            match self.unwrap(&frame, session, now) {
                Ok(message) => return Some(Neighbour { message, frame }),
                Err(reason) => self.counts.count(reason),
            }
        }
        None
    }

    /// Rejected frames and bytes, by reason. [`Rejected::IdCollision`] means that another UAV flies with
    /// the own id.
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
        session.verify(&self.signing, frame, now)?;
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
