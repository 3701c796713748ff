//! What is left to decide at a node of the search.

/// The sets that may still be chosen at a search node, over the items not yet covered.
#[derive(Clone, Debug, Default)]
pub(crate) struct Subproblem {
    /// Indices of the sets among all candidates.
    pub(crate) ids: Vec<u32>,
    /// Their items, one set after another.
    pub(crate) items: Vec<u32>,
    /// Where each set's items begin, and the end.
    pub(crate) starts: Vec<u32>,
    /// Items in any of them, ascending.
    pub(crate) union: Vec<u32>,
}

impl Subproblem {
    /// Number of sets.
    pub(crate) fn len(&self) -> usize {
        self.ids.len()
    }

    /// Items of the `j`-th set.
    pub(crate) fn set(&self, j: usize) -> &[u32] {
        &self.items[self.starts[j] as usize..self.starts[j + 1] as usize]
    }
}
