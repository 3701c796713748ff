//! The version of the messages' layouts.

/// Version of both layouts, the first byte of a message.
pub const VERSION: u8 = 1;
