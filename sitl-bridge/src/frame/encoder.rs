//! Encoding frames.

use super::checksum::{checksum, crc_extra};
use super::layout::{CHECKSUM, Frame, HEADER_V1, HEADER_V2, MAGIC_V1, MAGIC_V2, MAX_LEN, Version};
use mavlink::Message as _;
use mavlink::dialects::common::MavMessage;
use thiserror::Error;

/// Why a message cannot be encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// MAVLink 1 has one byte for the message's id. Cutting the id would send another message:
    /// SETUP_SIGNING (256), with its key, would go out as a HEARTBEAT.
    #[error("message {0} needs MAVLink 2: ids above 255 do not fit into a MAVLink 1 frame")]
    NeedsVersion2(u32),
    /// Its CRC_EXTRA is not known, so no checksum can be computed.
    #[error("message {0} is in neither the common message set nor ArduPilot's")]
    UnknownMessage(u32),
    /// The payload is longer than a frame can hold.
    #[error("{0} bytes of payload, a frame holds 255")]
    TooLong(usize),
}

/// Encodes the frames of one component on one link, unsigned, each with the next sequence number.
#[derive(Clone, Debug)]
pub struct Encoder {
    version: Version,
    system: u8,
    component: u8,
    sequence: u8,
}

impl Encoder {
    /// MAVLink 2 frames from this component of this system; the first has sequence number 0.
    #[must_use]
    pub const fn new(system: u8, component: u8) -> Self {
        Self { version: Version::V2, system, component, sequence: 0 }
    }

    /// The same with another version.
    #[must_use]
    pub const fn with_version(mut self, version: Version) -> Self {
        self.version = version;
        self
    }

    /// The sending system.
    #[must_use]
    pub const fn system(&self) -> u8 {
        self.system
    }

    /// A frame with this message.
    ///
    /// # Errors
    /// See [`EncodeError`].
    pub fn encode(&mut self, message: &MavMessage) -> Result<Frame, EncodeError> {
        // As long as the longest message, which `ser` requires.
        let mut payload = [0; 255];
        let len = message.ser(self.version.into(), &mut payload);
        self.encode_payload(message.message_id(), &payload[..len])
    }

    /// A frame with this payload, whose fields are in the order of the wire. In MAVLink 2 zeros
    /// at its end are left out.
    ///
    /// # Errors
    /// See [`EncodeError`].
    pub fn encode_payload(&mut self, message_id: u32, payload: &[u8]) -> Result<Frame, EncodeError> {
        let extra = crc_extra(message_id).ok_or(EncodeError::UnknownMessage(message_id))?;
        let id = message_id.to_le_bytes();
        let (system, component, sequence) = (self.system, self.component, self.sequence);
        let mut bytes = [0; MAX_LEN];
        let (header, payload) = match self.version {
            Version::V1 if message_id > 255 => return Err(EncodeError::NeedsVersion2(message_id)),
            Version::V1 => {
                bytes[..HEADER_V1].copy_from_slice(&[MAGIC_V1, 0, sequence, system, component, id[0]]);
                (HEADER_V1, payload)
            }
            Version::V2 => {
                let header = [MAGIC_V2, 0, 0, 0, sequence, system, component, id[0], id[1], id[2]];
                bytes[..HEADER_V2].copy_from_slice(&header);
                // At least one byte stays.
                let used = payload.iter().rposition(|&b| b != 0).unwrap_or(0) + 1;
                (HEADER_V2, &payload[..used.min(payload.len())])
            }
        };
        bytes[1] = u8::try_from(payload.len()).map_err(|_| EncodeError::TooLong(payload.len()))?;
        let end = header + payload.len();
        bytes[header..end].copy_from_slice(payload);
        let sum = checksum(&bytes[1..end], extra);
        bytes[end..end + CHECKSUM].copy_from_slice(&sum.to_le_bytes());
        self.sequence = self.sequence.wrapping_add(1);
        Ok(Frame { bytes, len: end + CHECKSUM, checked: true })
    }
}
