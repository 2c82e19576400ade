//! A continuum of two components, and an emission line from another place.

use super::parts::Part;
use super::spectrum::Spectrum;

/// From the lowest to the highest energy.
pub const BAND: [f64; 2] = [1.0, 9.0];

/// The energy of the line, on no border of 2ⁿ equal bins.
pub const LINE_ENERGY: f64 = 6.4;

/// An exponential and a power-law continuum, and a line whose 1/e half width is `line_width`, each
/// from a Gaussian of its own.
///
/// ```
/// use emitree_problems::cubes::{mixture, parts};
///
/// let parts = mixture::parts(0.016);
/// let line = parts[2];
/// let ratio = |energy| parts::rate(&parts, line.centre, energy);
/// assert!(ratio(mixture::LINE_ENERGY) > 10.0 * ratio(6.3));
/// ```
pub fn parts(line_width: f64) -> [Part; 3] {
    [
        Part {
            amplitude: 1.0,
            centre: [0.37, 0.42, 0.55],
            widths: [0.22, 0.13, 0.3],
            spectrum: Spectrum::Exponential { scale: 2.2 },
        },
        Part {
            amplitude: 0.8,
            centre: [0.66, 0.57, 0.38],
            widths: [0.09, 0.16, 0.12],
            spectrum: Spectrum::PowerLaw { index: 1.3 },
        },
        Part {
            amplitude: 1.5,
            centre: [0.31, 0.74, 0.61],
            widths: [0.11, 0.08, 0.14],
            spectrum: Spectrum::Line { energy: LINE_ENERGY, width: line_width },
        },
    ]
}
