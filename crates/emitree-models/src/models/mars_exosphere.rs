//! The hydrogen and oxygen exospheres of Mars, as powers of the distance.

use super::radial::radius;
use super::{fill_blocks, fill_radial_block, one, scale};
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

/// The coefficients of hydrogen, the defaults of `ena` too.
pub(super) const COEFFICIENT: ParameterDescription = ParameterDescription {
    name: "coefficient",
    unit: "m-3",
    default: ParameterDefault::Value(4e27),
    meaning: "a in the density a/(r - b)^c, with r and b in m",
    range: AcceptedRange::NonNegative,
};
pub(super) const OFFSET: ParameterDescription = ParameterDescription {
    name: "offset",
    unit: "m",
    default: ParameterDefault::Value(2.7e6),
    meaning: "b in the density a/(r - b)^c",
    range: AcceptedRange::Finite,
};
pub(super) const EXPONENT: ParameterDescription = ParameterDescription {
    name: "exponent",
    unit: "1",
    default: ParameterDefault::Value(2.7),
    meaning: "c in the density a/(r - b)^c",
    range: AcceptedRange::Between(0.0, 20.0),
};
/// The exobase: 200 km above the radius 3395 km.
pub(super) const EXOBASE_RADIUS: ParameterDescription = ParameterDescription {
    name: "exobase_radius",
    unit: "m",
    default: ParameterDefault::Value(3.395e6 + 2e5),
    meaning: "distance of the exobase from the planet's centre; no density below it",
    range: AcceptedRange::Positive,
};

const SOURCE: &str = "power laws for the exosphere of Mars, as used in simulations of its energetic \
                      neutral atoms; what such profiles rest on: M. Holmström, S. Barabash and \
                      E. Kallio 2002, J. Geophys. Res. 107, 1277, doi:10.1029/2001JA000325";

pub(crate) const HYDROGEN: ModelDescription = ModelDescription {
    name: "mars_hydrogen",
    title: "Hydrogen exosphere of Mars",
    summary: "Hydrogen density 4e27 (r - 2.7e6)^-2.7 m-3 above the exobase; an image is the column \
              density.",
    source: SOURCE,
    length_unit: "m",
    image_unit: "m-2",
    energy_unit: None,
    parameters: &[COEFFICIENT, OFFSET, EXPONENT, EXOBASE_RADIUS],
    jumps_move_with: &[EXOBASE_RADIUS.name],
    edges: |values| spheres([0.0; 3], [values.of(EXOBASE_RADIUS.name)]),
    singular_points: nowhere,
    build: formula!(|values| MarsExosphere::from_values(&HYDROGEN, values)?),
};

pub(crate) const OXYGEN: ModelDescription = ModelDescription {
    name: "mars_oxygen",
    title: "Oxygen exosphere of Mars",
    summary: "Oxygen density 5e22 (r - 2.4e6)^-2.1 m-3 above the exobase; an image is the column \
              density.",
    parameters: &[
        ParameterDescription { default: ParameterDefault::Value(5e22), ..COEFFICIENT },
        ParameterDescription { default: ParameterDefault::Value(2.4e6), ..OFFSET },
        ParameterDescription { default: ParameterDefault::Value(2.1), ..EXPONENT },
        EXOBASE_RADIUS,
    ],
    build: formula!(|values| MarsExosphere::from_values(&OXYGEN, values)?),
    ..HYDROGEN
};

/// A neutral exosphere of Mars of density n = a/(r − b)^c \[m⁻³\], with r and b in m; none below
/// the exobase, for the law holds above it alone.
///
/// As an [`Emission`](emitree::Emission) it gives m⁻³: an image over m is the column density \[m⁻²\]. The planet does
/// not occult: a scene with it in view needs an occulter there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarsExosphere<T = f64> {
    coefficient: T,
    offset: T,
    exponent: T,
    exobase_radius: T,
}

