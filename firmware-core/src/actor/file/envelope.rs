//! The envelope of an actor file: magic, version, length and checksum.

use crc::{CRC_32_ISO_HDLC, Crc};

/// First bytes of every actor file.
pub const MAGIC: [u8; 8] = *b"COVEYACT";
/// Format version that this code reads and writes.
pub const VERSION: u16 = 1;
/// Bytes before the body.
pub const HEADER: usize = 16;
/// Bytes after the body.
pub const TRAILER: usize = 4;

pub(super) const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The actor file at the start of a flash region: as much of it as the file's header says. A
/// region that holds no whole actor file comes back as it is, and loading says what is wrong.
#[must_use]
pub fn at_start_of(region: &[u8]) -> &[u8] {
    let &[.., n0, n1, n2, n3] = region.first_chunk::<HEADER>().unwrap_or(&[0xff; HEADER]);
    let length = (u32::from_le_bytes([n0, n1, n2, n3]) as usize).saturating_add(HEADER + TRAILER);
    region.get(..length).unwrap_or(region)
}
