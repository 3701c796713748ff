//! The wire: frames, signatures, connections, the swarm link and recordings, through their
//! public interfaces.

mod connections;
mod forgery;
mod frames;
mod keys;
mod signing;
mod strings;
mod swarm;
mod tlogs;

use mavlink::dialects::common::{GLOBAL_POSITION_INT_DATA, MavMessage};
use sitl_bridge::frame::{Encoder, Frame, Reader, Source};

/// A position message, all fields different from zero.
fn position(time_boot_ms: u32) -> MavMessage {
    MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
        time_boot_ms,
        lat: 473_977_418,
        lon: 85_455_939,
        alt: 488_000,
        relative_alt: 10_000,
        vx: -120,
        vy: 250,
        vz: 3,
        hdg: 9_000,
    })
}

/// The frame of a position message from system 1, component 1.
fn frame(time_boot_ms: u32) -> Frame {
    Encoder::new(1, 1).encode(&position(time_boot_ms)).expect("a frame")
}

/// All frames of one datagram.
fn read(datagram: &[u8]) -> (Vec<Frame>, Reader) {
    let mut reader = Reader::new(Source::Datagrams);
    reader.push(datagram);
    (std::iter::from_fn(|| reader.next_frame()).collect(), reader)
}
