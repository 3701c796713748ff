//! One frame and where its fields lie.

use super::checksum::{checksum, crc_extra};
use crate::signing::Timestamp;
use mavlink::dialects::common::MavMessage;
use mavlink::error::ParserError;
use mavlink::{MavlinkVersion, Message as _};
use std::fmt;

/// Length of the longest frame, bytes: MAVLink 2 with a full payload and a signature.
pub const MAX_LEN: usize = HEADER_V2 + 255 + CHECKSUM + SIGNATURE;
/// Length of a signature: link id, timestamp and code, bytes.
pub const SIGNATURE: usize = 13;

pub(super) const MAGIC_V1: u8 = 0xFE;
pub(super) const MAGIC_V2: u8 = 0xFD;
pub(super) const HEADER_V1: usize = 6;
pub(super) const HEADER_V2: usize = 10;
pub(super) const CHECKSUM: usize = 2;
/// The one incompatibility flag there is: a signature follows.
pub(super) const FLAG_SIGNED: u8 = 1;

/// The two versions of MAVLink's framing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// MAVLink 1: message ids up to 255, no signatures.
    V1,
    /// MAVLink 2.
    V2,
}

/// One complete frame, as on the wire.
///
/// Its checksum is right, or could not be verified (see [`Frame::is_checked`]). Its signature is
/// verified by [`crate::signing::Session::verify`].
#[derive(Clone, Copy)]
pub struct Frame {
    pub(super) bytes: [u8; MAX_LEN],
    pub(super) len: usize,
    pub(super) checked: bool,
}

/// The signature at the end of a signed frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signature {
    /// The sender's link id.
    pub link_id: u8,
    /// When it was signed, by the sender's clock.
    pub timestamp: Timestamp,
    /// The first 48 bits of SHA-256 over key, frame, link id and timestamp.
    pub code: [u8; 6],
}

impl Frame {
    /// MAVLink 1 or 2.
    #[must_use]
    pub const fn version(&self) -> Version {
        if self.bytes[0] == MAGIC_V1 { Version::V1 } else { Version::V2 }
    }

    /// The sending system.
    #[must_use]
    pub const fn system(&self) -> u8 {
        match self.version() {
            Version::V1 => self.bytes[3],
            Version::V2 => self.bytes[5],
        }
    }

    /// The sending component.
    #[must_use]
    pub const fn component(&self) -> u8 {
        match self.version() {
            Version::V1 => self.bytes[4],
            Version::V2 => self.bytes[6],
        }
    }

    /// The sender's sequence number, which wraps around.
    #[must_use]
    pub const fn sequence(&self) -> u8 {
        match self.version() {
            Version::V1 => self.bytes[2],
            Version::V2 => self.bytes[4],
        }
    }

    /// The message id, 0 to 2²⁴ − 1.
    #[must_use]
    pub const fn message_id(&self) -> u32 {
        message_id(&self.bytes)
    }

    /// The payload as it was sent: MAVLink 2 truncates zeros at its end.
    #[must_use]
    pub fn payload(&self) -> &[u8] {
        let header = self.header_len();
        &self.bytes[header..header + usize::from(self.bytes[1])]
    }

    /// The bytes of the frame, signature included.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }

    /// Whether its checksum was verified. It cannot be for a message of an unknown dialect, whose
    /// CRC_EXTRA is not known.
    #[must_use]
    pub const fn is_checked(&self) -> bool {
        self.checked
    }

    /// Whether it carries a signature, right or wrong.
    #[must_use]
    pub const fn is_signed(&self) -> bool {
        matches!(self.version(), Version::V2) && self.bytes[2] & FLAG_SIGNED != 0
    }

    /// The signature, when there is one.
    #[must_use]
    pub fn signature(&self) -> Option<Signature> {
        let &[link_id, t0, t1, t2, t3, t4, t5, ref code @ ..] = self.signature_bytes()?;
        let timestamp = Timestamp::from_ticks(u64::from_le_bytes([t0, t1, t2, t3, t4, t5, 0, 0]));
        Some(Signature { link_id, timestamp, code: *code })
    }

    /// Decodes the payload by the common message set. Extension fields are ignored.
    ///
    /// # Errors
    /// The message is not in the common set, or a field holds a value that its enumeration does
    /// not have: newer dialects have more. Where that must not cost the message, as of a
    /// HEARTBEAT, read the fields from [`Frame::payload`].
    pub fn message(&self) -> Result<MavMessage, ParserError> {
        MavMessage::parse(self.version().into(), self.message_id(), self.payload())
    }

    /// The part of the frame that a signature covers: header, payload and checksum.
    pub(crate) fn signed_part(&self) -> &[u8] {
        let end = self.len - if self.is_signed() { SIGNATURE } else { 0 };
        &self.bytes[..end]
    }

    /// The same frame with the flag of a signature, a fitting checksum and these bytes at its
    /// end. `None` of a MAVLink 1 frame, of a signed one, and of one whose checksum cannot be
    /// known.
    pub(crate) fn signed_with(mut self, signature: impl FnOnce(&[u8]) -> [u8; SIGNATURE]) -> Option<Self> {
        let extra = crc_extra(self.message_id())?;
        if self.version() == Version::V1 || self.is_signed() {
            return None;
        }
        self.bytes[2] |= FLAG_SIGNED;
        let at = self.len - CHECKSUM;
        let sum = checksum(&self.bytes[1..at], extra);
        self.bytes[at..self.len].copy_from_slice(&sum.to_le_bytes());
        let signature = signature(&self.bytes[..self.len]);
        self.bytes[self.len..self.len + SIGNATURE].copy_from_slice(&signature);
        self.len += SIGNATURE;
        Some(self)
    }

    pub(crate) fn signature_bytes(&self) -> Option<&[u8; SIGNATURE]> {
        if self.is_signed() { self.bytes().last_chunk() } else { None }
    }

    const fn header_len(&self) -> usize {
        match self.version() {
            Version::V1 => HEADER_V1,
            Version::V2 => HEADER_V2,
        }
    }
}

/// The message id in the header of a frame; `bytes` hold one.
pub(super) const fn message_id(bytes: &[u8]) -> u32 {
    match bytes[0] {
        MAGIC_V1 => bytes[5] as u32,
        _ => u32::from_le_bytes([bytes[7], bytes[8], bytes[9], 0]),
    }
}

/// Prints the header without the payload: that of SETUP_SIGNING holds a key.
impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Frame")
            .field("version", &self.version())
            .field("system", &self.system())
            .field("component", &self.component())
            .field("sequence", &self.sequence())
            .field("message_id", &self.message_id())
            .field("payload_len", &self.payload().len())
            .field("signed", &self.is_signed())
            .finish()
    }
}

impl PartialEq for Frame {
    fn eq(&self, other: &Self) -> bool {
        self.bytes() == other.bytes()
    }
}

impl Eq for Frame {}

impl From<Version> for MavlinkVersion {
    fn from(version: Version) -> Self {
        match version {
            Version::V1 => Self::V1,
            Version::V2 => Self::V2,
        }
    }
}
