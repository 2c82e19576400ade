//! The leaves of an earlier tree, with those that have changed since.

use crate::vol::surfaces::octree::{Cell, Leaf, Octree};

/// The leaves of a tree.
#[derive(Debug, Default)]
pub(super) struct KnownLeaves {
    /// In the order of their cells.
    leaves: Vec<(Cell, Leaf)>,
}

impl KnownLeaves {
    /// The numbers of the leaves of a tree that are not known as they are. All of them are known after that.
    pub(super) fn update(&mut self, tree: &Octree) -> Vec<usize> {
        let is_known = |of: &(Cell, Leaf)| {
            let known = self.leaves.binary_search_by(|known| known.0.cmp(&of.0));
            known.is_ok_and(|number| self.leaves[number] == *of)
        };
        let new = (0..tree.leaves.len()).filter(|&leaf| !is_known(&tree.leaves[leaf])).collect();
        self.leaves.clone_from(&tree.leaves);
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::surfaces::octree::Grid;

    #[test]
    fn leaves_are_new_where_their_cell_or_their_content_is() {
        let grid = Grid { edges: [1.0; 3], base: [2, 1, 1], finest: 2 };
        let tree = |leaves: &[(u8, [u32; 3], u16)]| {
            let leaf =
                |&(level, at, label): &(u8, [u32; 3], u16)| ((level, at), Leaf::Uncut(label));
            Octree::new(grid, leaves.iter().map(leaf).collect())
        };
        let mut known = KnownLeaves::default();
        assert_eq!(known.update(&tree(&[(0, [0; 3], 0), (0, [1, 0, 0], 1)])), [0, 1]);
        assert_eq!(known.update(&tree(&[(0, [0; 3], 0), (0, [1, 0, 0], 1)])), [0; 0]);
        assert_eq!(known.update(&tree(&[(0, [0; 3], 0), (0, [1, 0, 0], 2)])), [1]);
        let mut divided = vec![(0, [0; 3], 0)];
        divided.extend((0..8).map(|c| (1, [2 + (c & 1), (c >> 1) & 1, c >> 2], 2)));
        assert_eq!(known.update(&tree(&divided)), (1..9).collect::<Vec<_>>());
    }
}
