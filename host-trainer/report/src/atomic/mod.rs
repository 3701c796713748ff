//! Atomic files: readers find either the old content or the new, never a part.
//!
//! [`write()`] puts the bytes into a temporary file of the same folder, syncs it, renames it over the target and syncs
//! the folder. A crash, a full disk or a power cut at any moment leaves the target whole.

mod disk;
mod error;
mod write;

pub use disk::{Disk, RealDisk};
pub use error::{Stage, WriteError};
pub use write::{remove_leftovers, write, write_on};
