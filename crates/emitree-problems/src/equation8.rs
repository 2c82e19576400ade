//! Eq. (8) of the paper: a smooth function with a peak.
//!
//! g = (sin 5x sin 7y sin 11z / 10)² + exp(−α (x − √2/3)²/√2 − α (y − √7/5)² √2 − α (z − √6/5)² √3)
//! with α = 100 in the paper. The rate has the sines and exponentials of the standard library, and so
//! other last bits than the model.

use emitree::Image;
use emitree_models::models::Holmstrom;

/// The α of the paper.
pub const ALPHA: f64 = 100.0;

/// The emission rate at a point of the unit cube.
///
/// ```
/// use emitree_problems::equation8::{rate, ALPHA};
///
/// let centre = [2_f64.sqrt() / 3.0, 7_f64.sqrt() / 5.0, 6_f64.sqrt() / 5.0];
/// assert!((rate(centre, ALPHA) - 1.0).abs() < 0.01);
/// ```
pub fn rate([x, y, z]: [f64; 3], alpha: f64) -> f64 {
    let waves = (5.0 * x).sin() * (7.0 * y).sin() * (11.0 * z).sin() / 10.0;
    let [cx, cy, cz] = centre();
    let [ax, ay, az] = inverse_squares(alpha);
    waves * waves + (-ax * (x - cx).powi(2) - ay * (y - cy).powi(2) - az * (z - cz).powi(2)).exp()
}

/// The exact image of `shape` = \[height, width\] pixels.
pub fn exact_image(alpha: f64, shape: [usize; 2]) -> Image {
    Holmstrom::with_alpha(alpha).exact_image(shape)
}

fn centre() -> [f64; 3] {
    [2_f64.sqrt() / 3.0, 7_f64.sqrt() / 5.0, 6_f64.sqrt() / 5.0]
}

fn inverse_squares(alpha: f64) -> [f64; 3] {
    [alpha / 2_f64.sqrt(), alpha * 2_f64.sqrt(), alpha * 3_f64.sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum, largest and smallest pixel of an image that was made in 40 digits, elsewhere.
    #[test]
    fn the_image_agrees_with_an_independent_one() {
        let image = exact_image(ALPHA, [64, 64]);
        let (low, high) = image.min_max();
        assert!((high - 0.133_824_707_425_712_45).abs() < 1e-15);
        assert!((low - 5.322_024_676_125_433e-9).abs() < 1e-16);
        assert!((image.pixels().iter().sum::<f64>() - 22.348_803_588_968_29).abs() < 1e-12);
    }

    /// x is the column: the peak is left of and above the middle.
    #[test]
    fn the_peak_is_where_it_should_be() {
        let image = exact_image(ALPHA, [50, 30]);
        let brightest = |&(a, _): &(usize, &f64), &(b, _): &(usize, &f64)| {
            image.pixels()[a].total_cmp(&image.pixels()[b])
        };
        let (at, _) = image.pixels().iter().enumerate().max_by(brightest).unwrap();
        assert_eq!((at / 30, at % 30), (26, 14));
    }
}
