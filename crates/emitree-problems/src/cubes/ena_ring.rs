//! Energetic neutral atoms from a ring current: ions that catch an electron from the hydrogen around
//! a planet and leave in a straight line.
//!
//! g = n(r) N(r) σ(E) E (kT)^(−3/2) exp(−E/kT), with the densities n of the ions and N of the
//! hydrogen: the flux of a Maxwell distribution times the cross section of charge exchange,
//! σ = (4.15 − 0.531 ln E)² (1 − exp(−67.3/E))^4.5 in 10⁻²⁰ m², E in keV (Lindsay and Stebbings
//! 2005, doi:10.1029/2005JA011298). The ions are a tilted ring, brighter on one side, and hotter
//! towards its axis; N falls with the third power of the distance.

use super::local::{self, LocalSpectrum, Rule};
use super::ring::Ring;
use crate::gauss::Gauss;
use emitree::{Cube, EnergyAxis};

/// From the lowest to the highest energy, in keV.
pub const BAND: [f64; 2] = [1.0, 100.0];

/// A bound on the largest error of a voxel, relative to the largest voxel, for axes within [`BAND`].
pub const CUBE_ERROR: f64 = 1e-8;

const RING: Ring = Ring {
    centre: [0.49, 0.52, 0.48],
    nodes: [0.8, 0.6],
    tilt: [0.5, 0.866_025_403_784_438_6],
    radius: 0.26,
    sharpness: 4,
    thickness: 0.1,
};
/// The ions are e^`ASYMMETRY` times as many on one end of the line of nodes as in the middle.
const ASYMMETRY: f64 = 0.7;
/// r at which N bends over, the radius of the planet.
const HYDROGEN_RADIUS: f64 = 0.15;
/// kT far from the axis, and how much more it is on the axis.
const TEMPERATURE_KEV: [f64; 2] = [3.0, 12.0];
/// The distance from the axis at which half of the latter is left.
const TEMPERATURE_RADIUS: f64 = 0.3;

const PANELS: usize = 8;
const NODES: usize = 12;
const TERMS: usize = 32;
/// The cross section and the spectra are smooth on ln E: panels of at most this width, of 10 nodes.
const LOG_PANEL: f64 = 0.35;

struct EnaRing {
    gauss: Gauss,
}

impl EnaRing {
    fn new() -> Self {
        Self { gauss: Gauss::new(10) }
    }
}

/// The parameter is 1/kT.
impl LocalSpectrum for EnaRing {
    const PARAMETER: [f64; 2] = [1.0 / 15.0, 1.0 / 3.0];

    fn place(&self, position: [f64; 3]) -> [f64; 2] {
        place(position)
    }

    fn spectrum(&self, per_temperature: f64, energy: f64) -> f64 {
        spectrum(per_temperature, energy)
    }

    fn spectrum_mean(&self, per_temperature: f64, from: f64, to: f64) -> f64 {
        let logs = [from.ln(), to.ln()];
        let panels = panels_on(logs[1] - logs[0]);
        let integral = self.gauss.integrate_panels(logs, panels, |log| {
            let energy = log.exp();
            energy * spectrum(per_temperature, energy)
        });
        integral / (to - from)
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number; a cast of anything else saturates"
)]
fn panels_on(log_width: f64) -> usize {
    ((log_width / LOG_PANEL).ceil() as usize).max(1)
}

fn place(position: [f64; 3]) -> [f64; 2] {
    let place = RING.place(position);
    let ions = place.density * (ASYMMETRY * place.along_nodes / RING.radius).exp();
    let hydrogen = (1.0 + place.centre_distance_squared / HYDROGEN_RADIUS.powi(2)).powf(-1.5);
    let [far, hotter] = TEMPERATURE_KEV;
    let temperature =
        far + hotter / (1.0 + place.axis_distance_squared / TEMPERATURE_RADIUS.powi(2));
    [ions * hydrogen * temperature.powf(-1.5), temperature.recip()]
}

fn spectrum(per_temperature: f64, energy_kev: f64) -> f64 {
    cross_section(energy_kev) * energy_kev * (-energy_kev * per_temperature).exp()
}

/// σ of charge exchange between a proton of `energy_kev` and a hydrogen atom, in 10⁻²⁰ m²: Lindsay
/// and Stebbings 2005, doi:10.1029/2005JA011298.
///
/// ```
/// use emitree_problems::cubes::ena_ring::cross_section;
///
/// assert!((cross_section(1.0) - 17.2225).abs() < 1e-12); // 4.15²
/// assert!(cross_section(100.0) < 0.3);
/// ```
pub fn cross_section(energy_kev: f64) -> f64 {
    let slow = (4.15 - 0.531 * energy_kev.ln()).powi(2);
    slow * (-(-67.3 / energy_kev).exp_m1()).powf(4.5)
}

/// The emission rate at a point of the unit cube, per keV.
///
/// ```
/// use emitree_problems::cubes::ena_ring;
///
/// let on_ring = ena_ring::rate([0.49 + 0.8 * 0.26, 0.52 + 0.6 * 0.26, 0.48], 10.0);
/// let in_the_middle = ena_ring::rate([0.49, 0.52, 0.48], 10.0);
/// assert!(on_ring > 0.1 && in_the_middle < 1e-9);
/// ```
pub fn rate(position: [f64; 3], energy: f64) -> f64 {
    let [density, parameter] = place(position);
    density * spectrum(parameter, energy)
}

/// The cube of `shape` = \[height, width\] pixels and the bins of `axis`, to [`CUBE_ERROR`].
pub fn exact(shape: [usize; 2], axis: &EnergyAxis) -> Cube {
    local::cube(&EnaRing::new(), &rule(), shape, axis)
}

fn rule() -> Rule {
    let borders = [PANELS; 3].map(local::equal_panels);
    Rule { borders, nodes: NODES, terms: TERMS }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cubes::checks;

    #[test]
    fn the_parameter_keeps_to_its_bounds() {
        checks::parameter_is_bounded(&EnaRing::new());
    }

    #[test]
    fn a_finer_rule_gives_the_same_cube() {
        checks::rule_is_fine_enough(&EnaRing::new(), &rule(), BAND, CUBE_ERROR);
    }

    /// Numbers of `tests/reference/charge_exchange.py`, in 30 digits.
    #[test]
    fn the_cross_section_is_that_of_the_source() {
        let expected = [
            (1.0, 17.222_5),
            (10.0, 8.523_278_302_539_495),
            (50.0, 1.106_329_486_075_126_5),
            (100.0, 0.117_072_277_065_360_25),
        ];
        for (energy, expected) in expected {
            assert!((cross_section(energy) / expected - 1.0).abs() < 1e-12, "{energy} keV");
        }
    }
}
