//! What a run leaves on disk.

mod checkpoint;
mod folder;

pub use checkpoint::{Checkpoint, CheckpointError};
pub use folder::{FolderError, RunFolder};
