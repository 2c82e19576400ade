//! A planet's exosphere without satellite particles, after Chamberlain 1963.

use super::constants::{BOLTZMANN_CONSTANT, GRAVITATIONAL_CONSTANT};
use super::fill_rates;
use super::incomplete_gamma::p_three_halves;
use super::radial::radius;
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "chamberlain",
    title: "Exosphere without satellite particles (Chamberlain 1963)",
    summary: "Density of ballistic and escaping particles above an exobase of one temperature; an \
              image is the column density. The defaults are hydrogen about the Earth.",
    source: "J. W. Chamberlain 1963, Planet. Space Sci. 11, 901, doi:10.1016/0032-0633(63)90122-3",
    length_unit: "m",
    image_unit: "m-2",
    energy_unit: None,
    parameters: &[
        ParameterDescription {
            name: "exobase_density",
            unit: "m-3",
            default: ParameterDefault::Value(1e11),
            meaning: "density at the exobase",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "exobase_radius",
            unit: "m",
            default: ParameterDefault::Value(6.871e6),
            meaning: "distance of the exobase from the planet's centre; no density below it",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "temperature",
            unit: "K",
            default: ParameterDefault::Value(1000.0),
            meaning: "temperature at the exobase",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "planet_mass",
            unit: "kg",
            default: ParameterDefault::Value(5.9722e24),
            meaning: "mass of the planet",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "particle_mass",
            unit: "kg",
            default: ParameterDefault::Value(1.673_53e-27),
            meaning: "mass of one atom or molecule",
            range: AcceptedRange::Positive,
        },
    ],
    jumps_move_with: &["exobase_radius"],
    edges: |values| spheres([0.0; 3], [values.of("exobase_radius")]),
    singular_points: nowhere,
    build: formula!(|values| Chamberlain::from_values(values)?),
};

/// The exosphere of Chamberlain 1963 (doi:10.1016/0032-0633(63)90122-3) of particles that come
/// from the exobase, fall back or escape, and never collide; those on closed orbits that do not
/// reach down to the exobase are left out. With λ = G M m/(k T r), λc at the exobase,
/// ψ = λ²/(λ + λc) and the regularised lower gamma function P = P(3/2, ·),
///
/// n = nexo e^(λ − λc) \[1 + P(λ) − √(1 − λ²/λc²) e^−ψ (1 + P(λ − ψ))\]/(1 + P(λc)),
///
/// which is nexo at the exobase itself.
///
/// As an [`Emission`](emitree::Emission) it gives m⁻³: an image over m is the column density \[m⁻²\]. The planet does
/// not occult: a scene with it in view needs an occulter there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chamberlain<T = f64> {
    exobase_radius: T,
    /// λc
    exobase_escape_parameter: T,
    /// nexo/(1 + P(λc))
    scale: T,
}

impl Chamberlain {
    /// The exosphere with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range, or a λc too large for
    /// a number.
    ///
    /// ```
    /// use emitree_models::models::Chamberlain;
    /// use std::collections::BTreeMap;
    ///
    /// let exosphere = Chamberlain::new(&BTreeMap::new())?;
    /// let exobase = exosphere.density_m3([0.0, 0.0, 6.871e6]);
    /// assert!((exobase / 1e11 - 1.0).abs() < 1e-14);
    /// assert_eq!(exosphere.density_m3([0.0, 0.0, 6.8e6]), 0.0);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Self::from_values(&DESCRIPTION.values(parameters)?)
    }

    /// The density \[m⁻³\] at a position \[m\]; 0 below the exobase.
    pub fn density_m3(&self, position: [f64; 3]) -> f64 {
        self.density(position)
    }
}

impl<T: Scalar> Chamberlain<T> {
    fn from_values(values: &Values<T>) -> Result<Self, ModelError> {
        let exobase_radius = values.of("exobase_radius");
        let temperature = values.of("temperature");
        let binding = values.of("planet_mass") * GRAVITATIONAL_CONSTANT / exobase_radius
            * values.of("particle_mass");
        let exobase_escape_parameter = binding / (temperature * BOLTZMANN_CONSTANT);
        if !exobase_escape_parameter.value().is_finite() {
            let expected = "enough for a finite G M m/(k T r) at the exobase".to_owned();
            return Err(DESCRIPTION.out_of_range("temperature", temperature.value(), expected));
        }
        let below = p_three_halves(exobase_escape_parameter);
        let scale = values.of("exobase_density") / (T::of(1.0) + below);
        Ok(Self { exobase_radius, exobase_escape_parameter, scale })
    }

    /// The density \[m⁻³\] at a position \[m\]; 0 below the exobase.
    fn density(&self, position: [f64; 3]) -> T {
        let r = radius(position);
        if r < self.exobase_radius.value() {
            return T::of(0.0);
        }
        let one = T::of(1.0);
        // y = λ/λc, and 1 − y without the cancellation near the exobase.
        let (y, height) = (self.exobase_radius / r, (T::of(r) - self.exobase_radius) / r);
        let lambda_c = self.exobase_escape_parameter;
        let lambda = lambda_c * y;
        let psi = lambda * y / (one + y);
        let root = (height * (one + y)).sqrt();
        // 1 − √(1 − y²) e^−ψ as a sum of two positive terms: far away all of these are small.
        let deficit = y * y / (one + root) - root * (-psi).exp_m1();
        let inner = p_three_halves(lambda / (one + y));
        let bracket = deficit * (one + inner) + (p_three_halves(lambda) - inner);
        self.scale * (-lambda_c * height).exp() * bracket
    }
}

impl<T: Scalar> Formula<T> for Chamberlain<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_rates(samples, rates, |position| self.density(position));
    }
}

emission_of_formula!(Chamberlain);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn falls_as_the_square_of_the_distance_far_away() {
        // n r² → nexo e^−λc (1 + 1/(2 λc)) λc rc²/(1 + P(λc)), to first order in √λ.
        let exosphere = Chamberlain::new(&BTreeMap::new()).unwrap();
        let lambda_c = exosphere.exobase_escape_parameter;
        let limit = exosphere.scale * (-lambda_c).exp() * (lambda_c + 0.5);
        for y in [1e-8, 1e-10, 1e-12] {
            let r = exosphere.exobase_radius / y;
            let ratio = exosphere.density_m3([r, 0.0, 0.0]) / (limit * y * y) - 1.0;
            let first_order = f64::sqrt(lambda_c * y);
            assert!(ratio > 0.0 && ratio < 2.0 * first_order, "{y:e}: {ratio:e}");
        }
    }

    #[test]
    fn absurd_binding_is_refused() {
        let parameters = BTreeMap::from([("temperature".to_owned(), 1e-322)]);
        assert!(
            Chamberlain::new(&parameters)
                .unwrap_err()
                .to_string()
                .starts_with("parameter `temperature` of model `chamberlain` is 1e-322: expected ")
        );
    }
}
