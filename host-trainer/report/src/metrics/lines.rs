//! Lines of a file.

/// Offsets of the newlines in `bytes`.
pub(super) fn newlines(bytes: &[u8]) -> impl Iterator<Item = usize> {
    bytes.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(at, _)| at)
}
