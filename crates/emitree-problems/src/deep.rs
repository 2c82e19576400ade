//! Gaussians in a small part of a long depth range: what a user renders who does not know where the
//! emission ends.

use crate::family::generator::Generator;
use crate::weighted_gaussians::{self, WeightedGaussian};
use emitree::Image;

/// Seeds are those of streams from here on.
const FIRST_STREAM: u64 = 7 << 32;
/// The number of Gaussians, and their distances of 1/e.
const COUNT: [f64; 2] = [2.0, 7.0];
const WIDTHS: [f64; 2] = [0.06, 0.3];
/// The centres along each axis.
const CENTRES: [f64; 2] = [0.25, 0.75];
/// The share of scenes with a Gaussian anywhere in the long depth range.
const OUTLYING: f64 = 1.0 / 3.0;

/// A sum of Gaussians in the unit cube, seen along z from `depths[0]` to `depths[1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct DeepScene {
    /// The ends of the depth range, in edges of the cube that the Gaussians are in.
    pub depths: [f64; 2],
    gaussians: Vec<WeightedGaussian>,
}

/// The scene of a seed in a depth range `factor` times as long as the cube. In one third of the scenes one
/// Gaussian is anywhere in that range.
///
/// ```
/// let scene = emitree_problems::deep::random_deep(3, 10.0);
/// assert!((scene.depths[1] - scene.depths[0] - 10.0).abs() < 1e-12);
/// ```
pub fn random_deep(seed: u64, factor: f64) -> DeepScene {
    let mut generator = Generator::new(FIRST_STREAM + seed);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "2 to 7")]
    let count = generator.between(COUNT[0], COUNT[1]) as usize;
    let gaussian = |generator: &mut Generator| {
        let amplitude = generator.between(0.3, 1.0);
        let centre = [(); 3].map(|()| generator.between(CENTRES[0], CENTRES[1]));
        (amplitude, centre, generator.between(WIDTHS[0], WIDTHS[1]))
    };
    let mut gaussians: Vec<_> = (0..count).map(|_| gaussian(&mut generator)).collect();
    let before = generator.between(0.0, 1.0) * (factor - 1.0);
    let depths = [-before, factor - before];
    if generator.between(0.0, 1.0) < OUTLYING {
        let (amplitude, [x, y, _], width) = gaussian(&mut generator);
        let margin = width.min(0.25);
        let z = generator.between(depths[0] + margin, depths[1] - margin);
        gaussians.push((amplitude, [x, y, z], width));
    }
    DeepScene { depths, gaussians }
}

impl DeepScene {
    /// The emission rate at a point of the unit cube, whose z is the share of the depth range.
    pub fn rate(&self, [x, y, z]: [f64; 3]) -> f64 {
        let [near, far] = self.depths;
        let at = [x, y, near + z * (far - near)];
        weighted_gaussians::rate(&self.gaussians, at)
    }

    /// The exact image of `shape` = \[height, width\] pixels in the canonical projection.
    pub fn exact_image(&self, shape: [usize; 2]) -> Image {
        weighted_gaussians::exact_image(&self.gaussians, self.depths, shape)
    }
}
