//! A power of the distance from a centre.

use super::radial::{AMPLITUDE, CENTRE_X, CENTRE_Y, CENTRE_Z, centre, distance};
use super::{fill_radial_rates, one, scale};
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "power_law",
    title: "Spherical power law",
    summary: "A power of the distance from a centre, and nothing close to it.",
    source: "none: a wind or an outflow of constant speed has the exponent 2",
    length_unit: "1",
    image_unit: "",
    energy_unit: None,
    parameters: &[
        AMPLITUDE,
        ParameterDescription {
            name: "exponent",
            unit: "1",
            default: ParameterDefault::Value(2.0),
            meaning: "n of r^-n",
            range: AcceptedRange::Between(0.0, 100.0),
        },
        ParameterDescription {
            name: "inner_radius",
            unit: "1",
            default: ParameterDefault::Value(1.0),
            meaning: "distance below which there is no emission, in the length unit of the scene",
            range: AcceptedRange::Positive,
        },
        CENTRE_X,
        CENTRE_Y,
        CENTRE_Z,
    ],
    jumps_move_with: &["inner_radius", CENTRE_X.name, CENTRE_Y.name, CENTRE_Z.name],
    edges: |values| spheres(centre(values), [values.of("inner_radius")]),
    singular_points: nowhere,
    build: formula!(|values| PowerLaw::from_values(values)?),
};

/// g = amplitude · r⁻ⁿ, with r the distance from a centre; 0 for r less than an inner radius.
///
/// Without an inner radius the line of sight at a distance b has
/// amplitude · √π Γ((n − 1)/2)/Γ(n/2) · b^(1 − n) for n > 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw<T = f64> {
    amplitude: T,
    exponent: T,
    inner_radius: T,
    centre: [T; 3],
}

impl PowerLaw {
    /// The law with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range, or an inner radius so
    /// small that the rate there is too large for a number.
    ///
    /// ```
    /// use emitree_models::models::PowerLaw;
    /// use std::collections::BTreeMap;
    ///
    /// let law = PowerLaw::new(&BTreeMap::from([("exponent".to_owned(), 3.0)]))?;
    /// assert!((law.rate([0.0, 2.0, 0.0]) - 0.125).abs() < 1e-16);
    /// assert_eq!(law.rate([0.0, 0.9, 0.0]), 0.0); // within the inner radius
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Self::from_values(&DESCRIPTION.values(parameters)?)
    }

    /// The rate g at a position; 0 within the inner radius.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let distance = distance(position, self.centre);
        if distance < self.inner_radius { 0.0 } else { one(distance, |r| self.at(r)) }
    }
}

impl<T: Scalar> PowerLaw<T> {
    fn from_values(values: &Values<T>) -> Result<Self, ModelError> {
        let law = Self {
            amplitude: values.of(AMPLITUDE.name),
            exponent: values.of("exponent"),
            inner_radius: values.of("inner_radius"),
            centre: centre(values),
        };
        if !one(law.inner_radius, |r| law.at(r)).value().is_finite() {
            let expected = "enough for a finite amplitude inner_radius^-exponent".to_owned();
            return Err(DESCRIPTION.out_of_range(
                "inner_radius",
                law.inner_radius.value(),
                expected,
            ));
        }
        Ok(law)
    }

    /// Turns distances into rates.
    fn at(&self, distances: &mut [T]) {
        T::raise_all(distances, -self.exponent);
        scale(distances, self.amplitude);
    }
}

impl<T: Scalar> Formula<T> for PowerLaw<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        let range = [self.inner_radius, T::of(f64::INFINITY)];
        fill_radial_rates(samples, rates, self.centre, range, |distances| self.at(distances));
    }
}

emission_of_formula!(PowerLaw);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unbounded_rate_is_refused() {
        let given = [("exponent".to_owned(), 4.0), ("inner_radius".to_owned(), 1e-80)];
        assert_eq!(
            PowerLaw::new(&BTreeMap::from(given)).unwrap_err().to_string(),
            "parameter `inner_radius` of model `power_law` is 1e-80: expected enough for a finite \
             amplitude inner_radius^-exponent"
        );
    }

    #[test]
    fn counts_from_its_centre() {
        let given = [("centre_x".to_owned(), 1.0), ("centre_z".to_owned(), -2.0)];
        let law = PowerLaw::new(&BTreeMap::from(given)).unwrap();
        assert!((law.rate([1.0, 3.0, 2.0]) - 0.04).abs() < 1e-16);
    }
}
