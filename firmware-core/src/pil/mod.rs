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

mod error;
mod frame;
mod limits;
mod node;
mod reply;
mod request;
mod server;
mod status;

pub use error::{ActorError, RequestError};
pub use frame::{Deframer, FrameError, decode_frame, encode_frame, frame_len};
pub use limits::{MAX_CASES, MAX_POIS, MAX_REPLY, MAX_REQUEST, POI_BYTES, UNASKED, VERSION};
pub use reply::{ActorInfo, Decided, Observed, Reply, Report};
pub use request::{Hear, Observe, Request, Setup};
pub use server::Server;
pub use status::{Counters, Status};
