//! A shell nebula: uniform between two spheres, with a kink of infinite slope at both limbs.
//!
//! The image is 2 (√(R₂² − b²) − √(R₁² − b²)) at distance b from the centre, each root 0 where it
//! is not real: a ball without a smaller ball.

use crate::ball::Ball;
use emitree::Image;

pub use crate::ball::IMAGE_ERROR;

/// A spherical shell of emission rate 1, dark inside and outside; the default lies between the
/// radii 0.25 and 0.35.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nebula {
    /// The centre.
    pub centre: [f64; 3],
    /// The inner radius R₁.
    pub inner: f64,
    /// The outer radius R₂. The nebula must not reach beyond 0 ≤ z ≤ 1.
    pub outer: f64,
}

impl Default for Nebula {
    fn default() -> Self {
        Self { centre: Ball::default().centre, inner: 0.25, outer: 0.35 }
    }
}

impl Nebula {
    /// The emission rate at a point: 1 in the shell and 0 elsewhere.
    ///
    /// ```
    /// let nebula = emitree_problems::nebula::Nebula::default();
    /// let [x, y, z] = nebula.centre;
    /// assert_eq!(nebula.rate([x, y, z]), 0.0);
    /// assert_eq!(nebula.rate([x, y, z - 0.3]), 1.0);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let [outer, inner] = self.balls();
        outer.rate(position) - inner.rate(position)
    }

    /// The exact image of `shape` = \[height, width\] pixels in the canonical projection, to
    /// [`IMAGE_ERROR`].
    ///
    /// ```
    /// let image = emitree_problems::nebula::Nebula::default().exact_image([64, 64]);
    /// assert!((image[(30, 32)] - 0.2).abs() < 1e-3); // two walls of 0.1
    /// ```
    ///
    /// # Panics
    ///
    /// If the nebula reaches beyond 0 ≤ z ≤ 1.
    pub fn exact_image(&self, shape: [usize; 2]) -> Image {
        let [mut image, inner] = self.balls().map(|ball| ball.exact_image(shape));
        for (pixel, hole) in image.pixels_mut().iter_mut().zip(inner.pixels()) {
            *pixel -= hole;
        }
        image
    }

    fn balls(&self) -> [Ball; 2] {
        [self.outer, self.inner].map(|radius| Ball { centre: self.centre, radius })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of the rate itself, on a grid of 200 × 200 × 400 in each pixel.
    #[test]
    fn pixels_agree_with_counted_points() {
        let nebula = Nebula::default();
        let exact = nebula.exact_image([16, 20]);
        for [row, column] in [[7, 10], [7, 4], [3, 12], [12, 14]] {
            let mut inside = 0.0;
            for i in 0..200 * 200 {
                let y = (row as f64 + (f64::from(i / 200) + 0.5) / 200.0) / 16.0;
                let x = (column as f64 + (f64::from(i % 200) + 0.5) / 200.0) / 20.0;
                let z = |k: i32| (f64::from(k) + 0.5) / 400.0;
                inside += (0..400).map(|k| nebula.rate([x, y, z(k)])).sum::<f64>();
            }
            assert!((exact[(row, column)] - inside / 1.6e7).abs() < 3e-4);
        }
    }

    /// The rate is 0 outside, and the volume is right.
    #[test]
    fn the_image_holds_the_volume() {
        let image = Nebula::default().exact_image([64, 64]);
        let volume = 4.0 / 3.0 * core::f64::consts::PI * (0.35_f64.powi(3) - 0.25_f64.powi(3));
        assert!((image.pixels().iter().sum::<f64>() / 4096.0 - volume).abs() < 1e-15);
        assert!(image[(0, 0)].abs() < 1e-12);
    }
}
