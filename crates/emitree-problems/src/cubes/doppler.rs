//! A rotating disc whose emission line is shifted by the velocity along the line of sight.
//!
//! g = density(r) · (exp(−(E − E₀ − s(r))²/w²) + a weak continuum). The disc is a tilted ring of gas,
//! and the shift is s = S · 2 a u/(ρ² + a²), u the coordinate along the line of nodes and ρ the
//! distance from the axis: a rotation curve that is rigid inside of a and falls outside. Energies are
//! in keV.

use super::local::{self, LocalSpectrum, Rule};
use super::ring::Ring;
use super::spectrum::Spectrum;
use crate::means;
use emitree::{Cube, EnergyAxis};

/// From the lowest to the highest energy.
pub const BAND: [f64; 2] = [5.0, 8.0];

/// A bound on the largest error of a voxel, relative to the largest voxel, for axes within [`BAND`].
pub const CUBE_ERROR: f64 = 1e-7;

/// The energy of the line at rest.
const LINE_ENERGY: f64 = 6.4;
/// How far from its middle the line has fallen to 1/e: 1.5 % of the band.
const LINE_WIDTH: f64 = 0.045;
/// The largest shift S, 10 % of the band.
const LARGEST_SHIFT: f64 = 0.3;
/// The distance a from the axis at which it is reached.
const TURNOVER_RADIUS: f64 = 0.2;
/// The continuum over the line is about this.
const CONTINUUM: f64 = 0.05;
const CONTINUUM_SPECTRUM: Spectrum = Spectrum::Exponential { scale: 6.0 };

const RING: Ring = Ring {
    centre: [0.51, 0.48, 0.52],
    nodes: [0.96, 0.28],
    tilt: [0.6, 0.8],
    radius: 0.24,
    sharpness: 3,
    thickness: 0.08,
};

/// Panels in x, y and z: more across lines of equal shift, which are the narrowest structure.
const PANELS: [usize; 3] = [12, 12, 6];
const NODES: usize = 15;
const TERMS: usize = 60;

struct Doppler;

/// The parameter is the shift of the line.
impl LocalSpectrum for Doppler {
    const PARAMETER: [f64; 2] = [-LARGEST_SHIFT, LARGEST_SHIFT];

    fn place(&self, position: [f64; 3]) -> [f64; 2] {
        let place = RING.place(position);
        let turnover = 2.0 * TURNOVER_RADIUS * place.along_nodes
            / (place.axis_distance_squared + TURNOVER_RADIUS.powi(2));
        [place.density, LARGEST_SHIFT * turnover]
    }

    fn spectrum(&self, shift: f64, energy: f64) -> f64 {
        let line = (-((energy - LINE_ENERGY - shift) / LINE_WIDTH).powi(2)).exp();
        line + CONTINUUM * CONTINUUM_SPECTRUM.at(energy)
    }

    fn spectrum_mean(&self, shift: f64, from: f64, to: f64) -> f64 {
        let line = means::gaussian(LINE_WIDTH.powi(-2), LINE_ENERGY + shift, from, to);
        line + CONTINUUM * CONTINUUM_SPECTRUM.mean(from, to)
    }
}

/// The emission rate at a point of the unit cube, per unit of energy.
///
/// ```
/// use emitree_problems::cubes::doppler;
///
/// // The end of the line of nodes moves towards the observer: there the line is at higher energies.
/// let at = |energy| doppler::rate([0.51 + 0.96 * 0.24, 0.48 + 0.28 * 0.24, 0.52], energy);
/// assert!(at(6.7) > 0.9 && at(6.4) < 0.1);
/// ```
pub fn rate(position: [f64; 3], energy: f64) -> f64 {
    Doppler.rate(position, energy)
}

/// The cube of `shape` = \[height, width\] pixels and the bins of `axis`, to [`CUBE_ERROR`].
pub fn exact(shape: [usize; 2], axis: &EnergyAxis) -> Cube {
    local::cube(&Doppler, &rule(), shape, axis)
}

fn rule() -> Rule {
    let borders = PANELS.map(local::equal_panels);
    Rule { borders, nodes: NODES, terms: TERMS }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cubes::checks;

    #[test]
    fn the_parameter_keeps_to_its_bounds() {
        checks::parameter_is_bounded(&Doppler);
    }

    #[test]
    fn a_finer_rule_gives_the_same_cube() {
        checks::rule_is_fine_enough(&Doppler, &rule(), BAND, CUBE_ERROR);
    }
}
