//! Little-endian fields of a payload, in the order of the wire.

/// Length of the longest payload that a node sends (SET_POSITION_TARGET_LOCAL_NED), bytes.
const LONGEST: usize = 53;

/// A payload to send, its fields in the order of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Payload {
    /// Message id.
    pub id: u32,
    bytes: [u8; LONGEST],
    len: usize,
}

impl Payload {
    /// The payload's bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }

    /// An empty payload of message `id`.
    pub(super) const fn new(id: u32) -> Self {
        Self { id, bytes: [0; LONGEST], len: 0 }
    }

    /// Appends the bytes of a field; all of them together must fit.
    pub(super) fn put(&mut self, field: &[u8]) {
        let end = self.len + field.len();
        self.bytes[self.len..end].copy_from_slice(field);
        self.len = end;
    }
}

/// Reads the fields of a received payload. What lies beyond its end is zero: MAVLink 2 leaves out
/// zeros at the end.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl Fields<'_> {
    /// The `N` bytes at offset `at`.
    pub(super) fn get<const N: usize>(self, at: usize) -> [u8; N] {
        let mut field = [0; N];
        for (out, &b) in field.iter_mut().zip(self.0.iter().skip(at)) {
            *out = b;
        }
        field
    }

    pub(super) fn u8(self, at: usize) -> u8 {
        self.get::<1>(at)[0]
    }

    pub(super) fn i8(self, at: usize) -> i8 {
        i8::from_le_bytes(self.get(at))
    }

    pub(super) fn u16(self, at: usize) -> u16 {
        u16::from_le_bytes(self.get(at))
    }

    pub(super) fn i16(self, at: usize) -> i16 {
        i16::from_le_bytes(self.get(at))
    }

    pub(super) fn u32(self, at: usize) -> u32 {
        u32::from_le_bytes(self.get(at))
    }

    pub(super) fn i32(self, at: usize) -> i32 {
        i32::from_le_bytes(self.get(at))
    }

    pub(super) fn u64(self, at: usize) -> u64 {
        u64::from_le_bytes(self.get(at))
    }

    pub(super) fn f32(self, at: usize) -> f32 {
        f32::from_le_bytes(self.get(at))
    }
}
