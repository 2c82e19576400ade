//! Counts drawn from expected counts: a Poisson realisation with a seed.
//!
//! Each voxel has a stream of random bits of its own, named by the seed and the place of the voxel in
//! the cube. So what is drawn in it depends on the seed, its place and its own expectation alone, and
//! on no number of threads. The bits are those of `ChaCha` with 8 rounds (Bernstein 2008), the same on
//! every machine and in every version; what makes a number of them is the Poisson distribution of the
//! crate `rand_distr` 0.6: products of uniform numbers for expectations below 12 (Knuth 1969), else
//! method PD of Ahrens and Dieter 1982, <https://doi.org/10.1145/355993.355997>. It takes exponentials
//! and logarithms that may differ in their last bit from machine to machine, which changes about one
//! draw in 10¹⁵.

use emitree::{Cube, Image};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Poisson};
use rayon::prelude::*;

/// The largest expectation; whole numbers are exact in 64 bits far beyond it.
const LARGEST: f64 = 1e12;

/// An expectation that no counts can be drawn from.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the expected counts in channel {channel} at row {row}, column {column} are {value}: expected 0 \
     to 1e12, or NaN outside of the field"
)]
pub struct PoissonError {
    /// The band of the cube, from 0.
    pub channel: usize,
    /// The row of the pixel, from 0.
    pub row: usize,
    /// The column of the pixel, from 0.
    pub column: usize,
    /// The expected counts there.
    pub value: f64,
}

/// Draws counts, whole numbers, from expected counts; NaN stays NaN.
///
/// ```
/// use emitree::{Cube, Image};
/// use emitree_instrument::draw_counts;
///
/// let expected = Cube::from_bands(vec![Image::from_pixels(1, 3, vec![0.0, 2.5, 1e6])]);
/// let counts = draw_counts(&expected, 7)?;
/// assert_eq!(counts.bands()[0].pixels()[0], 0.0);
/// assert_eq!(counts, draw_counts(&expected, 7)?); // the same seed, the same counts
/// # Ok::<(), emitree_instrument::PoissonError>(())
/// ```
///
/// # Errors
///
/// [`PoissonError`] names the first voxel whose expectation is negative or above 10¹².
pub fn draw_counts(expected: &Cube, seed: u64) -> Result<Cube, PoissonError> {
    let [_, height, width] = expected.shape();
    let pixels = height * width;
    let bands = expected.bands().par_iter().enumerate().map(|(channel, band)| {
        let draws = band.pixels().iter().enumerate().map(|(pixel, &value)| {
            let stream = (channel as u64).wrapping_mul(pixels as u64).wrapping_add(pixel as u64);
            draw(value, seed, stream).ok_or(PoissonError {
                channel,
                row: pixel / width,
                column: pixel % width,
                value,
            })
        });
        Ok(Image::from_pixels(height, width, draws.collect::<Result<_, _>>()?))
    });
    // In order, so that it is the first error that is named.
    let bands: Vec<Result<Image, PoissonError>> = bands.collect();
    Ok(Cube::from_bands(bands.into_iter().collect::<Result<_, _>>()?))
}

