//! The beta model of the gas in a cluster of galaxies.

use super::radial::{AMPLITUDE, CENTRE_X, CENTRE_Y, CENTRE_Z, centre, distance};
use super::{fill_radial_rates, one, scale};
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "beta_model",
    title: "Hot gas of a cluster of galaxies, the beta model",
    summary: "X-ray emission of a spherical cluster: the square of the density of an isothermal \
              gas, flat in the core and a power of the distance outside.",
    source: "A. Cavaliere and R. Fusco-Femiano 1976, Astron. Astrophys. 49, 137",
    length_unit: "1",
    image_unit: "",
    energy_unit: None,
    parameters: &[
        AMPLITUDE,
        ParameterDescription {
            name: "core_radius",
            unit: "1",
            default: ParameterDefault::Value(1.0),
            meaning: "radius of the core, in the length unit of the scene",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "beta",
            unit: "1",
            default: ParameterDefault::Value(2.0 / 3.0),
            meaning: "how fast the emission falls: as r^(-6 beta) outside the core",
            range: AcceptedRange::Between(0.0, 100.0),
        },
        CENTRE_X,
        CENTRE_Y,
        CENTRE_Z,
    ],
    jumps_move_with: &[],
    edges: nowhere,
    singular_points: nowhere,
    build: formula!(|values| BetaModel::from_values(values)),
};

/// g = amplitude · (1 + r²/rc²)^(−3β), with r the distance from a centre: the emission of the gas
/// of Cavaliere and Fusco-Femiano 1976, whose density goes as (1 + r²/rc²)^(−3β/2).
///
/// For β > 1/6 the line of sight at a distance b has, from end to end,
/// amplitude · √π Γ(3β − ½)/Γ(3β) · rc (1 + b²/rc²)^(½ − 3β).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BetaModel<T = f64> {
    amplitude: T,
    core_radius: T,
    beta: T,
    centre: [T; 3],
}

impl BetaModel {
    /// The cluster with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range.
    ///
    /// ```
    /// use emitree_models::models::BetaModel;
    /// use std::collections::BTreeMap;
    ///
    /// let cluster = BetaModel::new(&BTreeMap::from([("core_radius".to_owned(), 2.0)]))?;
    /// assert_eq!(cluster.rate([0.0; 3]), 1.0);
    /// assert!((cluster.rate([2.0, 0.0, 0.0]) - 0.25).abs() < 1e-15); // 2^(-3 beta) at the core
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    /// The rate g at a position.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        one(distance(position, self.centre), |distances| self.at(distances))
    }
}

impl<T: Scalar> BetaModel<T> {
    fn from_values(values: &Values<T>) -> Self {
        Self {
            amplitude: values.of(AMPLITUDE.name),
            core_radius: values.of("core_radius"),
            beta: values.of("beta"),
            centre: centre(values),
        }
    }

    /// Turns distances into rates.
    fn at(&self, distances: &mut [T]) {
        for distance in &mut *distances {
            let in_cores = *distance / self.core_radius;
            *distance = T::of(1.0) + in_cores * in_cores;
        }
        T::raise_all(distances, self.beta * -3.0);
        scale(distances, self.amplitude);
    }
}

impl<T: Scalar> Formula<T> for BetaModel<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        let range = [0.0, f64::INFINITY].map(T::of);
        fill_radial_rates(samples, rates, self.centre, range, |distances| self.at(distances));
    }
}

emission_of_formula!(BetaModel);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projects_to_the_published_profile() {
        // With 3 beta = 2: sqrt(pi) Γ(3/2)/Γ(2) rc (1 + b²/rc²)^(−3/2) = π/2 rc (…)^(−3/2).
        let given = [("core_radius".to_owned(), 0.5), ("centre_y".to_owned(), 2.0)];
        let cluster = BetaModel::new(&BTreeMap::from(given)).unwrap();
        // The midpoint rule in the angle about the line, z = tan(angle), exact for this integrand
        // but for roundings.
        let steps = 400_u32;
        let step = core::f64::consts::PI / f64::from(steps);
        let column: f64 = (0..steps)
            .map(|index| {
                let angle = (f64::from(index) + 0.5) * step - core::f64::consts::FRAC_PI_2;
                cluster.rate([0.0, 2.3, angle.tan()]) * step / angle.cos().powi(2)
            })
            .sum();
        let expected = core::f64::consts::FRAC_PI_2 * 0.5 * (1.0_f64 + 0.36).powf(-1.5);
        assert!((column / expected - 1.0).abs() < 1e-12, "{column}, {expected}");
    }

    #[test]
    fn a_point_like_core_is_dark_outside() {
        let cluster =
            BetaModel::new(&BTreeMap::from([("core_radius".to_owned(), 1e-300)])).unwrap();
        assert!(cluster.rate([1.0, 0.0, 0.0]) <= 0.0 && cluster.rate([0.0; 3]) > 0.0);
    }
}
