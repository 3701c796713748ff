//! Groups: the connected components of the communication graph.

/// Disjoint sets of UAVs (a union-find forest), and their members group by group.
#[derive(Clone, Debug)]
pub(crate) struct Groups {
    /// Parent of each UAV in the forest, never of a higher index; roots are their own.
    parent: Vec<u32>,
    /// Group of each UAV, numbered by their first member.
    of: Vec<u32>,
    /// First place in `members` of each group, and one past the last.
    starts: Vec<u32>,
    /// UAVs, group by group.
    members: Vec<u32>,
}

impl Groups {
    pub(crate) fn new(n: usize) -> Self {
        Self { parent: vec![0; n], of: vec![0; n], starts: Vec::with_capacity(n + 1), members: vec![0; n] }
    }

    /// Puts every UAV into a group of its own.
    pub(crate) fn clear(&mut self) {
        for (i, p) in self.parent.iter_mut().enumerate() {
            *p = i as u32;
        }
    }

    /// Joins the groups of two UAVs.
    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        // The lower index stays root, so roots come before their members.
        self.parent[a.max(b)] = a.min(b) as u32;
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] as usize != i {
            // Path halving.
            let above = self.parent[self.parent[i] as usize];
            self.parent[i] = above;
            i = above as usize;
        }
        i
    }

    /// Numbers the groups and lists their members. Call once after the last `join`.
    pub(crate) fn number(&mut self) {
        self.starts.clear();
        for i in 0..self.parent.len() {
            let root = self.root(i);
            let group = if root == i {
                self.starts.push(0);
                self.starts.len() as u32 - 1
            } else {
                self.of[root]
            };
            self.of[i] = group;
            self.starts[group as usize] += 1;
        }
        let mut end = 0;
        for s in &mut self.starts {
            end += *s;
            *s = end;
        }
        self.starts.push(end);
        for (i, &group) in self.of.iter().enumerate().rev() {
            let place = &mut self.starts[group as usize];
            *place -= 1;
            self.members[*place as usize] = i as u32;
        }
    }

    /// Members of each group, ascending.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|w| &self.members[w[0] as usize..w[1] as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against spreading labels until nothing changes.
        #[test]
        fn groups_are_connected_components(
            n in 1usize..100,
            edges in prop::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>()), 0..120),
        ) {
            let edges: Vec<_> = edges.iter().map(|(a, b)| (a.index(n), b.index(n))).collect();
            let mut label: Vec<usize> = (0..n).collect();
            for _ in 0..n {
                for &(a, b) in &edges {
                    let low = label[a].min(label[b]);
                    label[a] = low;
                    label[b] = low;
                }
            }
            let mut groups = Groups::new(n);
            for _ in 0..2 {
                groups.clear();
                for &(a, b) in &edges {
                    groups.join(a, b);
                }
                groups.number();
                let mut seen = 0;
                for members in groups.iter() {
                    let first = label[members[0] as usize];
                    let expected: Vec<_> = (0..n as u32).filter(|&i| label[i as usize] == first).collect();
                    prop_assert_eq!(members, &expected[..]);
                    seen += members.len();
                }
                prop_assert_eq!(seen, n);
            }
        }
    }
}
