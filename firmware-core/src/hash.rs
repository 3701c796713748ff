//! The FNV-1a hash: small, the same everywhere, and no protection against malice.
//!
//! ```
//! use firmware_core::hash::Fnv1a;
//!
//! let mut hash = Fnv1a::new();
//! hash.write(b"foobar");
//! assert_eq!(hash.finish(), 0x8594_4171_f739_67e8);
//! ```

/// An FNV-1a hash of 64 bits in progress.
///
/// Content hashes of actor files, fingerprints, and digests in logs and tests are made with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fnv1a(u64);

impl Fnv1a {
    /// The hash of nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Adds bytes, one after the other.
    pub fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_word(byte.into()));
    }

    /// Adds a word of 32 bits in one round, which is not the same as adding its four bytes.
    pub const fn write_word(&mut self, word: u32) {
        self.0 = (self.0 ^ word as u64).wrapping_mul(0x0000_0100_0000_01b3);
    }

    /// The hash of what was added so far.
    #[must_use]
    pub const fn finish(&self) -> u64 {
        self.0
    }
}

impl Default for Fnv1a {
    fn default() -> Self {
        Self::new()
    }
}
