//! Pseudo-random numbers that are the same on every machine, for the family of scenes.
//!
//! xoshiro256++ (Blackman and Vigna 2021, <https://doi.org/10.1145/3460772>), its state filled by
//! `SplitMix64` (Steele, Lea and Flood 2014, <https://doi.org/10.1145/2660193.2660195>) as its
//! authors advise. Transcendental functions are those of `libm`, which does not depend on the
//! platform.

use core::f64::consts::TAU;
use core::ops::RangeInclusive;

/// A stream of pseudo-random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Generator {
    state: [u64; 4],
}

impl Generator {
    /// The stream of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        let mut counter = seed;
        let mut split_mix = || {
            counter = counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (counter ^ (counter >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            mixed ^ (mixed >> 31)
        };
        Self { state: core::array::from_fn(|_| split_mix()) }
    }

    /// 64 random bits.
    fn bits(&mut self) -> u64 {
        let [a, b, c, d] = self.state;
        let result = a.wrapping_add(d).rotate_left(23).wrapping_add(a);
        let (c, d) = (c ^ a, d ^ b);
        self.state = [a ^ d, b ^ c, c ^ (b << 17), d.rotate_left(45)];
        result
    }

    /// A number in \[0, 1), a multiple of 2⁻⁵³.
    fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number between two, all equally likely.
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }

    /// A number between two positive ones, all ratios equally likely.
    pub(crate) fn log_between(&mut self, from: f64, to: f64) -> f64 {
        libm::exp(self.between(libm::log(from), libm::log(to)))
    }

    /// One of a few whole numbers, to 2⁻³² equally likely.
    pub(crate) fn whole(&mut self, range: RangeInclusive<u32>) -> u32 {
        let count = u64::from(range.end() - range.start()) + 1;
        let below = ((self.bits() >> 32) * count) >> 32;
        // Below `count`, which fits; the last number stands for what cannot happen.
        u32::try_from(below).map_or(*range.end(), |below| range.start() + below)
    }

    /// Three orthonormal vectors, all orientations equally likely: a random unit quaternion
    /// (Shoemake 1992, Graphics Gems III, p. 124).
    pub(crate) fn axes(&mut self) -> [[f64; 3]; 3] {
        let (u, first, second) = (self.uniform(), TAU * self.uniform(), TAU * self.uniform());
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        let [x, y] = [a * libm::sin(first), a * libm::cos(first)];
        let [z, w] = [b * libm::sin(second), b * libm::cos(second)];
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The recurrence with the state 1, 2, 3, 4 in arithmetic of any length, elsewhere.
    #[test]
    fn the_stream_is_that_of_the_authors() {
        let mut generator = Generator { state: [1, 2, 3, 4] };
        let expected = [41_943_041, 58_720_359, 3_588_806_011_781_223, 3_591_011_842_654_386];
        assert_eq!(expected.map(|_| generator.bits()), expected);
        // `SplitMix64` of 0 begins so.
        assert_eq!(Generator::new(0).state[0], 0xe220_a839_7b1d_cdaf);
    }

    #[test]
    fn draws_fill_their_ranges_and_axes_are_orthonormal() {
        let mut generator = Generator::new(5);
        let mut counts = [0; 3];
        for _ in 0..3000 {
            counts[generator.whole(4..=6) as usize - 4] += 1;
            let number = generator.log_between(0.1, 10.0);
            assert!((0.1..10.0).contains(&number));
        }
        assert!(counts.iter().all(|&count| (900..1100).contains(&count)), "{counts:?}");
        let axes = generator.axes();
        for i in 0..3 {
            for j in 0..3 {
                let dot: f64 = (0..3).map(|k| axes[i][k] * axes[j][k]).sum();
                assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
