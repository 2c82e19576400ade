//! Numbers that follow from a few samples of a line, kept while those are the ones they follow from.
//!
//! Lines are looked at again after each of their samples, most of which are far from most others. A
//! sample never changes: so a number is known as long as its samples are, and they by their depths.

use crate::vol::dyadic::STENCIL;

/// A number, and the depths of the samples that it has been made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Memo {
    depths: Depths,
    pub(crate) value: f64,
}

/// Depths of samples in a fixed order.
pub(crate) type Depths = [u32; STENCIL];

/// No sample is as deep.
const NONE: u32 = u32::MAX;

impl Default for Memo {
    fn default() -> Self {
        Self { depths: [NONE; STENCIL], value: 0.0 }
    }
}

impl Memo {
    /// Makes the number anew if it is to follow from samples at other depths.
    pub(crate) fn update(&mut self, depths: Depths, make: impl FnOnce() -> f64) {
        if self.depths != depths {
            *self = Self { depths, value: make() };
        }
    }
}

/// The depths of at most [`STENCIL`] samples.
pub(crate) fn depths(of: impl Iterator<Item = u32>) -> Depths {
    let (mut depths, mut count) = ([NONE; STENCIL], 0);
    of.for_each(|depth| {
        depths[count] = depth;
        count += 1;
    });
    depths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_made_once_for_each_choice_of_samples() {
        let (mut memo, mut made) = (Memo::default(), 0);
        for few in [&[0, 8][..], &[0, 8], &[0, 4, 8], &[0, 8]] {
            memo.update(depths(few.iter().copied()), || {
                made += 1;
                f64::from(made)
            });
        }
        assert_eq!((made, memo.value.to_bits()), (3, 3.0_f64.to_bits()));
    }
}
