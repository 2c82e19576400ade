//! Dyadic cells of the unit cube, and the families of 2^D siblings they come in.

/// A cell of edge 2^−level at integer `position`, in units of its edge.
///
/// Child `n` of a cell lies in the upper half along axis `a` where bit `a` of `n` is set; the 2^D
/// children of one cell are a *family*, named by their parent's position.
///
/// ```
/// use emitree::cell::CellIndex;
///
/// let cell = CellIndex::new(3, [1, 6, 7]);
/// assert_eq!(cell.centre(), [0.1875, 0.8125, 0.9375]);
/// assert_eq!(cell.child(0b101).position(), [3, 12, 15]);
/// assert_eq!(cell.child(0b101).parent(), Some(cell));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellIndex<const D: usize> {
    level: u8,
    position: [u32; D],
}

impl<const D: usize> CellIndex<D> {
    /// The deepest level that cells of this dimension can have: positions of a family and of the
    /// nodes between its cells must pack into 64 bits.
    pub const MAX_LEVEL: u8 = match D {
        1 | 2 => 29,
        3 => 19,
        _ => 14,
    };

    /// The cell at `position` of `level`.
    ///
    /// # Panics
    ///
    /// If the level is deeper than [`MAX_LEVEL`](Self::MAX_LEVEL) or the position is outside the
    /// unit cube.
    pub fn new(level: u8, position: [u32; D]) -> Self {
        assert!(level <= Self::MAX_LEVEL, "level {level} of at most {}", Self::MAX_LEVEL);
        assert!(position.iter().all(|&p| p >> level == 0), "{position:?} is outside level {level}");
        Self { level, position }
    }

    /// The level: 0 is the whole cube.
    pub fn level(&self) -> u8 {
        self.level
    }

    /// Position along each axis, in 0..2^level.
    pub fn position(&self) -> [u32; D] {
        self.position
    }

    /// The centre, in canonical coordinates.
    pub fn centre(&self) -> [f64; D] {
        let edge = edge(self.level);
        self.position.map(|p| (f64::from(p) + 0.5) * edge)
    }

    /// Child `n` of 2^D.
    pub fn child(&self, n: usize) -> Self {
        Self { level: self.level + 1, position: child_position(self.position, n) }
    }

    /// The cell that this one is a child of; `None` at level 0.
    pub fn parent(&self) -> Option<Self> {
        let level = self.level.checked_sub(1)?;
        Some(Self { level, position: self.position.map(|p| p >> 1) })
    }
}

/// The edge of a cell of `level`.
pub(crate) fn edge(level: u8) -> f64 {
    1.0 / f64::from(1_u32 << level)
}

/// Position of child `n` of the cell at `parent`.
pub(crate) fn child_position<const D: usize>(parent: [u32; D], n: usize) -> [u32; D] {
    core::array::from_fn(|axis| 2 * parent[axis] + u32::from(n >> axis & 1 == 1))
}

/// `base` to the power of a number of axes.
pub(crate) fn power(base: usize, axes: usize) -> usize {
    (0..axes).fold(1, |product, _| product * base)
}

/// An index or a number of cells, families or nodes of one level, in 32 bits: a level of 2^32 of
/// them would need over 128 GiB, and there are at most 2^30 along an axis.
#[expect(clippy::cast_possible_truncation, reason = "see above")]
pub(crate) fn to_u32(index: usize) -> u32 {
    index as u32
}

/// A position packed into one integer, for hashing: equal keys mean equal positions.
pub(crate) fn key<const D: usize>(position: [u32; D]) -> u64 {
    let bits = 64 / D.max(2);
    position.iter().rev().fold(0, |key, &p| key << bits | u64::from(p))
}

/// The whole part of a number of nodes or depths, which is 0 or more.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates as it should"
)]
pub(crate) fn whole(number: f64) -> usize {
    number as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_unique_up_to_the_deepest_level() {
        let last = |level: u8| (1_u32 << (level + 1)) + 1;
        let deepest = CellIndex::<3>::MAX_LEVEL;
        let (a, b) = (last(deepest), last(deepest) - 1);
        let keys = [[a, b, b], [b, a, b], [b, b, a], [a, a, b], [0, 0, a], [0, a, 0]].map(key);
        for (i, k) in keys.iter().enumerate() {
            assert!(!keys[..i].contains(k));
        }
        let four = [last(CellIndex::<4>::MAX_LEVEL); 4];
        assert_eq!(key(four) >> 48, u64::from(four[3]));
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic centres are exact")]
    fn children_tile_their_parent() {
        let cell = CellIndex::new(2, [1, 3]);
        let centres: Vec<_> = (0..4).map(|n| cell.child(n).centre()).collect();
        let mean = |axis: usize| centres.iter().map(|c| c[axis]).sum::<f64>() / 4.0;
        assert_eq!([mean(0), mean(1)], cell.centre());
        assert_eq!(CellIndex::new(0, [0, 0]).parent(), None);
    }
}
