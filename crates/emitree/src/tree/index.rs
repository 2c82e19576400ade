//! Where the families of a refined level are: found by their position.
//!
//! The families whose parents are the cells of one family are a *clan*. A clan has one entry in a
//! table, and its 2^D members lie side by side: neighbours are looked up in few steps, and a table
//! with one entry for each 4^D cells stays in the cache of the processor.

use crate::cell::{self, to_u32};
use rustc_hash::FxHashMap;

/// Marks a member of a clan that the level has not.
pub(super) const NONE: u32 = u32::MAX;

/// The indices of families by their position.
#[derive(Clone, Debug, Default)]
pub(super) struct FamilyIndex<const D: usize> {
    /// Number of the clan, by the key of its position: that of its members' parents' family.
    clans: FxHashMap<u64, u32>,
    /// Family of each member, or [`NONE`], clan after clan; member `n` is the upper half along axis
    /// `a` where bit `a` of `n` is set.
    members: Vec<u32>,
}

impl<const D: usize> FamilyIndex<D> {
    const MEMBERS: usize = 1 << D;

    /// The index of `families`, which are numbered in their order.
    pub(super) fn of(families: &[[u32; D]]) -> Self {
        // Members of a clan mostly follow each other.
        let changes = families.windows(2).filter(|pair| clan(pair[0]) != clan(pair[1])).count();
        let clans = (changes + 1).min(families.len());
        let mut index = Self {
            clans: FxHashMap::with_capacity_and_hasher(clans, rustc_hash::FxBuildHasher),
            members: Vec::with_capacity(clans * Self::MEMBERS),
        };
        let mut family = 0;
        for run in runs(families) {
            let members = index.members_or_new(clan(run[0]));
            for &position in run {
                members[member(position)] = to_u32(family);
                family += 1;
            }
        }
        index
    }

    /// The number of the clan at `position`, or [`NONE`].
    pub(super) fn clan_at(&self, position: [u32; D]) -> u32 {
        self.clans.get(&cell::key(position)).copied().unwrap_or(NONE)
    }

    /// The family that is this member of a clan that there is, or [`NONE`].
    pub(super) fn member_of(&self, clan: u32, member: usize) -> u32 {
        self.members[clan as usize * Self::MEMBERS + member]
    }

    /// The index of the family at `position`.
    pub(super) fn get(&self, position: [u32; D]) -> Option<usize> {
        let clan = self.clan_at(clan(position));
        if clan == NONE {
            return None;
        }
        let family = self.member_of(clan, member(position));
        (family != NONE).then_some(family as usize)
    }

    /// Adds the family at `position`.
    pub(super) fn insert(&mut self, position: [u32; D], family: usize) {
        self.members_or_new(clan(position))[member(position)] = to_u32(family);
    }

    fn members_or_new(&mut self, clan: [u32; D]) -> &mut [u32] {
        let next = to_u32(self.clans.len());
        let number = *self.clans.entry(cell::key(clan)).or_insert(next);
        if number == next {
            self.members.resize(self.members.len() + Self::MEMBERS, NONE);
        }
        &mut self.members[number as usize * Self::MEMBERS..][..Self::MEMBERS]
    }
}

/// The position of the clan of the family at `position`.
pub(super) fn clan<const D: usize>(position: [u32; D]) -> [u32; D] {
    position.map(|p| p >> 1)
}

/// Which member of its clan the family at `position` is.
pub(super) fn member<const D: usize>(position: [u32; D]) -> usize {
    (0..D).fold(0, |member, axis| member | (position[axis] as usize & 1) << axis)
}

/// Families that follow each other and are of one clan.
pub(super) fn runs<const D: usize>(families: &[[u32; D]]) -> impl Iterator<Item = &[[u32; D]]> {
    families.chunk_by(|a, b| clan(*a) == clan(*b))
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
        let clan = index.clan_at([1, 1]);
        assert_eq!([0, 1, 2, 3].map(|member| index.member_of(clan, member)), [3, NONE, 0, 1]);
        assert_eq!(FamilyIndex::<3>::of(&[]).get([0; 3]), None);
    }

    #[test]
    fn runs_are_of_one_clan() {
        let families = [[0, 0], [1, 1], [2, 0], [0, 1]];
        let lengths: Vec<usize> = runs(&families).map(<[_]>::len).collect();
        assert_eq!(lengths, [2, 1, 1]);
    }
}
