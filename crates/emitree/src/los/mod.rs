//! Line-of-sight integration: the baseline, and what others do today.
//!
//! Each pixel is the mean over n × n lines of sight through the centres of its n × n parts, weighted
//! with their solid angles. Along a line either equal steps are taken (`fixed`) or steps that an
//! error estimate chooses (`adaptive`). Nothing is shared between lines.

pub(crate) mod adaptive;
pub(crate) mod fixed;

use crate::image::Image;
use crate::projection::Projection;
use crate::radiance::PixelRows;

/// How each line of sight is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steps {
    /// This many equal steps, with g at the middle of each.
    Fixed(usize),
    /// Bisected panels of the 15-point Gauss–Kronrod rule, until the estimated error **along each
    /// line** is below this fraction of the largest line's radiance.
    Adaptive(f64),
}

/// Options of the line-of-sight method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LosOptions {
    /// n of n × n lines of sight for each pixel.
    pub lines: usize,
    /// How each is integrated.
    pub steps: Steps,
}

impl Default for LosOptions {
    /// One line for each pixel, 64 equal steps.
    fn default() -> Self {
        Self { lines: 1, steps: Steps::Fixed(64) }
    }
}

/// All lines of sight of an image, pixel after pixel.
#[derive(Clone, Copy, Debug)]
struct Lines {
    height: usize,
    width: usize,
    /// n of n × n lines for each pixel.
    per_side: usize,
}

impl Lines {
    fn per_pixel(&self) -> usize {
        self.per_side * self.per_side
    }

    fn count(&self) -> usize {
        self.height * self.width * self.per_pixel()
    }

    /// Canonical (x, y) of a line.
    fn position(&self, line: usize) -> [f64; 2] {
        let (pixel, part) = (line / self.per_pixel(), line % self.per_pixel());
        let at = |pixel: usize, part: usize, pixels: usize| {
            (pixel as f64 + (part as f64 + 0.5) / self.per_side as f64) / pixels as f64
        };
        [
            at(pixel % self.width, part % self.per_side, self.width),
            at(pixel / self.width, part / self.per_side, self.height),
        ]
    }

    /// The image of one value for each line: means over each pixel's lines, weighted with the solid
    /// angle that each stands for.
    fn image(&self, projection: &dyn Projection, values: &[f64]) -> Image {
        let per_row = self.width * self.per_pixel();
        PixelRows { projection, shape: [self.height, self.width] }.map(|row, pixels| {
            let values = &values[row * per_row..][..per_row];
            let of_pixels = values.chunks_exact(self.per_pixel()).enumerate();
            for (pixel, (column, values)) in pixels.iter_mut().zip(of_pixels) {
                let (mut sum, mut weights) = (0.0, 0.0);
                for (part, value) in values.iter().enumerate() {
                    let line = row * per_row + column * self.per_pixel() + part;
                    let weight = projection.solid_angle_density(self.position(line));
                    sum += weight * value;
                    weights += weight;
                }
                *pixel = sum / weights;
            }
        })
    }
}

#[cfg(test)]
mod tests;
