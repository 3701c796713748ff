//! Neighbour messages inside V2_EXTENSION.

use crate::frame::{Frame, Rejected};
use crate::messages::{V2Extension, id};
use firmware_core::message::{BEACON_LEN, FEATURE_HEAD_LEN, Message};

/// The message type of neighbour messages in V2_EXTENSION. Types from 32768 on are for private
/// use.
pub const MESSAGE_TYPE: u16 = 0xC056;
/// The sending component: MAV_COMP_ID_ONBOARD_COMPUTER.
pub const COMPONENT: u8 = 191;
/// The highest id of a UAV that can take part: MAVLink's system ids end at 255.
pub const MAX_ID: u16 = 254;

/// Offsets in a neighbour message (docs/messages.md).
const KIND: usize = 1;
const WIDTH: usize = 17;
/// The kind of a feature.
const FEATURE: u8 = 2;

/// The MAVLink system id of a UAV; `None` above [`MAX_ID`].
#[must_use]
pub fn system_of(id: u16) -> Option<u8> {
    u8::try_from(id).ok()?.checked_add(1)
}

/// The neighbour message in a frame of any sender, addressed to all; `None` when it carries none.
#[must_use]
pub fn neighbour_message(frame: &Frame) -> Option<Message> {
    Message::decode(&neighbour_bytes(frame, 0).ok()?).ok()
}

/// Whether a frame carries a neighbour message, sound or not.
#[must_use]
pub fn is_neighbour(frame: &Frame) -> bool {
    frame.message_id() == id::V2_EXTENSION && V2Extension::read(frame.payload()).message_type == MESSAGE_TYPE
}

/// The neighbour message in a frame that system `own` received. MAVLink 2 leaves out zeros at the
/// end of a payload, so the length follows from the message's own head.
pub(super) fn neighbour_bytes(frame: &Frame, own: u8) -> Result<Vec<u8>, Rejected> {
    if !is_neighbour(frame) {
        return Err(Rejected::NotNeighbour);
    }
    let extension = V2Extension::read(frame.payload());
    if extension.target_network != 0 || (extension.target_system != 0 && extension.target_system != own) {
        return Err(Rejected::Addressed);
    }
    let byte = |i: usize| extension.body.get(i).copied().unwrap_or(0);
    let len = match byte(KIND) {
        FEATURE => FEATURE_HEAD_LEN + usize::from(byte(WIDTH)),
        _ => BEACON_LEN,
    };
    if extension.body.len() > len {
        return Err(Rejected::Malformed);
    }
    let mut bytes = extension.body.to_vec();
    bytes.resize(len, 0);
    Ok(bytes)
}
