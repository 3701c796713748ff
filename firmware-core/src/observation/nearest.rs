//! The nearest of many, in a list of fixed capacity.

use heapless::Vec;

/// Inserts `item` into the sorted `list`, behind those it is not before. When there is no
/// room the last of all drops out.
pub(super) fn insert_sorted<T, const N: usize>(list: &mut Vec<T, N>, item: T, before: impl Fn(&T, &T) -> bool) {
    if list.is_full() {
        match list.last() {
            Some(last) if before(&item, last) => list.pop(),
            _ => return,
        };
    }
    // Not full, so this always succeeds. `Vec::insert` would do the rest, but for its panic branch.
    let _ = list.push(item);
    for end in (2..=list.len()).rev() {
        match list.get_mut(..end) {
            Some([.., a, b]) if before(b, a) => core::mem::swap(a, b),
            _ => return,
        }
    }
}
