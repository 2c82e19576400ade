//! Blocks of the image plane, for each of which a depth rule may be fitted.

use crate::vol::dyadic::{Place, STEPS};

/// A dyadic square of the image plane, one of 2^`level` along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Block {
    pub(crate) level: u8,
    column: u32,
    row: u32,
}

impl Block {
    /// The block of `level` that contains a place.
    pub(crate) fn around(place: Place, level: u8) -> Self {
        let [column, row] = place.map(|along| (along / (STEPS >> level)).min((1 << level) - 1));
        Self { level, column, row }
    }

    /// The quarter of this block that contains a place of it.
    pub(crate) fn quarter(self, place: Place) -> Self {
        Self::around(place, self.level + 1)
    }

    /// A place in its middle.
    pub(crate) fn middle(self) -> Place {
        [self.column, self.row].map(|number| (2 * number + 1) * (STEPS >> (self.level + 1)))
    }

    /// Whether a place is in the block widened by `margin` of its edge on each side.
    pub(crate) fn contains(&self, place: Place, margin: f64) -> bool {
        let edge = f64::from(STEPS >> self.level);
        let inside = |along: u32, block: u32| {
            let from_start = f64::from(along) - f64::from(block) * edge;
            (-margin * edge..=(1.0 + margin) * edge).contains(&from_start)
        };
        inside(place[0], self.column) && inside(place[1], self.row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::tuning::TUNING;

    #[test]
    fn each_place_is_in_its_block_and_the_last_one_too() {
        for place in [[0, 0], [STEPS, STEPS], [STEPS / 2, STEPS / 3]] {
            for level in 0..=TUNING.image.finest_block_level {
                let block = Block::around(place, level);
                assert!(block.contains(place, 0.0));
                assert!(block.quarter(place).contains(place, 0.0));
            }
        }
        assert!(!Block::around([0, 0], 1).contains([STEPS, 0], 0.26));
    }
}