/// A number from a Poisson distribution; none if there is no such distribution.
fn draw(expected: f64, seed: u64, stream: u64) -> Option<f64> {
    if expected.is_nan() || expected == 0.0 {
        return Some(expected);
    }
    if !(0.0..=LARGEST).contains(&expected) {
        return None;
    }
    let mut key = [0; 32];
    key[..size_of::<u64>()].copy_from_slice(&seed.to_le_bytes());
    let mut bits = ChaCha8Rng::from_seed(key);
    bits.set_stream(stream);
    Some(Poisson::new(expected).ok()?.sample(&mut bits))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(expected: f64, side: usize) -> Cube {
        Cube::from_bands(vec![Image::from_pixels(side, side, vec![expected; side * side])])
    }

    /// For n draws the mean is within 5 standard deviations √(λ/n), and the variance within 5 of its
    /// own, √(((n−1) λ + 2 n λ² ) / n²) but for terms of second order.
    #[test]
    fn means_and_variances_are_those_of_the_distribution() {
        for (seed, expected) in
            [0.01, 0.7, 5.0, 11.99, 12.0, 60.0, 3e4, 1e9, 1e12].into_iter().enumerate()
        {
            let counts = draw_counts(&uniform(expected, 250), seed as u64).unwrap();
            let n = 62_500.0;
            // Shifted, since squares of 10¹² have no room for a variance of 10¹².
            let shifted = || counts.voxels().map(|count| count - expected);
            let mean = shifted().sum::<f64>() / n;
            let variance = shifted().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
            assert!(mean.abs() < 5.0 * (expected / n).sqrt(), "{expected}: {mean}");
            let spread = ((expected + 2.0 * expected * expected) / n).sqrt();
            assert!((variance - expected).abs() < 5.0 * spread, "{expected}: {variance}");
            assert!(counts.voxels().all(|count| count >= 0.0 && count.fract() == 0.0));
        }
    }

    /// Frequencies of single counts, against λᵏ e^(−λ) / k!.
    #[test]
    #[expect(clippy::float_cmp, reason = "counts are whole numbers")]
    fn frequencies_are_those_of_the_distribution() {
        for expected in [0.7, 13.0_f64] {
            let counts = draw_counts(&uniform(expected, 400), 3).unwrap();
            let mut probability = (-expected).exp();
            for k in 0..30 {
                let found = counts.voxels().filter(|&count| count == f64::from(k)).count() as f64;
                let n = 160_000.0;
                let spread = (n * probability * (1.0 - probability)).sqrt();
                assert!(
                    (found - n * probability).abs() < 5.0 * spread + 1.0,
                    "{k} of {expected}: {found} {}",
                    n * probability
                );
                probability *= expected / f64::from(k + 1);
            }
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "counts are whole numbers")]
    fn a_voxel_depends_on_its_own_expectation_alone() {
        let first = uniform(40.0, 8);
        let mut second = first.clone();
        second.bands_mut()[0][(2, 3)] = 3.0;
        let [first, second] = [first, second].map(|cube| draw_counts(&cube, 11).unwrap());
        let differing = first.voxels().zip(second.voxels()).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 1);
        let other = draw_counts(&uniform(40.0, 8), 12).unwrap();
        assert!(first.voxels().zip(other.voxels()).filter(|(a, b)| a != b).count() > 50);
    }

    #[test]
    fn bits_do_not_depend_on_the_number_of_threads() {
        let cube = Cube::from_bands(
            (1..9).map(|n| Image::from_pixels(5, 7, vec![f64::from(n) * 3.0; 35])).collect(),
        );
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| draw_counts(&cube, 5).unwrap())
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn wrong_expectations_are_named_and_none_stays_none() {
        let mut cube = uniform(1.0, 4);
        cube.bands_mut()[0][(1, 2)] = f64::NAN;
        let counts = draw_counts(&cube, 1).unwrap();
        assert!(counts.bands()[0][(1, 2)].is_nan());
        assert_eq!(counts.voxels().filter(|count| count.is_nan()).count(), 1);
        cube.bands_mut()[0][(3, 1)] = -0.5;
        cube.bands_mut()[0][(3, 2)] = 2e12;
        assert_eq!(
            draw_counts(&cube, 1).unwrap_err().to_string(),
            "the expected counts in channel 0 at row 3, column 1 are -0.5: expected 0 to 1e12, or \
             NaN outside of the field"
        );
        cube.bands_mut()[0][(3, 1)] = 0.0;
        assert!(
            draw_counts(&cube, 1).unwrap_err().to_string().contains("column 2 are 2000000000000:")
        );
    }

    /// What a seed has once given it gives for ever; the first three are also those of another
    /// program, `tests/reference/poisson.py`.
    #[test]
    fn the_counts_of_a_seed_are_pinned() {
        let expected = vec![0.5, 3.0, 11.0, 40.0, 1e4, 1e12];
        let cube = Cube::from_bands(vec![Image::from_pixels(2, 3, expected)]);
        let counts = draw_counts(&cube, 20_261_121).unwrap();
        let pinned = [0.0, 3.0, 17.0, 53.0, 9_890.0, 1_000_000_223_024.0];
        assert_eq!(counts.voxels().collect::<Vec<_>>(), pinned);
    }
}
