//! What a run leaves on disk: its folder, checkpoints and report.

mod checkpoint;
mod folder;
mod lock;
pub(crate) mod report;

pub use checkpoint::{Checkpoint, CheckpointError};
pub use folder::{FolderError, RunFolder};
pub use lock::{LockError, RunLock};
