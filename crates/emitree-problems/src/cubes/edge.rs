//! Two Gaussians whose spectra jump down at the same energy: an absorption edge.

use super::parts::Part;
use super::spectrum::Spectrum;

/// From the lowest to the highest energy.
pub const BAND: [f64; 2] = [0.5, 8.0];

/// The energy of the edge, on no border of 2ⁿ bins of equal width or ratio.
pub const EDGE_ENERGY: f64 = 2.3;

/// What is left above the edge, as a fraction.
pub const DROP: f64 = 0.3;

/// A hard and a soft source behind the same absorber.
///
/// ```
/// use emitree_problems::cubes::{edge, parts};
///
/// let rate = |energy| parts::rate(&edge::parts(), [0.5; 3], energy);
/// let drop = rate(edge::EDGE_ENERGY) / rate(edge::EDGE_ENERGY - 1e-9);
/// assert!((drop - edge::DROP).abs() < 1e-8);
/// ```
pub fn parts() -> [Part; 2] {
    let spectrum = |index| Spectrum::Edge { index, energy: EDGE_ENERGY, drop: DROP };
    [
        Part {
            amplitude: 1.0,
            centre: [0.4, 0.55, 0.47],
            widths: [0.2, 0.12, 0.16],
            spectrum: spectrum(0.8),
        },
        Part {
            amplitude: 0.6,
            centre: [0.63, 0.36, 0.58],
            widths: [0.1, 0.17, 0.13],
            spectrum: spectrum(2.0),
        },
    ]
}
