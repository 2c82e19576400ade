//! A curved shock: twenty times brighter in front of a paraboloid than behind it, in a smooth
//! background.
//!
//! g = h / (0.1 + |r − (0.5, 0.5, 0.3)|²) with h = 1 where z < 0.8 − 1.5 ((x − 0.5)² + (y − 0.5)²) and
//! 0.05 elsewhere. g jumps, yet its image is smooth: the surface is a function of x and y that stays
//! within the cube, and no line of sight is tangent to it.

use crate::panels::{self, PanelAxis};
use emitree::Image;

/// The depth of the brightest point.
const DEPTH: f64 = 0.3;
/// The square of the radius of the core.
const CORE: f64 = 0.1;
/// g behind the shock relative to g before it.
const BEHIND: f64 = 0.05;

/// A bound on the largest error of a pixel of [`exact_image`], relative to the largest pixel.
pub const IMAGE_ERROR: f64 = 1e-13;

/// The emission rate at a point of the unit cube.
///
/// ```
/// use emitree_problems::shock::rate;
///
/// assert_eq!(rate([0.5, 0.5, 0.3]), 10.0);
/// assert!(rate([0.5, 0.5, 0.79]) > 19.0 * rate([0.5, 0.5, 0.81]));
/// ```
pub fn rate([x, y, z]: [f64; 3]) -> f64 {
    let across = (x - 0.5).powi(2) + (y - 0.5).powi(2);
    let factor = if z < surface(x, y) { 1.0 } else { BEHIND };
    factor / (CORE + across + (z - DEPTH).powi(2))
}

/// The depth of the shock, between 0.05 and 0.8 on the unit square.
fn surface(x: f64, y: f64) -> f64 {
    0.8 - 1.5 * ((x - 0.5).powi(2) + (y - 0.5).powi(2))
}

/// The image of `shape` = \[height, width\] pixels, to [`IMAGE_ERROR`]: closed along z, and by
/// Gauss–Legendre quadrature over the pixels.
///
/// ```
/// let image = emitree_problems::shock::exact_image([3, 3]);
/// assert_eq!(image.min_max().1, image[(1, 1)]);
/// ```
pub fn exact_image([height, width]: [usize; 2]) -> Image {
    // The nearest singularity lies √0.1 from the square. Panels of 1/8 with 16 nodes leave less
    // than rounding.
    let borders: Vec<f64> = (0..=8).map(|i| f64::from(i) / 8.0).collect();
    let axis = |pixels| PanelAxis::new(&borders, 16, pixels);
    panels::image(&axis(width), &axis(height), line)
}

/// ∫ g dz over \[0, 1\]: arctan on both sides of the shock.
fn line(x: f64, y: f64) -> f64 {
    let scale = (CORE + (x - 0.5).powi(2) + (y - 0.5).powi(2)).sqrt();
    let primitive = |z: f64| ((z - DEPTH) / scale).atan() / scale;
    let at_shock = primitive(surface(x, y));
    at_shock - primitive(0.0) + BEHIND * (primitive(1.0) - at_shock)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute;
    use crate::gauss::Gauss;

    /// Sum, largest and smallest pixel of an image that was made with 8 × 8 nodes a pixel, in
    /// another language.
    #[test]
    fn the_image_agrees_with_an_independent_one() {
        let image = exact_image([64, 64]);
        let (low, high) = image.min_max();
        assert!((high - 5.598_769_619_255_256).abs() < 1e-14);
        assert!((low - 0.179_431_400_719_096_36).abs() < 1e-14);
        let sum: f64 = image.pixels().iter().sum();
        assert!((sum - 9_531.881_315_511_473).abs() < 1e-10);
    }

    /// Quadrature of the rate on either side of the shock.
    #[test]
    fn pixels_agree_with_quadrature_along_z() {
        let (shape, depth) = ([20, 30], Gauss::new(20));
        let exact = exact_image(shape);
        for at in [[0, 0], [10, 15], [3, 28], [19, 1]] {
            let brute = brute::mean(shape, at, &Gauss::new(10), |x, y| {
                [[0.0, surface(x, y)], [surface(x, y), 1.0]]
                    .iter()
                    .map(|&range| depth.integrate_panels(range, 4, |z| rate([x, y, z])))
                    .sum()
            });
            assert!((exact[at.into()] - brute).abs() < 1e-13);
        }
    }
}
