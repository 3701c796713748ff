//! The two messages that UAVs of one swarm send each other.
//!
//! A [`Beacon`] tells where its sender is; it comes just before a step and as often as
//! the radio allows. A [`FeatureMessage`] carries what the sender's encoder made of its
//! observation, once a step. Both have a fixed little-endian layout, described byte by
//! byte in `docs/messages.md`, and exactly one form: two different byte strings never
//! mean the same. There is no checksum inside; the transport that carries them has one.

mod beacon;
mod codec;
mod error;
mod feature;
mod header;

pub use beacon::Beacon;
pub use codec::{BEACON_LEN, FEATURE_HEAD_LEN, MAX_LEN, Message};
pub use error::MessageError;
pub use feature::FeatureMessage;
pub use header::{Header, VERSION};
