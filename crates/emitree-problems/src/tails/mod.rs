//! Tails: emissions and lines of sight that reach to infinity, by number.
//!
//! [`random_tail`] makes the scene of a seed. The emission is the seed modulo 4, with R² = 1 + r²:
//!
//! | kind | g |
//! | --- | --- |
//! | 0 powers | 1–2 flattened cores (1 + ρ²/a²)^(−p/2), p from 1.5 to 3, a from 0.3 to 1 |
//! | 1 oscillations | R^−p cos²(k R + φ), p from 2 to 3, k from 1 to 5 |
//! | 2 spirals | R^−2 exp(κ (cos(m λ + k R + φ) − 1)), λ the azimuth: thin sheets, m = 1 or 2, with an opening angle that flares and a hole along the axis |
//! | 3 clumps | 150 Gaussians with R^−2 as their envelope, out to r = 40, and a tenth of it that is smooth |
//!
//! The camera is a quarter of the seed modulo 4: a perspective from outside, one from inside, parallel lines
//! from −∞ to ∞, and parallel lines from a plane to ∞. Every seed is a scene for ever: [`random_tail`] must
//! not change.
//!
//! # The reference image
//!
//! Lines are integrated in closed form (clumps) or by Gauss–Legendre panels in s up to where the emission
//! is simple, and in u with s = c sinh u from there to infinity, where it is a power. What oscillates for
//! ever is blended there into its mean, over ten periods and so softly that what is neglected is below 1e-8
//! of the image. Across the image panels carry polynomials, as in [`family`](crate::family). The error is
//! the difference to a coarser rule.

mod glow;
mod line;
mod view;

use crate::family::Reference;
use crate::family::generator::Generator;
use crate::gauss::Gauss;
use crate::panels::{self, PanelAxis};
use emitree::projection::GeometryError;
use emitree::{Image, Projection};
use glow::Glow;
use view::View;

/// Panels along each axis of the image.
const PANELS: usize = 10;
/// Nodes of a panel across the image and along lines, coarse and fine.
const NODES: [[usize; 2]; 2] = [[8, 8], [11, 11]];
/// What is neglected of oscillations, and rounding, relative to the largest pixel.
const NEGLECTED: f64 = 1e-8;

/// A scene of the family.
#[derive(Clone, Debug, PartialEq)]
pub struct Tail {
    seed: u64,
    glow: Glow,
    view: View,
}

/// The scene of a seed: its emission is the seed modulo 4, its camera a quarter of the seed modulo 4.
///
/// ```
/// let tail = emitree_problems::tails::random_tail(6);
/// assert_eq!(tail.name(), "spiral from inside, 6");
/// ```
pub fn random_tail(seed: u64) -> Tail {
    // Another stream than those of the other families.
    let mut generator = Generator::new(seed ^ 0x7a11_0000_0000_0000);
    let glow = Glow::draw(seed % 4, &mut generator);
    let view = View::draw(seed / 4 % 4, &mut generator);
    Tail { seed, glow, view }
}

impl Tail {
    /// The kind, the camera and the seed.
    pub fn name(&self) -> String {
        format!("{} {}, {}", self.glow.name(), self.view.name(), self.seed)
    }

    /// The emission rate.
    ///
    /// ```
    /// let tail = emitree_problems::tails::random_tail(0);
    /// assert!(tail.rate([1.0; 3]) > tail.rate([100.0; 3]));
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.glow.rate(position)
    }

    /// The camera, with far = ∞.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] never, for the numbers that are drawn.
    pub fn camera(&self) -> Result<Box<dyn Projection>, GeometryError> {
        self.view.camera()
    }

    /// The image of `shape` = \[height, width\] pixels, by [quadrature](self#the-reference-image), and its
    /// error.
    ///
    /// ```
    /// let reference = emitree_problems::tails::random_tail(3).reference_image([6, 4]);
    /// assert!(reference.error < 1e-4);
    /// ```
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        let [coarse, fine] = NODES.map(|nodes| self.image(shape, nodes));
        let error = fine.max_difference(&coarse) / fine.min_max().1 + NEGLECTED;
        Reference { image: fine, error }
    }

    fn image(&self, [height, width]: [usize; 2], [across, along]: [usize; 2]) -> Image {
        let rule = Gauss::new(along);
        let borders: Vec<f64> = (0..=PANELS).map(|i| i as f64 / PANELS as f64).collect();
        let axis = |pixels| PanelAxis::new(&borders, across, pixels);
        // A pixel is the mean over its solid angle.
        let bands = panels::images(&axis(width), &axis(height), 2, |x, y, values| {
            let (line, weight) = self.view.line([x, y]);
            values[0] = weight * self.glow.radiance(&line, &rule);
            values[1] = weight;
        });
        let pairs = bands[0].pixels().iter().zip(bands[1].pixels());
        Image::from_pixels(height, width, pairs.map(|(sum, weight)| sum / weight).collect())
    }
}

#[cfg(test)]
mod tests;
