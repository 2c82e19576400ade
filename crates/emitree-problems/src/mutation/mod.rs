//! Files and scenes with something wrong in them, by seed: what a program must survive.
//!
//! A [`Mutator`] changes the [bytes](Mutator::bytes) of a file or the [text](Mutator::scene) of a scene in
//! a few random places, or makes up a [view](Mutator::view) that may contain nothing, everything or the
//! inside of a body. Equal seeds make equal mutants on every machine. A [`Campaign`] says how many are
//! made, and [`watched`] ends a case that does not end.
//!
//! ```
//! use emitree_problems::mutation::Mutator;
//!
//! let scene = "[image]\nwidth = 64\n";
//! let mutant = Mutator::new(7).scene(scene);
//! assert_eq!(mutant, Mutator::new(7).scene(scene));
//! ```

mod bytes;
mod campaign;
mod text;
mod view;

pub use campaign::{Campaign, watched};

use crate::family::generator::Generator;

/// Numbers at the ends of what integers of some width hold, and sizes that no memory has.
const EXTREME_INTEGERS: [i64; 14] = [
    0,
    1,
    -1,
    2,
    127,
    255,
    32_767,
    65_536,
    2_147_483_647,
    4_294_967_295,
    1 << 40,
    1 << 53,
    i64::MAX,
    i64::MIN,
];

/// Numbers at the ends of what double precision holds, and some that scenes have no use for.
const EXTREME_NUMBERS: [f64; 18] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f64::MIN_POSITIVE,
    5e-324,
    1e-300,
    1e-160,
    1e-9,
    179.999_999_99,
    1e9,
    1e16,
    1e160,
    1e300,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NAN,
];

/// A source of mutants.
#[derive(Clone, Debug)]
pub struct Mutator {
    random: Generator,
}

impl Mutator {
    /// The mutants of a seed.
    pub fn new(seed: u64) -> Self {
        Self { random: Generator::new(seed) }
    }

    /// One of `items`, none if there are none.
    pub fn choice<'a, T>(&mut self, items: &'a [T]) -> Option<&'a T> {
        items.get(self.below(items.len()))
    }

    /// A whole number below `count`; 0 if that is 0.
    fn below(&mut self, count: usize) -> usize {
        let last = u32::try_from(count.saturating_sub(1)).unwrap_or(u32::MAX);
        self.random.whole(0..=last) as usize
    }

    /// Whether one of so many equally likely things happens.
    fn one_in(&mut self, count: u32) -> bool {
        self.random.whole(1..=count) == 1
    }

    fn integer(&mut self) -> i64 {
        EXTREME_INTEGERS[self.below(EXTREME_INTEGERS.len())]
    }

    fn number(&mut self) -> f64 {
        EXTREME_NUMBERS[self.below(EXTREME_NUMBERS.len())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_has_always_the_same_mutants_and_seeds_have_others() {
        let scene = "[image]\nwidth = 64\nheight = 48\n[render]\ntolerance = 0.01\n";
        let bytes: Vec<u8> = (0..=255).collect();
        let mutants = |seed| {
            let mut mutator = Mutator::new(seed);
            (mutator.bytes(&bytes), mutator.scene(scene), mutator.view())
        };
        assert_eq!(mutants(3), mutants(3));
        let mut scenes: Vec<String> = (0..200).map(|seed| mutants(seed).1).collect();
        scenes.sort();
        scenes.dedup();
        assert!(scenes.len() > 120, "{}", scenes.len());
    }

    #[test]
    fn nothing_is_mutated_to_something() {
        for seed in 0..100 {
            let _ = Mutator::new(seed).bytes(&[]);
            let _ = Mutator::new(seed).scene("");
        }
    }
}
