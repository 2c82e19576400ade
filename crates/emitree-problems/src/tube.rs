//! A bent tube, closed to a tilted ring: g in it changes linearly, and a faint smooth glow is around it.
//!
//! The ring is a torus of radius 0.25 with a tube of radius 0.07 around the centre of the unit cube, tilted about
//! the x axis by arctan 3/4, so that lines of sight cross its surface up to four times. In the tube g is
//! 1 + 5 (x − ½) / 3, which is constant along a line of sight, and everywhere ⅕ exp(−4 d²) is added at the distance d from the
//! centre: ∫ g dz is the sum of the chords and an error function. The ends of the chords are bisected to rounding between
//! 97 depths where the tube may be; a chord between two of them is shorter than 1/500, and missed.

use crate::family::Reference;
use crate::solids::mean_of_lines;
use core::f64::consts::PI;

/// The radius of the ring, and that of the tube.
const RING: f64 = 0.25;
const TUBE: f64 = 0.07;
/// The cosine and the sine of the tilt.
const TILT: [f64; 2] = [0.8, 0.6];
/// The intervals of depth in which the ends of chords are searched for, and the bisections of each.
const INTERVALS: u32 = 96;
const BISECTIONS: u32 = 45;

/// The emission rate at a point of the unit cube.
///
/// ```
/// use emitree_problems::tube;
///
/// // In the tube, and in the middle of the ring.
/// assert!(tube::rate([0.75, 0.5, 0.5]) > 1.0);
/// assert_eq!(tube::rate([0.5; 3]), 0.2);
/// ```
pub fn rate(position: [f64; 3]) -> f64 {
    let [x, y, z] = position.map(|along| along - 0.5);
    let inside = if inwards(position) > 0.0 { brightness(x) } else { 0.0 };
    inside + 0.2 * (-4.0 * (x * x + y * y + z * z)).exp()
}

/// g in the tube without the glow, at x − ½.
fn brightness(x: f64) -> f64 {
    1.0 + 0.5 * x / 0.3
}

/// The square of the radius of the tube, less that of the distance from its axis.
fn inwards(position: [f64; 3]) -> f64 {
    let [x, y, z] = position.map(|along| along - 0.5);
    let [across, up] = [TILT[0] * y - TILT[1] * z, TILT[1] * y + TILT[0] * z];
    TUBE * TUBE - (x.hypot(across) - RING).powi(2) - up * up
}

/// ∫ g dz over 0 ≤ z ≤ 1 at (x, y).
///
/// ```
/// let through_both_sides = emitree_problems::tube::line_integral([0.5, 0.5]);
/// assert!(through_both_sides > 0.14);
/// ```
pub fn line_integral([x, y]: [f64; 2]) -> f64 {
    let is_inside = |z: f64| inwards([x, y, z]) > 0.0;
    // No point of the tube is further from the plane of the ring than its radius.
    let [low, high] = [-TUBE, TUBE].map(|up| 0.5 + (up - TILT[1] * (y - 0.5)) / TILT[0]);
    let depth = |k: u32| (low + (high - low) * f64::from(k) / f64::from(INTERVALS)).clamp(0.0, 1.0);
    let mut chords = 0.0;
    // No point of the tube is further from the centre along x or y.
    let is_beside = [x, y].iter().any(|along| (along - 0.5).abs() > RING + TUBE);
    let intervals = if is_beside { 0 } else { INTERVALS };
    for k in 0..intervals {
        let [from, to] = [depth(k), depth(k + 1)];
        chords += match [is_inside(from), is_inside(to)] {
            [false, false] => 0.0,
            [true, true] => to - from,
            [first, _] => {
                let (mut low, mut high) = (from, to);
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (low + high);
                    if is_inside(middle) == first { low = middle } else { high = middle }
                }
                if first { low - from } else { to - low }
            }
        };
    }
    let [x, y] = [x - 0.5, y - 0.5];
    let glow = 0.2 * (-4.0 * (x * x + y * y)).exp() * 0.5 * PI.sqrt() * libm::erf(1.0);
    chords * brightness(x) + glow
}

/// The image of `shape` = \[height, width\] pixels in the canonical projection: the mean of
/// 32 × 32 lines for each pixel. Its error is the difference to the mean of 16 × 16.
///
/// ```
/// let reference = emitree_problems::tube::reference_image([4, 6]);
/// assert_eq!((reference.image.height(), reference.image.width()), (4, 6));
/// ```
pub fn reference_image(shape: [usize; 2]) -> Reference {
    mean_of_lines(shape, line_integral)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute::check_line_integrals;

    #[test]
    fn line_integrals_agree_with_many_samples_of_the_rate() {
        check_line_integrals("tube", rate, line_integral, 4.0, 1.7);
    }

    /// The volume of a torus is 2 π² R r², and the mean of its brightness 1.
    #[test]
    fn the_image_holds_the_volume() {
        let image = reference_image([32, 32]).image;
        let glow = 0.2 * (0.5 * PI.sqrt() * libm::erf(1.0)).powi(3);
        let expected = 2.0 * PI * PI * RING * TUBE * TUBE + glow;
        let mean = image.pixels().iter().sum::<f64>() / 1024.0;
        assert!((mean - expected).abs() < 1e-5 * expected, "{mean} instead of {expected}");
    }
}
