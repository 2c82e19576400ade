//! Narrow glowing wires wound through the view: loops of a corona, filaments, field lines.

use crate::family::generator::Generator;
use crate::weighted_gaussians::{self, WeightedGaussian};
use core::f64::consts::PI;
use emitree::Image;

/// Seeds are those of streams from here on.
const FIRST_STREAM: u64 = 11 << 32;
/// The distance of neighbouring Gaussians of a wire, in their widths: their sum varies by less than 1e-6
/// along it.
const SPACING: f64 = 0.6;
/// The distance of 1/e from the middle of a wire.
const WIDTHS: [f64; 2] = [0.02, 0.06];

/// A sum of helices in the unit cube, each a row of Gaussians, seen along z.
#[derive(Clone, Debug, PartialEq)]
pub struct Wires {
    gaussians: Vec<WeightedGaussian>,
}

/// The scene of a seed: one to three helices about random axes through points near the middle, with radii from
/// 0.08 to 0.3, one to six turns, lengths from 0.2 to 0.7 and a brightness that decreases towards both ends. Every
/// seed is a scene for ever: [`random_wires`] must not change.
///
/// ```
/// let scene = emitree_problems::wires::random_wires(3);
/// assert!(scene.exact_image([8, 8]).min_max().1 > 0.0);
/// ```
pub fn random_wires(seed: u64) -> Wires {
    let mut generator = Generator::new(FIRST_STREAM + seed);
    let mut gaussians = Vec::new();
    for _ in 0..generator.whole(1..=3) {
        let [along, aside, up] = generator.axes();
        let centre = [(); 3].map(|()| generator.between(0.4, 0.6));
        let width = generator.between(WIDTHS[0], WIDTHS[1]);
        let radius = generator.between(0.08, 0.3);
        let length = generator.between(0.2, 0.7);
        let angle = 2.0 * PI * generator.between(1.0, 6.0);
        let amplitude = generator.between(0.3, 1.0);
        let beads = (angle.hypot(length / radius) * radius / (SPACING * width)).ceil();
        let mut k = 0.0;
        while k <= beads {
            // From −1 to 1 along the wire.
            let t = 2.0 * k / beads - 1.0;
            let (sin, cos) = (0.5 * angle * t).sin_cos();
            let place = core::array::from_fn(|i| {
                let about = radius * (cos * aside[i] + sin * up[i]);
                centre[i] + 0.5 * length * t * along[i] + about
            });
            gaussians.push((amplitude * (-4.0 * t.powi(4)).exp(), place, width));
            k += 1.0;
        }
    }
    Wires { gaussians }
}

impl Wires {
    /// The emission rate at a point of the unit cube.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        weighted_gaussians::rate(&self.gaussians, position)
    }

    /// The exact image of `shape` = \[height, width\] pixels in the canonical projection.
    pub fn exact_image(&self, shape: [usize; 2]) -> Image {
        weighted_gaussians::exact_image(&self.gaussians, [0.0, 1.0], shape)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_is_the_integral_of_the_rate() {
        let scene = random_wires(5);
        let image = scene.exact_image([24, 24]);
        let brightest = image.min_max().1;
        // Midpoints: Gaussians of 0.02 are integrated to 1e-6 by intervals of 1/128.
        let n = 192;
        let middle = |i: usize, of: f64| (i as f64 + 0.5) / of;
        let pixel = |row: usize, column: usize| {
            let mut sum = 0.0;
            for [i, j] in (0..64).map(|k| [k / 8, k % 8]) {
                let [x, y] = [middle(8 * column + i, 192.0), middle(8 * row + j, 192.0)];
                sum += (0..n).map(|k| scene.rate([x, y, middle(k, 192.0)])).sum::<f64>();
            }
            sum / (64.0 * n as f64)
        };
        for (row, column) in [(11, 14), (8, 9), (17, 12)] {
            let difference = (pixel(row, column) - image[(row, column)]).abs();
            assert!(difference < 1e-3 * brightest, "{row} {column}: {difference:e} {brightest}");
        }
        assert!(brightest > 0.0);
    }
}
