//! V2_EXTENSION: a message of a private type inside a MAVLink frame.

use super::fields::Fields;

/// `message_type`, `target_network`, `target_system` and `target_component`, bytes.
const HEAD: usize = 5;

/// V2_EXTENSION (248).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct V2Extension<'a> {
    /// Type of the message in the body; types from 32768 on are for private use.
    pub message_type: u16,
    /// Network that it is addressed to, 0 for all.
    pub target_network: u8,
    /// System that it is addressed to, 0 for all.
    pub target_system: u8,
    /// The message itself, without the zeros at its end that MAVLink 2 leaves out.
    pub body: &'a [u8],
}

impl<'a> V2Extension<'a> {
    /// Reads a payload of message [`super::id::V2_EXTENSION`].
    #[must_use]
    pub fn read(payload: &'a [u8]) -> Self {
        let fields = Fields(payload);
        let body = payload.get(HEAD..).unwrap_or_default();
        let used = body.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
        Self {
            message_type: fields.u16(0),
            target_network: fields.u8(2),
            target_system: fields.u8(3),
            body: &body[..used],
        }
    }

    /// A payload with this body for all networks, systems and components.
    #[must_use]
    pub fn broadcast(message_type: u16, body: &[u8]) -> Vec<u8> {
        let mut payload = message_type.to_le_bytes().to_vec();
        payload.resize(HEAD, 0);
        payload.extend_from_slice(body);
        payload
    }
}
