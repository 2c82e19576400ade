//! Sums of Gaussians of any brightness, anywhere along a depth range, with exact images.

use emitree::Image;
use emitree_models::means;

/// Amplitude, centre and distance of 1/e of a Gaussian.
pub(crate) type WeightedGaussian = (f64, [f64; 3], f64);

/// The sum of the rates at a point.
pub(crate) fn rate(gaussians: &[WeightedGaussian], at: [f64; 3]) -> f64 {
    let of = |(amplitude, centre, width): &WeightedGaussian| {
        let square: f64 = at.iter().zip(centre).map(|(a, c)| (a - c).powi(2)).sum();
        amplitude * (-square / (width * width)).exp()
    };
    gaussians.iter().map(of).sum()
}

/// The exact image of `shape` = \[height, width\] pixels of the unit square, seen along z between two depths, in means
/// over these.
pub(crate) fn exact_image(
    gaussians: &[WeightedGaussian],
    depths: [f64; 2],
    [height, width]: [usize; 2],
) -> Image {
    let mut pixels = vec![0.0; height * width];
    for (amplitude, centre, scale) in gaussians {
        let mean = |axis: usize, [from, to]: [f64; 2]| {
            means::gaussian(1.0 / (scale * scale), centre[axis], from, to)
        };
        let part = |i: usize, n: usize| [i, i + 1].map(|end| end as f64 / n as f64);
        let of_columns: Vec<f64> = (0..width).map(|column| mean(0, part(column, width))).collect();
        let depth = amplitude * mean(2, depths);
        for (row, pixels) in pixels.chunks_exact_mut(width).enumerate() {
            let of_row = depth * mean(1, part(row, height));
            pixels.iter_mut().zip(&of_columns).for_each(|(pixel, mean)| *pixel += of_row * mean);
        }
    }
    Image::from_pixels(height, width, pixels)
}
