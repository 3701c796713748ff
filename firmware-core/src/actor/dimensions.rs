//! Widths of the network.

use super::aggregation::Aggregation;

/// Widths of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Dimensions {
    /// Numbers in an observation.
    pub observation: u16,
    /// First hidden layer, at most 128.
    pub hidden: u16,
    /// Feature `h`, even, at most 64.
    pub feature: u16,
    /// Hidden layer of the head, at most 128.
    pub head: u16,
    /// Actions.
    pub actions: u16,
}

impl Dimensions {
    /// Rows and columns of every layer in file order: encoder 1, encoder 2, attention
    /// (GAT only), graph (GCN and GAT), head, output.
    pub fn layers(self, aggregation: Aggregation) -> impl Iterator<Item = (usize, usize)> {
        let [o, e, h, m, a] = [self.observation, self.hidden, self.feature, self.head, self.actions].map(usize::from);
        let (attention, graph, joined) = match aggregation {
            Aggregation::None => (None, None, h),
            Aggregation::Gcn => (None, Some((h, h)), 2 * h),
            Aggregation::Gat => (Some((2, h)), Some((h, h)), 2 * h),
        };
        [Some((e, o)), Some((h, e)), attention, graph, Some((m, joined)), Some((a, m))].into_iter().flatten()
    }
}
