//! The PIL protocol: how a host flies an actor on a board over a serial line.
//!
//! The host asks, the board answers: the host passes on what a UAV measures and hears,
//! the board keeps the neighbour table, encodes and decides. So the very code and
//! processor that will fly can be driven by a simulation (processor in the loop) or by a
//! companion computer.
//!
//! ```text
//! host                                       board
//!  Hello(seed, id, …)               ──▶  ◀── Report: software, actor, self-test
//!  Hear(neighbour message)          ──▶  ◀── Heard: what the table made of it
//!  Observe(own state, PoIs)         ──▶  ◀── Observed: the feature message to broadcast
//!  Hear(neighbour's feature)        ──▶  ◀── Heard
//!  Decide(step)                     ──▶  ◀── Decided: action and logits
//!  Status, SelfTest, Sign           ──▶  ◀── Status, Report, Signature
//! ```
//!
//! The line may lose, damage or invent bytes. Frames carry a CRC-32 and a tag that the answer
//! repeats; bad ones are counted and get no answer. Every request may be sent again when its
//! answer is missing: a second one does no harm. `docs/pil.md` describes every byte.

mod frame;
mod node;
mod record;
mod server;

pub use frame::{Deframer, FrameError, frame_len, seal, unseal};
pub use record::{
    ActorInfo, Counters, Decided, Fault, Hear, Observe, Observed, Refusal, Reply, Report, Request, Setup, Status,
};
pub use server::Server;

/// Version of the protocol, the first byte of every frame.
pub const VERSION: u8 = 1;
/// Tag of what a board sends unasked: its report when it starts.
pub const UNASKED: u8 = 0;
/// PoIs in view that one request can hold; the scenario has 120 in all.
pub const MAX_POIS: usize = 240;
/// Bytes of one PoI in a request: its offset from the UAV, x and y as i16 little-endian ticks.
pub const POI_BYTES: usize = 4;
/// Greatest length of a request (version, tag and record), bytes.
pub const MAX_REQUEST: usize = 1024;
/// Greatest length of an answer (version, tag and record), bytes.
pub const MAX_REPLY: usize = 128;
/// Greatest number of cases that one [`Request::Sign`] adds to the signature.
pub const MAX_CASES: u16 = 1000;
