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
    /// Rows and columns of every layer in file order: encoder 1, encoder 2, those of the
    /// aggregation, head, output. GCN and `GraphSAGE` have the graph layer, GAT attention and the
    /// graph layer, GATv2 receiver, sender and attention.
    pub fn layers(self, aggregation: Aggregation) -> impl Iterator<Item = (usize, usize)> {
        let [o, e, h, m, a] = [self.observation, self.hidden, self.feature, self.head, self.actions].map(usize::from);
        let square = Some((h, h));
        let between = match aggregation {
            Aggregation::None => [None; 3],
            Aggregation::Gcn | Aggregation::Sage => [square, None, None],
            Aggregation::Gat => [Some((2, h)), square, None],
            Aggregation::GatV2 => [square, square, Some((1, h))],
        };
        let joined = if aggregation == Aggregation::None { h } else { 2 * h };
        let [first, second, third] = between;
        [Some((e, o)), Some((h, e)), first, second, third, Some((m, joined)), Some((a, m))].into_iter().flatten()
    }
}
