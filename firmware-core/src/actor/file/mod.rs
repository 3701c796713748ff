//! The actor file: one postcard record in a checked envelope, read in place.
//!
//! ```text
//! 0   8  magic "COVEYACT"
//! 8   2  format version, u16 little-endian (1)
//! 10  2  zero
//! 12  4  length n of the body, u32 little-endian
//! 16  n  body: postcard, see [`Body`]
//! 16+n 4 CRC-32 (ISO-HDLC) of all bytes before, little-endian
//! ```
//!
//! `docs/actor-file.md` describes every field.

mod body;
mod envelope;
mod error;
mod load;
mod store;

pub use body::Body;
pub use envelope::{HEADER, MAGIC, TRAILER, VERSION, at_start_of};
pub use error::{LoadError, StoreError};
