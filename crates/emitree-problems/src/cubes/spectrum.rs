//! Spectra in closed form: at an energy, and averaged over a bin.

use crate::means;

/// A spectrum with closed bin means. Energies are positive, in the unit of the problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spectrum {
    /// E^−`index`.
    PowerLaw {
        /// The power of 1/E.
        index: f64,
    },
    /// exp(−E/`scale`).
    Exponential {
        /// The energy at which it has fallen to 1/e.
        scale: f64,
    },
    /// exp(−(E − `energy`)²/`width`²).
    Line {
        /// The energy of the line.
        energy: f64,
        /// How far from it the line has fallen to 1/e.
        width: f64,
    },
    /// E^−`index` below `energy`, and `drop` times that from there on: an absorption edge.
    Edge {
        /// The power of 1/E.
        index: f64,
        /// The energy of the edge.
        energy: f64,
        /// What is left above the edge, as a fraction.
        drop: f64,
    },
}

impl Spectrum {
    /// The spectrum at an energy.
    ///
    /// ```
    /// use emitree_problems::cubes::spectrum::Spectrum;
    ///
    /// let edge = Spectrum::Edge { index: 1.0, energy: 2.0, drop: 0.25 };
    /// assert_eq!([edge.at(1.0), edge.at(2.0)], [1.0, 0.125]);
    /// ```
    pub fn at(&self, energy: f64) -> f64 {
        match *self {
            Self::PowerLaw { index } => energy.powf(-index),
            Self::Exponential { scale } => (-energy / scale).exp(),
            Self::Line { energy: line, width } => (-((energy - line) / width).powi(2)).exp(),
            Self::Edge { index, energy: edge, drop } => {
                energy.powf(-index) * if energy < edge { 1.0 } else { drop }
            }
        }
    }

    /// The mean over the energies \[`from`, `to`\], 0 < from < to.
    ///
    /// ```
    /// use emitree_problems::cubes::spectrum::Spectrum;
    ///
    /// let mean = Spectrum::PowerLaw { index: 2.0 }.mean(1.0, 4.0);
    /// assert!((mean - 0.25).abs() < 1e-15); // (1 − 1/4) / 3
    /// ```
    pub fn mean(&self, from: f64, to: f64) -> f64 {
        match *self {
            Self::PowerLaw { index } => power_integral(index, from, to) / (to - from),
            Self::Exponential { scale } => exponential_mean(1.0 / scale, from, to),
            Self::Line { energy, width } => means::gaussian(width.powi(-2), energy, from, to),
            Self::Edge { index, energy, drop } => {
                let edge = energy.clamp(from, to);
                let below = power_integral(index, from, edge);
                let above = power_integral(index, edge, to);
                (below + drop * above) / (to - from)
            }
        }
    }
}

/// ∫ E^−`index` dE; without cancellation in narrow bins, and through the logarithm at index 1.
fn power_integral(index: f64, from: f64, to: f64) -> f64 {
    let (power, log) = (1.0 - index, (to / from).ln());
    let growth = power * log;
    from.powf(power) * log * if growth == 0.0 { 1.0 } else { growth.exp_m1() / growth }
}

/// The mean of exp(−`rate` E) over \[`from`, `to`\], from < to; rate ≠ 0.
pub(super) fn exponential_mean(rate: f64, from: f64, to: f64) -> f64 {
    let width = to - from;
    -(-rate * from).exp() * (-rate * width).exp_m1() / (rate * width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauss::Gauss;

    /// Against quadrature, in wide and in narrow bins; the edge at 2 lies between two of the panels.
    #[test]
    fn bin_means_agree_with_quadrature() {
        let spectra = [
            Spectrum::PowerLaw { index: 1.7 },
            Spectrum::PowerLaw { index: 1.0 },
            Spectrum::PowerLaw { index: -2.0 },
            Spectrum::Exponential { scale: 0.8 },
            Spectrum::Line { energy: 2.1, width: 0.2 },
            Spectrum::Edge { index: 1.4, energy: 2.0, drop: 0.3 },
        ];
        let rule = Gauss::new(16);
        for spectrum in spectra {
            for [from, to] in [[0.5, 3.5], [1.9, 2.1], [2.2, 2.200_1], [0.5, 0.51]] {
                let integral = rule.integrate_panels([from, to], 20, |energy| spectrum.at(energy));
                let (mean, expected) = (spectrum.mean(from, to), integral / (to - from));
                let far = (mean - expected).abs() / expected;
                assert!(far < 1e-11, "{spectrum:?} {from} to {to}: {far:e}");
            }
        }
    }
}
