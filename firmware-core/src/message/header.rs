//! The part that both messages begin with.

/// Version of both layouts, the first byte of a message.
pub const VERSION: u8 = 1;

/// Who sent a message and when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// The sender's id.
    pub id: u16,
    /// Counts the sender's messages of this kind and wraps around.
    pub sequence: u16,
    /// The step the message belongs to.
    pub step: u32,
}
