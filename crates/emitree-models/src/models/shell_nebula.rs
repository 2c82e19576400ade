//! A hollow sphere of uniform emission, as of a planetary nebula.

use super::fill_rates;
use super::radial::{AMPLITUDE, CENTRE_X, CENTRE_Y, CENTRE_Z, centre, distance};
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "shell_nebula",
    title: "Uniform shell, as of a planetary nebula",
    summary: "A hollow sphere of uniform emission between two radii: a bright ring with a kink, and \
              sharp edges.",
    source: "none: a test volume, whose image is exact",
    length_unit: "1",
    image_unit: "",
    energy_unit: None,
    parameters: &[
        AMPLITUDE,
        ParameterDescription {
            name: "inner_radius",
            unit: "1",
            default: ParameterDefault::Value(0.8),
            meaning: "radius of the hollow, in the length unit of the scene",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "outer_radius",
            unit: "1",
            default: ParameterDefault::Value(1.0),
            meaning: "radius of the sphere, in the length unit of the scene",
            range: AcceptedRange::Positive,
        },
        CENTRE_X,
        CENTRE_Y,
        CENTRE_Z,
    ],
    jumps_move_with: &["inner_radius", "outer_radius", CENTRE_X.name, CENTRE_Y.name, CENTRE_Z.name],
    edges: |values| spheres(centre(values), [values.of("inner_radius"), values.of("outer_radius")]),
    singular_points: nowhere,
    build: formula!(|values| ShellNebula::from_values(values)?),
};

/// g = amplitude for R1 < r < R2, with r the distance from a centre, and 0 elsewhere.
///
/// The line of sight at a distance b from the centre has
/// 2 amplitude \[√(R2² − b²) − √(R1² − b²)\], each root 0 where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShellNebula<T = f64> {
    amplitude: T,
    inner_radius: T,
    outer_radius: T,
    centre: [T; 3],
}

impl ShellNebula {
    /// The shell with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range, or an outer radius that
    /// is not more than the inner one.
    ///
    /// ```
    /// use emitree_models::models::ShellNebula;
    /// use std::collections::BTreeMap;
    ///
    /// let shell = ShellNebula::new(&BTreeMap::from([("amplitude".to_owned(), 3.0)]))?;
    /// let along_x = [0.5, 0.9, 1.1].map(|x| shell.rate([x, 0.0, 0.0]));
    /// assert_eq!(along_x, [0.0, 3.0, 0.0]);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Self::from_values(&DESCRIPTION.values(parameters)?)
    }

    /// The rate g at a position.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.at(position)
    }
}

impl<T: Scalar> ShellNebula<T> {
    fn from_values(values: &Values<T>) -> Result<Self, ModelError> {
        let [amplitude, inner_radius, outer_radius] =
            [AMPLITUDE.name, "inner_radius", "outer_radius"].map(|name| values.of(name));
        let (inner, outer) = (inner_radius.value(), outer_radius.value());
        if outer <= inner {
            let expected = format!("more than inner_radius = {inner:?}");
            return Err(DESCRIPTION.out_of_range("outer_radius", outer, expected));
        }
        Ok(Self { amplitude, inner_radius, outer_radius, centre: centre(values) })
    }

    /// The rate at a position.
    fn at(&self, position: [f64; 3]) -> T {
        let distance = distance(position, self.centre).value();
        if self.inner_radius.value() < distance && distance < self.outer_radius.value() {
            self.amplitude
        } else {
            T::of(0.0)
        }
    }
}

impl<T: Scalar> Formula<T> for ShellNebula<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_rates(samples, rates, |position| self.at(position));
    }
}

emission_of_formula!(ShellNebula);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_in_the_wrong_order_are_refused() {
        let parameters = BTreeMap::from([("inner_radius".to_owned(), 2.0)]);
        assert_eq!(
            ShellNebula::new(&parameters).unwrap_err().to_string(),
            "parameter `outer_radius` of model `shell_nebula` is 1.0: expected more than \
             inner_radius = 2.0"
        );
    }

    #[test]
    fn counts_from_its_centre() {
        let shell = ShellNebula::new(&BTreeMap::from([("centre_y".to_owned(), 5.0)])).unwrap();
        assert!(shell.rate([0.0, 4.1, 0.0]) > 0.0 && shell.rate([0.0, 0.9, 0.0]) <= 0.0);
    }
}
