//! Eq. (8) of the paper with one spectrum everywhere, E^−1.7.

use super::parts;
use super::spectrum::Spectrum;
use crate::equation8;
use emitree::{Cube, EnergyAxis};

/// From the lowest to the highest energy.
pub const BAND: [f64; 2] = [0.5, 8.0];

const SPECTRUM: Spectrum = Spectrum::PowerLaw { index: 1.7 };

/// The emission rate at a point of the unit cube, per unit of energy.
///
/// ```
/// use emitree_problems::{cubes::separable, equation8};
///
/// let position = [0.4, 0.5, 0.6];
/// assert_eq!(separable::rate(position, 1.0), equation8::rate(position, equation8::ALPHA));
/// ```
pub fn rate(position: [f64; 3], energy: f64) -> f64 {
    equation8::rate(position, equation8::ALPHA) * SPECTRUM.at(energy)
}

/// The exact cube of `shape` = \[height, width\] pixels and the bins of `axis`.
pub fn exact(shape: [usize; 2], axis: &EnergyAxis) -> Cube {
    let image = equation8::exact_image(equation8::ALPHA, shape);
    parts::cube_of(&[(image, SPECTRUM)], shape, axis)
}
