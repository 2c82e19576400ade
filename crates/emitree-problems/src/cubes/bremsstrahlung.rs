//! Thermal bremsstrahlung of a cluster of galaxies with a temperature gradient.
//!
//! g = n² (kT)^(−1/2) exp(−E/kT), with n² = (1 + r²/a²)^(−3β), β = 2/3 (Cavaliere and Fusco-Femiano
//! 1976, A&A 49, 137), and the Gaunt factor 1 (Rybicki and Lightman 1979, eq. 5.14). kT falls
//! outwards and grows along x and y and towards the observer. Energies and kT are in keV.

use super::local::{self, LocalSpectrum, Rule};
use super::spectrum::exponential_mean;
use emitree::{Cube, EnergyAxis};

/// From the lowest to the highest energy.
pub const BAND: [f64; 2] = [0.5, 8.0];

/// A bound on the largest error of a voxel, relative to the largest voxel, for axes within [`BAND`].
pub const CUBE_ERROR: f64 = 1e-9;

const CENTRE: [f64; 3] = [0.47, 0.53, 0.51];
const CORE_RADIUS: f64 = 0.12;
const TEMPERATURE_KEV: f64 = 4.0;
/// r at which kT has fallen to 1/√2 of that of the centre.
const COOLING_RADIUS: f64 = 0.6;
/// The relative change of kT for each unit of length, about the centre.
const GRADIENT: [f64; 3] = [0.3, 0.2, -0.25];

/// Borders of panels about each [`CENTRE`], wider outwards, where n² is smoother.
const OFFSETS: [f64; 7] = [-0.3, -0.15, -0.06, 0.0, 0.06, 0.15, 0.3];
const NODES: usize = 12;
const TERMS: usize = 16;

struct Bremsstrahlung;

/// The parameter is 1/kT.
impl LocalSpectrum for Bremsstrahlung {
    const PARAMETER: [f64; 2] = [0.2, 0.7];

    fn place(&self, position: [f64; 3]) -> [f64; 2] {
        let [x, y, z] = core::array::from_fn(|i| position[i] - CENTRE[i]);
        let square = x * x + y * y + z * z;
        let falling = TEMPERATURE_KEV / (1.0 + square / COOLING_RADIUS.powi(2)).sqrt();
        let temperature = falling * (1.0 + GRADIENT[0] * x + GRADIENT[1] * y + GRADIENT[2] * z);
        let density_squared = (1.0 + square / CORE_RADIUS.powi(2)).powi(-2);
        [density_squared / temperature.sqrt(), temperature.recip()]
    }

    fn spectrum(&self, per_temperature: f64, energy: f64) -> f64 {
        (-energy * per_temperature).exp()
    }

    fn spectrum_mean(&self, per_temperature: f64, from: f64, to: f64) -> f64 {
        exponential_mean(per_temperature, from, to)
    }
}

/// The emission rate at a point of the unit cube, per unit of energy.
///
/// ```
/// use emitree_problems::cubes::bremsstrahlung;
///
/// let rate = bremsstrahlung::rate([0.47, 0.53, 0.51], 4.0);
/// assert!((rate - (-1_f64).exp() / 2.0).abs() < 1e-15);
/// ```
pub fn rate(position: [f64; 3], energy: f64) -> f64 {
    Bremsstrahlung.rate(position, energy)
}

/// The cube of `shape` = \[height, width\] pixels and the bins of `axis`, to [`CUBE_ERROR`].
pub fn exact(shape: [usize; 2], axis: &EnergyAxis) -> Cube {
    local::cube(&Bremsstrahlung, &rule(), shape, axis)
}

fn rule() -> Rule {
    let borders = CENTRE.map(|centre| {
        let inner = OFFSETS.iter().map(|offset| centre + offset);
        [0.0].into_iter().chain(inner).chain([1.0]).collect()
    });
    Rule { borders, nodes: NODES, terms: TERMS }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cubes::checks;

    #[test]
    fn the_parameter_keeps_to_its_bounds() {
        checks::parameter_is_bounded(&Bremsstrahlung);
    }

    #[test]
    fn a_finer_rule_gives_the_same_cube() {
        checks::rule_is_fine_enough(&Bremsstrahlung, &rule(), BAND, CUBE_ERROR);
    }
}
