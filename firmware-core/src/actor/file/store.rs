//! Writing an actor file.

use super::body::Body;
use super::envelope::{CRC, HEADER, MAGIC, TRAILER, VERSION};
use super::error::StoreError;

impl Body<'_> {
    /// Writes the file into `out` and returns its length. `align` and `content_hash` are
    /// set here.
    ///
    /// # Errors
    /// [`StoreError::Full`] when `out` is too small.
    pub fn store(&self, out: &mut [u8]) -> Result<usize, StoreError> {
        let mut body = Body { content_hash: self.content_hash(), ..*self };
        // The weights follow the padding, its length byte and their own length.
        let length_bytes = varint_bytes(self.weights.len());
        body.align = [0u8; 3].get(..(4 - (HEADER + 1 + length_bytes) % 4) % 4).unwrap_or(&[]);
        let room = out.get_mut(HEADER..).ok_or(StoreError::Full)?;
        let n = postcard::to_slice(&body, room).map_err(|_| StoreError::Full)?.len();
        let (head, _) = out.split_at_mut_checked(HEADER).ok_or(StoreError::Full)?;
        let fields = MAGIC
            .into_iter()
            .chain(VERSION.to_le_bytes())
            .chain([0, 0])
            .chain(u32::try_from(n).map_err(|_| StoreError::Full)?.to_le_bytes());
        for (place, byte) in head.iter_mut().zip(fields) {
            *place = byte;
        }
        let sum = CRC.checksum(out.get(..HEADER + n).ok_or(StoreError::Full)?);
        out.get_mut(HEADER + n..HEADER + n + TRAILER).ok_or(StoreError::Full)?.copy_from_slice(&sum.to_le_bytes());
        Ok(HEADER + n + TRAILER)
    }
}

const fn varint_bytes(mut n: usize) -> usize {
    let mut bytes = 1;
    while n >= 128 {
        n >>= 7;
        bytes += 1;
    }
    bytes
}
