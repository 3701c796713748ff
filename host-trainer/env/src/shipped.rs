//! The actors that come with Covey.

use std::io;
use std::path::Path;

/// Names and files: one for each aggregation, all trained alike. The first is the best, and is
/// what flies when no other is asked for.
pub const SHIPPED: [(&str, &[u8]); 3] = [
    ("gcn", include_bytes!("../../actors/gcn.postcard")),
    ("gat", include_bytes!("../../actors/gat.postcard")),
    ("none", include_bytes!("../../actors/none.postcard")),
];

/// The bytes of the actor that a user names by a path, and what to call it. A name of [`SHIPPED`]
/// means that one unless there is such a file; no path means the best.
///
/// # Errors
/// When the file cannot be read.
pub fn open_actor(path: Option<&Path>) -> io::Result<(Vec<u8>, String)> {
    let own = |&(name, bytes): &(&str, &[u8])| (bytes.to_vec(), format!("the actor {name} that comes with Covey"));
    let Some(path) = path else { return Ok(own(&SHIPPED[0])) };
    match SHIPPED.iter().find(|s| path == Path::new(s.0) && !path.exists()) {
        Some(found) => Ok(own(found)),
        None => Ok((std::fs::read(path)?, path.display().to_string())),
    }
}
