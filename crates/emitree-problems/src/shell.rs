//! A soft spherical shell with a gradient: smooth, thin, and separable in no coordinates of the
//! cube.
//!
//! g = exp(−((r − 0.35)/0.03)²) (1 + x/2), r the distance from (0.5, 0.47, 0.52). There is no closed
//! form: the image is by quadrature.

use crate::gauss::Gauss;
use crate::panels::{self, PanelAxis};
use emitree::Image;

/// The centre of the shell.
const CENTRE: [f64; 3] = [0.5, 0.47, 0.52];
/// The radius at which it is brightest.
const RADIUS: f64 = 0.35;
/// The distance from there at which it has fallen to 1/e.
const WIDTH: f64 = 0.03;
/// Nodes of a panel across the image: 26 give the same image to 3e-13, 32 to 3e-14.
const ACROSS: usize = 28;
/// Nodes of a panel along z; a panel is 4 widths long.
const ALONG: usize = 18;

/// A bound on the largest error of a pixel of [`exact_image`], relative to the largest pixel.
pub const IMAGE_ERROR: f64 = 1e-11;

/// The emission rate at a point of the unit cube.
///
/// ```
/// let rate = emitree_problems::shell::rate([0.85, 0.47, 0.52]);
/// assert!((rate - 1.425).abs() < 1e-12);
/// ```
pub fn rate([x, y, z]: [f64; 3]) -> f64 {
    let square = (x - CENTRE[0]).powi(2) + (y - CENTRE[1]).powi(2) + (z - CENTRE[2]).powi(2);
    let distance = (square.sqrt() - RADIUS) / WIDTH;
    (-distance * distance).exp() * (1.0 + 0.5 * x)
}

/// The image of `shape` = \[height, width\] pixels, to [`IMAGE_ERROR`].
///
/// ```
/// let image = emitree_problems::shell::exact_image([8, 8]);
/// assert!(image[(4, 7)] > image[(4, 0)]); // brighter towards large x
/// ```
pub fn exact_image(shape: [usize; 2]) -> Image {
    image(shape, ACROSS, ALONG)
}

fn image([height, width]: [usize; 2], across: usize, along: usize) -> Image {
    let axis = |pixels| PanelAxis::uniform(WIDTH, across, pixels);
    let depth = Gauss::new(along);
    let panels = panels::count(1.0, WIDTH);
    panels::image(&axis(width), &axis(height), |x, y| {
        depth.integrate_panels([0.0, 1.0], panels, |z| rate([x, y, z]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{brute, relative_error};

    /// Sum, largest and smallest pixel of an image by other nodes, in another language, with 8 × 8
    /// nodes a pixel and 512 along z.
    #[test]
    fn the_image_agrees_with_an_independent_one() {
        let image = exact_image([64, 64]);
        let (low, high) = image.min_max();
        let scale = 0.441_259_681_581_071_1;
        assert!((high - scale).abs() < IMAGE_ERROR * scale);
        assert!((low - 4.411_362_728_452_924e-65).abs() < IMAGE_ERROR * scale);
        let sum: f64 = image.pixels().iter().sum();
        assert!((sum - 420.634_169_654_585).abs() < 1e-9);
    }

    #[test]
    fn more_nodes_and_brute_force_give_the_same() {
        let shape = [48, 64];
        let exact = exact_image(shape);
        assert!(relative_error(&image(shape, 36, 24), &exact) < IMAGE_ERROR);
        let (_, largest) = exact.min_max();
        for at in [[5, 32], [23, 9], [24, 31], [40, 12], [41, 45], [0, 0]] {
            let brute = brute::pixel(rate, shape, at, 8);
            assert!((exact[at.into()] - brute).abs() < IMAGE_ERROR * largest);
        }
    }
}
