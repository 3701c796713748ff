//! The protocol's version and limits.

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
/// Greatest number of cases that one [`Request::Sign`](super::Request::Sign) adds to the signature.
pub const MAX_CASES: u16 = 1000;
