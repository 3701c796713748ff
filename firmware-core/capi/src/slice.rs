//! Slices from C.

/// A slice from C.
///
/// # Safety
/// `data` is NULL, or valid for `count` items for as long as the slice is used.
pub(crate) unsafe fn slice<'a, T>(data: *const T, count: usize) -> Option<&'a [T]> {
    match count {
        0 => Some(&[]),
        _ if data.is_null() => None,
        // SAFETY: not NULL, and valid for `count` items by this function's contract.
        _ => Some(unsafe { core::slice::from_raw_parts(data, count) }),
    }
}
