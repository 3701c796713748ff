//! Sizes of the kernel's vectors.

/// Numbers in a vector of the kernel; columns come in multiples of it.
pub const LANES: usize = 8;
/// Most columns of a product: eight vectors.
pub const PANEL: usize = 64;

/// `n` up to whole vectors.
#[must_use]
pub const fn padded(n: usize) -> usize {
    n.div_ceil(LANES) * LANES
}
