//! The actor file in flash, at an address of its own: a new policy needs no new program.

use core::ptr::addr_of;
use core::slice;

use firmware_core::actor::file;

unsafe extern "C" {
    /// First byte of the region, set in the board's memory map.
    static _actor_start: u8;
    /// First byte behind it.
    static _actor_end: u8;
}

/// The file: as much of its flash region as its header says. Without a file there the bytes are something else, and
/// loading them fails.
#[must_use]
pub fn actor_file() -> &'static [u8] {
    let (start, end) = (addr_of!(_actor_start), addr_of!(_actor_end));
    // SAFETY: the memory map sets both ends of a region of readable memory that nothing writes to.
    let region = unsafe { slice::from_raw_parts(start, end.addr() - start.addr()) };
    file::at_start_of(region)
}
