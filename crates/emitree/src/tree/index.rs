//! Where the families of a refined level are: found by their position.
//!
//! The families whose parents are the cells of one family are *cousins*. A block of cousins has one entry in a
//! table, and its 2^D members lie side by side: neighbours are looked up in few steps, and a table
//! with one entry for each 4^D cells stays in the cache of the processor.

use crate::cell::{self, to_u32};
use rustc_hash::FxHashMap;

/// Marks a member of a block of cousins that the level has not.
pub(super) const NONE: u32 = u32::MAX;

/// The indices of families by their position.
#[derive(Clone, Debug, Default)]
pub(super) struct FamilyIndex<const D: usize> {
    /// Number of the block of cousins, by the key of its position: that of its members' parents' family.
    cousin_blocks: FxHashMap<u64, u32>,
    /// Family of each member, or [`NONE`], block of cousins after block; member `n` is the upper half along axis
    /// `a` where bit `a` of `n` is set.
    members: Vec<u32>,
}

impl<const D: usize> FamilyIndex<D> {
    const MEMBERS: usize = 1 << D;

    /// The index of `families`, which are numbered in their order.
    pub(super) fn of(families: &[[u32; D]]) -> Self {
        // Members of a block of cousins mostly follow each other.
        let changes =
            families.windows(2).filter(|pair| cousins(pair[0]) != cousins(pair[1])).count();
        let cousin_blocks = (changes + 1).min(families.len());
        let mut index = Self {
            cousin_blocks: FxHashMap::with_capacity_and_hasher(
                cousin_blocks,
                rustc_hash::FxBuildHasher,
            ),
            members: Vec::with_capacity(cousin_blocks * Self::MEMBERS),
        };
        let mut family = 0;
        for run in runs(families) {
            let members = index.members_or_new(cousins(run[0]));
            for &position in run {
                members[member(position)] = to_u32(family);
                family += 1;
            }
        }
        index
    }

    /// The number of the block of cousins at `position`, or [`NONE`].
    pub(super) fn block_at(&self, position: [u32; D]) -> u32 {
        self.cousin_blocks.get(&cell::key(position)).copied().unwrap_or(NONE)
    }

    /// The family that is this member of a block of cousins that there is, or [`NONE`].
    pub(super) fn member_of(&self, cousins: u32, member: usize) -> u32 {
        self.members[cousins as usize * Self::MEMBERS + member]
    }

    /// The index of the family at `position`.
    pub(super) fn get(&self, position: [u32; D]) -> Option<usize> {
        let cousins = self.block_at(cousins(position));
        if cousins == NONE {
            return None;
        }
        let family = self.member_of(cousins, member(position));
        (family != NONE).then_some(family as usize)
    }

    /// Adds the family at `position`.
    pub(super) fn insert(&mut self, position: [u32; D], family: usize) {
        self.members_or_new(cousins(position))[member(position)] = to_u32(family);
    }

    fn members_or_new(&mut self, cousins: [u32; D]) -> &mut [u32] {
        let next = to_u32(self.cousin_blocks.len());
        let number = *self.cousin_blocks.entry(cell::key(cousins)).or_insert(next);
        if number == next {
            self.members.resize(self.members.len() + Self::MEMBERS, NONE);
        }
        &mut self.members[number as usize * Self::MEMBERS..][..Self::MEMBERS]
    }
}

/// The position of the block of cousins of the family at `position`.
pub(super) fn cousins<const D: usize>(position: [u32; D]) -> [u32; D] {
    position.map(|p| p >> 1)
}

/// Which member of its block of cousins the family at `position` is.
pub(super) fn member<const D: usize>(position: [u32; D]) -> usize {
    (0..D).fold(0, |member, axis| member | (position[axis] as usize & 1) << axis)
}

/// Families that follow each other and are of one block of cousins.
pub(super) fn runs<const D: usize>(families: &[[u32; D]]) -> impl Iterator<Item = &[[u32; D]]> {
    families.chunk_by(|a, b| cousins(*a) == cousins(*b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_are_found_wherever_they_are_in_the_order() {
        let mut families = vec![[2, 3], [3, 3], [7, 0], [2, 2], [0, 1]];
        let mut index = FamilyIndex::of(&families);
        index.insert([6, 1], families.len());
        families.push([6, 1]);
        for (number, &position) in families.iter().enumerate() {
            assert_eq!(index.get(position), Some(number));
        }
        assert_eq!([[3, 2], [6, 0], [9, 9]].map(|position| index.get(position)), [None; 3]);
        let cousins = index.block_at([1, 1]);
        assert_eq!([0, 1, 2, 3].map(|member| index.member_of(cousins, member)), [3, NONE, 0, 1]);
        assert_eq!(FamilyIndex::<3>::of(&[]).get([0; 3]), None);
    }

    #[test]
    fn runs_are_of_one_block() {
        let families = [[0, 0], [1, 1], [2, 0], [0, 1]];
        let lengths: Vec<usize> = runs(&families).map(<[_]>::len).collect();
        assert_eq!(lengths, [2, 1, 1]);
    }
}
