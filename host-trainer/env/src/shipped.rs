//! The actors that come with Covey.

use std::path::Path;

/// Names and files: one for each aggregation, all trained alike. The first is the best, and is
/// what flies when no other is asked for.
pub const SHIPPED: [(&str, &[u8]); 3] = [
    ("gcn", include_bytes!("../../actors/gcn.postcard")),
    ("gat", include_bytes!("../../actors/gat.postcard")),
    ("none", include_bytes!("../../actors/none.postcard")),
];

/// What a user means who names an actor by this path, or by none: one of these, with its name,
/// unless there is a file at the path.
#[must_use]
pub fn shipped(path: Option<&Path>) -> Option<(&'static [u8], String)> {
    let (name, bytes) = match path {
        None => SHIPPED[0],
        Some(path) => *SHIPPED.iter().find(|s| path == Path::new(s.0) && !path.exists())?,
    };
    Some((bytes, format!("the actor {name} that comes with Covey")))
}
