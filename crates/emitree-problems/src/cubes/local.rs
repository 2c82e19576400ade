//! Emissions whose spectrum depends on the place through one number, as a temperature or a velocity:
//! g = density(r) · spectrum(E; p(r)).
//!
//! The bin means of the spectrum are smooth functions of p, so they are short series of Chebyshev
//! polynomials Tₖ. A voxel is then Σₖ cₖ(bin) · Mₖ(pixel) with the moments
//! Mₖ = mean of ∫ density · Tₖ(p) dz, which don't depend on the energies at all and come from
//! Gauss–Legendre quadrature as images do.

use crate::gauss::Gauss;
use crate::panels::{self, PanelAxis};
use core::f64::consts::PI;
use emitree::{Cube, EnergyAxis, Image};
use rayon::prelude::*;

/// A density that changes no voxel by more than rounding, where the largest are of order 1.
const NEGLIGIBLE: f64 = 1e-18;

/// Such an emission.
pub(super) trait LocalSpectrum: Sync {
    /// Bounds of the parameter in the unit cube.
    const PARAMETER: [f64; 2];

    /// The density and the parameter at a point.
    fn place(&self, position: [f64; 3]) -> [f64; 2];

    /// The spectrum at an energy.
    fn spectrum(&self, parameter: f64, energy: f64) -> f64;

    /// The mean of the spectrum over the energies \[`from`, `to`\].
    fn spectrum_mean(&self, parameter: f64, from: f64, to: f64) -> f64;

    /// g at a point and an energy.
    fn rate(&self, position: [f64; 3], energy: f64) -> f64 {
        let [density, parameter] = self.place(position);
        density * self.spectrum(parameter, energy)
    }
}

/// How finely a cube is integrated.
#[derive(Clone, Debug)]
pub(super) struct Rule {
    /// Borders of panels in x, y and z.
    pub(super) borders: [Vec<f64>; 3],
    /// Gauss–Legendre nodes of a panel.
    pub(super) nodes: usize,
    /// Terms of the series in the parameter.
    pub(super) terms: usize,
}

/// The borders of `panels` panels of equal width.
pub(super) fn equal_panels(panels: usize) -> Vec<f64> {
    (0..=panels).map(|border| border as f64 / panels as f64).collect()
}

/// The cube of `shape` = \[height, width\] pixels and the bins of `axis`.
pub(super) fn cube<L: LocalSpectrum>(
    emission: &L,
    rule: &Rule,
    shape: [usize; 2],
    axis: &EnergyAxis,
) -> Cube {
    let moments = moments(emission, rule, shape);
    let edges = axis.edges();
    let bands = edges.par_windows(2).map(|edges| {
        let mut band = Image::zeros(shape[0], shape[1]);
        let terms = series(rule.terms, L::PARAMETER, |parameter| {
            emission.spectrum_mean(parameter, edges[0], edges[1])
        });
        for (term, moment) in terms.iter().zip(&moments) {
            for (voxel, pixel) in band.pixels_mut().iter_mut().zip(moment.pixels()) {
                *voxel += term * pixel;
            }
        }
        band
    });
    Cube::from_bands(bands.collect())
}

/// The moments Mₖ, an image each.
fn moments<L: LocalSpectrum>(emission: &L, rule: &Rule, [height, width]: [usize; 2]) -> Vec<Image> {
    let gauss = Gauss::new(rule.nodes);
    let across = |i: usize, pixels| PanelAxis::new(&rule.borders[i], rule.nodes, pixels);
    let [low, high] = L::PARAMETER;
    panels::images(&across(0, width), &across(1, height), rule.terms, |x, y, moments| {
        for ends in rule.borders[2].windows(2) {
            gauss.weigh(ends[0], ends[1], |z, weight| {
                let [density, parameter] = emission.place([x, y, z]);
                if density < NEGLIGIBLE {
                    return;
                }
                let t = (2.0 * parameter - low - high) / (high - low);
                add_polynomials(weight * density, t, moments);
            });
        }
    })
}

/// Adds `factor` · Tₖ(t) to each sum, by Tₖ₊₁ = 2 t Tₖ − Tₖ₋₁ (DLMF 18.9.1).
fn add_polynomials(factor: f64, t: f64, sums: &mut [f64]) {
    let (mut before, mut now) = (factor * t, factor);
    for sum in sums {
        *sum += now;
        (before, now) = (now, 2.0 * t * now - before);
    }
}

/// The first `terms` Chebyshev coefficients of the polynomial through f at the Chebyshev nodes of
/// \[`low`, `high`\].
fn series(terms: usize, [low, high]: [f64; 2], f: impl Fn(f64) -> f64) -> Vec<f64> {
    let count = terms as f64;
    let angle = |node: usize| PI * (node as f64 + 0.5) / count;
    let at = |node| 0.5 * (low + high) + 0.5 * (high - low) * f64::cos(angle(node));
    let values: Vec<f64> = (0..terms).map(|node| f(at(node))).collect();
    let coefficient = |k: usize| {
        let products = values.iter().enumerate().map(|(i, v)| v * (k as f64 * angle(i)).cos());
        products.sum::<f64>() / count * if k == 0 { 1.0 } else { 2.0 }
    };
    (0..terms).map(coefficient).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_is_the_function() {
        let terms = series(24, [1.0, 4.0], f64::ln);
        for t in [-0.99, -0.3, 0.0, 0.77] {
            let mut sums = vec![0.0; 24];
            add_polynomials(1.0, t, &mut sums);
            let value: f64 = terms.iter().zip(&sums).map(|(term, sum)| term * sum).sum();
            assert!((value - (2.5 + 1.5 * t).ln()).abs() < 1e-12, "{t}");
        }
    }
}
