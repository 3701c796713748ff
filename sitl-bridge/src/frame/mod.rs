//! MAVLink framing, versions 1 and 2: parsing, looking into and making frames.
//!
//! [`Reader`] finds frames in datagrams or in a stream, [`Encoder`] makes them. [`Frame::message`]
//! decodes the payload by the types of the `mavlink` crate. The framing itself is implemented here,
//! because a flipped bit in front of a frame must never cost that frame.

mod checksum;
mod encoder;
mod layout;
mod reader;
mod rejected;

pub use checksum::crc_extra;
pub use encoder::{EncodeError, Encoder};
pub use layout::{Frame, MAX_LEN, SIGNATURE, Signature, Version};
pub(crate) use reader::{NoFrame, parse};
pub use reader::{Reader, Source};
pub use rejected::{Counts, Rejected};
