//! Numbers computed from a few samples of a line, cached as long as these samples are the same.
//!
//! A line is assessed after each step of its refinement, but most new samples are far from most
//! others. The rate of a sample never changes, so that its depth identifies it.

use crate::vol::dyadic::STENCIL;

/// A number, and the depths of the samples from which it was computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Memo {
    depths: Depths,
    pub(crate) value: f64,
}

/// Depths of samples in a fixed order.
pub(crate) type Depths = [u32; STENCIL];

/// No sample has this depth.
const NONE: u32 = u32::MAX;

impl Default for Memo {
    fn default() -> Self {
        Self { depths: [NONE; STENCIL], value: 0.0 }
    }
}

impl Memo {
    /// Computes the number again if the depths of its samples have changed.
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
