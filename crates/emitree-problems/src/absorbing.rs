//! A family of media that absorb, by number: Gaussians of g and of κ, with reference images.
//!
//! [`random_medium`] makes the medium of a seed, in the unit cube: 1 to 3 Gaussians of g with widths from 0.06 to
//! 0.4, and 1 to 3 of κ with widths from 0.05 to 0.5, whose optical depths through the centre are 0.05 to 3 each. The
//! optical depth at a point is a sum of error functions, so that g exp(−τ) is known everywhere; its integral over a
//! pixel and its line of sight is a quadrature by Gauss and Legendre, whose difference from a coarser one is its
//! error.

use crate::family::Reference;
use crate::family::generator::Generator;
use crate::gauss::Gauss;
use crate::gaussian::Gaussian;
use core::f64::consts::PI;
use emitree::Image;

/// Nodes across a pixel, panels of a line, and nodes of each, coarse and fine.
const RULES: [[usize; 3]; 2] = [[4, 12, 10], [5, 16, 12]];
/// What makes the stream of numbers another one than that of other families.
const STREAM: u64 = 0xab50_4b00_0000;

/// A medium with Gaussians of g and of κ, each with its largest value.
#[derive(Clone, Debug, PartialEq)]
pub struct AbsorbingMedium {
    emission: Vec<(f64, Gaussian)>,
    absorption: Vec<(f64, Gaussian)>,
}

/// The medium of a seed.
///
/// ```
/// use emitree_problems::absorbing::random_medium;
///
/// let medium = random_medium(3);
/// assert!(medium.rate([0.5; 3]) >= 0.0 && medium.coefficient([0.5; 3]) >= 0.0);
/// assert_eq!(medium.optical_depth([0.5, 0.5, 0.0]), 0.0);
/// ```
pub fn random_medium(seed: u64) -> AbsorbingMedium {
    let mut generator = Generator::new(seed ^ STREAM);
    let mut parts = |widths: [f64; 2], depths: Option<[f64; 2]>| {
        let count = generator.whole(1..=3);
        let part = |_| {
            let centre = core::array::from_fn(|_| generator.between(0.2, 0.8));
            let width = generator.log_between(widths[0], widths[1]);
            let largest = match depths {
                None => generator.between(0.3, 1.0),
                Some([least, most]) => generator.log_between(least, most) / (width * PI.sqrt()),
            };
            (largest, Gaussian { centre, width })
        };
        (0..count).map(part).collect::<Vec<_>>()
    };
    let emission = parts([0.06, 0.4], None);
    let absorption = parts([0.05, 0.5], Some([0.05, 3.0]));
    AbsorbingMedium { emission, absorption }
}

impl AbsorbingMedium {
    /// g at a point.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.emission.iter().map(|(largest, part)| largest * part.rate(position)).sum()
    }

    /// κ at a point.
    pub fn coefficient(&self, position: [f64; 3]) -> f64 {
        self.absorption.iter().map(|(largest, part)| largest * part.rate(position)).sum()
    }

    /// The integral of κ from z = 0 to a point.
    pub fn optical_depth(&self, [x, y, z]: [f64; 3]) -> f64 {
        let of_part = |(largest, part): &(f64, Gaussian)| {
            let [.., centre] = part.centre;
            let across = part.rate([x, y, centre]);
            let erf = |z: f64| libm::erf((z - centre) / part.width);
            0.5 * PI.sqrt() * largest * part.width * across * (erf(z) - erf(0.0))
        };
        self.absorption.iter().map(of_part).sum()
    }

    /// The image of `shape` = \[height, width\] pixels in the canonical projection, and its error relative to
    /// the largest pixel: below 2e-6 on the seeds 0 to 9 with 24 × 24 pixels.
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        let [coarse, fine] = RULES.map(|rule| self.image(shape, rule));
        let error = crate::relative_error(&coarse, &fine);
        Reference { image: fine, error }
    }

    fn image(&self, [height, width]: [usize; 2], [across, panels, along]: [usize; 3]) -> Image {
        let (across, along) = (Gauss::new(across), Gauss::new(along));
        let line = |x: f64, y: f64| {
            along.integrate_panels([0.0, 1.0], panels, |z| {
                self.rate([x, y, z]) * (-self.optical_depth([x, y, z])).exp()
            })
        };
        let pixel = |row: usize, column: usize| {
            let borders = |at: usize, count: usize| {
                [at as f64 / count as f64, (at + 1) as f64 / count as f64]
            };
            let ([bottom, top], [left, right]) = (borders(row, height), borders(column, width));
            let integral =
                across.integrate(bottom, top, |y| across.integrate(left, right, |x| line(x, y)));
            integral * height as f64 * width as f64
        };
        let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
        Image::from_pixels(height, width, pixels.map(|(row, column)| pixel(row, column)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coefficient_is_the_derivative_of_the_optical_depth() {
        for seed in 0..20 {
            let medium = random_medium(seed);
            let depth = |z: f64| medium.optical_depth([0.4, 0.55, z]);
            for z in [0.1, 0.5, 0.9] {
                let slope = (depth(z + 1e-5) - depth(z - 1e-5)) / 2e-5;
                let coefficient = medium.coefficient([0.4, 0.55, z]);
                assert!((slope - coefficient).abs() < 1e-5 * (1.0 + coefficient), "{seed} {z}");
            }
        }
    }

    #[test]
    fn references_are_known_to_their_error() {
        for seed in 0..10 {
            let reference = random_medium(seed).reference_image([24, 24]);
            assert!(reference.error < 2e-6, "{seed}: {}", reference.error);
        }
    }
}
