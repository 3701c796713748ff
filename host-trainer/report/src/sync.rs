//! File systems that cannot sync: shares and user-space file systems refuse fsync, of folders above all.

use std::io::{self, ErrorKind};
use std::sync::Once;

/// The outcome of a sync. That the file system has no such operation (EINVAL, ENOTSUP, ENOSYS) is lived with, and
/// told on standard error once a process; every other failure stays one.
///
/// # Errors
/// The failure given, where it is another.
pub(crate) fn lived_with(synced: io::Result<()>) -> io::Result<()> {
    static TOLD: Once = Once::new();
    match synced {
        Err(e) if matches!(e.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {
            TOLD.call_once(|| {
                let text = format!("this file system cannot sync ({e}): files may not survive a power cut\n");
                // Nothing depends on its being read.
                let _ = io::Write::write_all(&mut io::stderr(), text.as_bytes());
            });
            Ok(())
        }
        other => other,
    }
}
