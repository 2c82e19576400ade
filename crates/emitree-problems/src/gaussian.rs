//! A Gaussian ball of any width, anywhere.

use crate::means;
use emitree::Image;

/// g = exp(−|r − centre|² / width²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// The brightest point, in the unit cube.
    pub centre: [f64; 3],
    /// The distance at which g has fallen to 1/e.
    pub width: f64,
}

impl Gaussian {
    /// The emission rate at a point.
    ///
    /// ```
    /// let ball = emitree_problems::gaussian::Gaussian { centre: [0.5; 3], width: 0.1 };
    /// assert_eq!(ball.rate([0.5; 3]), 1.0);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let square: f64 = (0..3).map(|i| (position[i] - self.centre[i]).powi(2)).sum();
        (-square / (self.width * self.width)).exp()
    }

    /// The exact image of `shape` = \[height, width\] pixels in the canonical projection.
    pub fn exact_image(&self, [height, width]: [usize; 2]) -> Image {
        let a = 1.0 / (self.width * self.width);
        let mean = |axis: usize, i: usize, n: usize| {
            means::gaussian(a, self.centre[axis], i as f64 / n as f64, (i + 1) as f64 / n as f64)
        };
        let depth = mean(2, 0, 1);
        let rows = (0..height).flat_map(|row| {
            let row_mean = depth * mean(1, row, height);
            (0..width).map(move |column| row_mean * mean(0, column, width))
        });
        Image::from_pixels(height, width, rows.collect())
    }
}