impl MarsExosphere {
    /// Hydrogen with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range, or an exobase that is
    /// not above the offset, where the density grows without bounds.
    ///
    /// ```
    /// use emitree_models::models::MarsExosphere;
    /// use std::collections::BTreeMap;
    ///
    /// let hydrogen = MarsExosphere::hydrogen(&BTreeMap::new())?;
    /// let density = hydrogen.density_m3([0.0, 3.7e6, 0.0]); // r - b = 1000 km
    /// assert!((density / (4e27 * 1e6_f64.powf(-2.7)) - 1.0).abs() < 1e-14);
    /// assert_eq!(hydrogen.density_m3([0.0, 3.5e6, 0.0]), 0.0); // below the exobase
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn hydrogen(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Self::from_values(&HYDROGEN, &HYDROGEN.values(parameters)?)
    }

    /// Oxygen with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// As [`MarsExosphere::hydrogen`].
    ///
    /// ```
    /// use emitree_models::models::MarsExosphere;
    /// use std::collections::BTreeMap;
    ///
    /// let oxygen = MarsExosphere::oxygen(&BTreeMap::new())?;
    /// let density = oxygen.density_m3([0.0, 0.0, -4.4e6]); // r - b = 2000 km
    /// assert!((density / (5e22 * 2e6_f64.powf(-2.1)) - 1.0).abs() < 1e-14);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn oxygen(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Self::from_values(&OXYGEN, &OXYGEN.values(parameters)?)
    }

    /// The density \[m⁻³\] at a position \[m\]; 0 below the exobase.
    pub fn density_m3(&self, position: [f64; 3]) -> f64 {
        let r = radius(position);
        if r < self.exobase_radius {
            return 0.0;
        }
        one(r, |distances| self.at(distances))
    }
}

impl<T: Scalar> MarsExosphere<T> {
    fn from_values(description: &ModelDescription, values: &Values<T>) -> Result<Self, ModelError> {
        let law = [COEFFICIENT, OFFSET, EXPONENT].map(|parameter| values.of(parameter.name));
        Self::of(description, law, values.of(EXOBASE_RADIUS.name))
    }

    /// The exosphere a/(r − b)^c of `[a, b, c]`, for the model of this description.
    pub(super) fn of(
        description: &ModelDescription,
        [coefficient, offset, exponent]: [T; 3],
        exobase_radius: T,
    ) -> Result<Self, ModelError> {
        let (least, found) = (offset.value(), exobase_radius.value());
        if found <= least {
            let expected = format!("more than the offset of the density, {least:?} m");
            return Err(description.out_of_range(EXOBASE_RADIUS.name, found, expected));
        }
        Ok(Self { coefficient, offset, exponent, exobase_radius })
    }

    /// The densities at a block of positions.
    pub(super) fn fill_block(&self, positions: &[[f64; 3]], densities_m3: &mut [T]) {
        let range = [self.exobase_radius, T::of(f64::INFINITY)];
        let centre = [T::of(0.0); 3];
        fill_radial_block(positions, densities_m3, centre, range, |distances| self.at(distances));
    }

    /// Turns distances that are not below the exobase into densities.
    fn at(&self, distances: &mut [T]) {
        distances.iter_mut().for_each(|r| *r = *r - self.offset);
        T::raise_all(distances, -self.exponent);
        scale(distances, self.coefficient);
    }
}

impl<T: Scalar> Formula<T> for MarsExosphere<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_blocks(samples, rates, |positions, rates| self.fill_block(positions, rates));
    }
}

emission_of_formula!(MarsExosphere);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exobase_below_the_singularity_is_refused() {
        let parameters = BTreeMap::from([("exobase_radius".to_owned(), 2.5e6)]);
        assert_eq!(
            MarsExosphere::hydrogen(&parameters).unwrap_err().to_string(),
            "parameter `exobase_radius` of model `mars_hydrogen` is 2500000.0: expected more than \
             the offset of the density, 2700000.0 m"
        );
        assert!(MarsExosphere::oxygen(&parameters).is_ok());
    }

    #[test]
    fn the_exobase_itself_has_the_largest_density() {
        let oxygen = MarsExosphere::oxygen(&BTreeMap::new()).unwrap();
        let exobase = oxygen.density_m3([0.0, 0.0, -3.595e6]);
        assert!((exobase / (5e22 * 1.195e6_f64.powf(-2.1)) - 1.0).abs() < 1e-14);
        assert!(oxygen.density_m3([0.0, 0.0, -3.595_001e6]) < exobase);
        assert!(oxygen.density_m3([0.0, 0.0, -3.594_999e6]) <= 0.0);
    }
}
