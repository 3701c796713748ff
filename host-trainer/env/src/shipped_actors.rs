//! The trained actors that come with Covey.

use std::io;
use std::path::Path;

/// Names and bytes of the actor files: one for each aggregation, all trained alike. The first has the highest coverage
/// and is used when no other is asked for.
pub const SHIPPED: [(&str, &[u8]); 3] = [
    ("gcn", include_bytes!("../../actors/gcn.postcard")),
    ("gat", include_bytes!("../../actors/gat.postcard")),
    ("none", include_bytes!("../../actors/none.postcard")),
];

/// The bytes of the actor file that a user names by a path, and a description of it for messages. A name of
/// [`SHIPPED`] means that actor unless there is a file of that name; no path means the first of [`SHIPPED`].
///
/// # Errors
/// When the file cannot be read.
pub fn open_actor(path: Option<&Path>) -> io::Result<(Vec<u8>, String)> {
    let shipped = |&(name, bytes): &(&str, &[u8])| (bytes.to_vec(), format!("the actor {name} that comes with Covey"));
    let Some(path) = path else { return Ok(shipped(&SHIPPED[0])) };
    match SHIPPED.iter().find(|s| path == Path::new(s.0) && !path.exists()) {
        Some(found) => Ok(shipped(found)),
        None => Ok((std::fs::read(path)?, path.display().to_string())),
    }
}
