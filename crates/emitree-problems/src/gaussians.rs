//! Several Gaussian balls: structure on several lengths at once.

use crate::gaussian::Gaussian;
use emitree::Image;

/// The sum of [`Gaussian`] balls; the default has four, of widths from 0.05 to 0.3.
#[derive(Clone, Debug, PartialEq)]
pub struct Gaussians(pub Vec<Gaussian>);

impl Default for Gaussians {
    fn default() -> Self {
        Self(vec![
            Gaussian { centre: [0.3, 0.4, 0.6], width: 0.3 },
            Gaussian { centre: [0.7, 0.65, 0.35], width: 0.12 },
            Gaussian { centre: [0.62, 0.27, 0.71], width: 0.08 },
            Gaussian { centre: [0.21, 0.77, 0.44], width: 0.05 },
        ])
    }
}

impl Gaussians {
    /// The emission rate at a point.
    ///
    /// ```
    /// let balls = emitree_problems::gaussians::Gaussians::default();
    /// assert!((balls.rate([0.21, 0.77, 0.44]) - 1.0).abs() < 0.2);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.0.iter().map(|ball| ball.rate(position)).sum()
    }

    /// The exact image of `shape` = \[height, width\] pixels in the canonical projection.
    ///
    /// ```
    /// let image = emitree_problems::gaussians::Gaussians::default().exact_image([10, 10]);
    /// assert!(image[(4, 3)] > image[(9, 9)]);
    /// ```
    pub fn exact_image(&self, shape: [usize; 2]) -> Image {
        let mut image = Image::zeros(shape[0], shape[1]);
        for ball in &self.0 {
            let one = ball.exact_image(shape);
            for (sum, pixel) in image.pixels_mut().iter_mut().zip(one.pixels()) {
                *sum += pixel;
            }
        }
        image
    }
}
