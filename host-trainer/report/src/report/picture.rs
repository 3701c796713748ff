//! What single pictures have in common.

/// Light and dark colours, as in the page's style sheet.
pub(super) const STYLE: &str = include_str!("../assets/picture.css");
