//! The Earth's geocorona in Lyman α, after Rairden et al. 1986.

use super::constants::{EARTH_RADIUS_CM, RAYLEIGH_PER_COLUMN_CM2};
use super::radial::radius;
use super::{fill_radial_block, fill_radial_rates, one, scale};
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::elementary::Elementary;
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

/// The exobase of the fit \[`R_E`\], below which there is no density.
pub(super) const EXOBASE: f64 = 1.08;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "geocorona",
    title: "Geocorona in Lyman alpha (Rairden et al. 1986)",
    summary: "Sunlight at 121.6 nm scattered once, isotropically, by hydrogen of the \
              spherical density that Dynamics Explorer 1 measured.",
    source: "R. L. Rairden, L. A. Frank and J. D. Craven 1986, J. Geophys. Res. 91, 13613, \
             doi:10.1029/JA091iA12p13613",
    length_unit: "R_E",
    image_unit: "R",
    energy_unit: None,
    parameters: &[
        ParameterDescription {
            name: "g_factor",
            unit: "s-1",
            default: ParameterDefault::Value(2.09e-3),
            meaning: "photons that one atom scatters in a second",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "inner_radius",
            unit: "R_E",
            default: ParameterDefault::Value(EXOBASE),
            meaning: "distance below which there is no emission",
            range: AcceptedRange::Between(EXOBASE, 100.0),
        },
        ParameterDescription {
            name: "outer_radius",
            unit: "R_E",
            default: ParameterDefault::Value(12.0),
            meaning: "distance beyond which there is no emission",
            range: AcceptedRange::Between(EXOBASE, 100.0),
        },
    ],
    jumps_move_with: &["inner_radius", "outer_radius"],
    edges: |values| spheres([0.0; 3], [values.of("inner_radius"), values.of("outer_radius")]),
    singular_points: nowhere,
    build: formula!(|values| Geocorona::from_values(values)?),
};

/// Lyman α of the geocorona, optically thin, with the hydrogen density of Rairden et al. 1986
/// (doi:10.1029/JA091iA12p13613),
///
/// n = exp(10.692 − 4.4431 (ln(r/1.08))^0.715831) cm⁻³ for 1.08 < r < 12, r in `R_E`,
///
/// times the photons that an atom scatters in a second.
///
/// As an [`Emission`](emitree::Emission) it gives rayleigh per `R_E` of 6.371·10⁸ cm, with 10⁶ photons cm⁻² s⁻¹ to a
/// rayleigh: an image over `R_E` is in rayleigh. The Earth does not occult: a
/// scene with the Earth in view needs an occulter there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geocorona<T = f64> {
    g_factor: T,
    inner_radius: T,
    outer_radius: T,
}

impl Geocorona {
    /// The geocorona with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range, or an outer radius that
    /// is not more than the inner one.
    ///
    /// ```
    /// use emitree_models::models::Geocorona;
    /// use std::collections::BTreeMap;
    ///
    /// let geocorona = Geocorona::new(&BTreeMap::new())?;
    /// let e_fold = 1.08 * 1.0_f64.exp();
    /// let density = geocorona.density_cm3([0.0, e_fold, 0.0]);
    /// assert!((density / (10.692_f64 - 4.4431).exp() - 1.0).abs() < 1e-13);
    /// assert_eq!(geocorona.density_cm3([0.0, 1.0, 0.0]), 0.0);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Self::from_values(&DESCRIPTION.values(parameters)?)
    }

    /// The density of hydrogen \[cm⁻³\] at a position \[`R_E`\]; 0 inside the inner radius and
    /// outside the outer one.
    pub fn density_cm3(&self, position: [f64; 3]) -> f64 {
        let r = radius(position);
        if !(self.inner_radius..=self.outer_radius).contains(&r) {
            return 0.0;
        }
        one(r, hydrogen_densities_cm3)
    }
}

impl<T: Scalar> Geocorona<T> {
    fn from_values(values: &Values<T>) -> Result<Self, ModelError> {
        let [g_factor, inner_radius, outer_radius] =
            ["g_factor", "inner_radius", "outer_radius"].map(|name| values.of(name));
        let (inner, outer) = (inner_radius.value(), outer_radius.value());
        if outer <= inner {
            let expected = format!("more than inner_radius = {inner:?}");
            return Err(DESCRIPTION.out_of_range("outer_radius", outer, expected));
        }
        Ok(Self { g_factor, inner_radius, outer_radius })
    }
}

/// The density of hydrogen \[cm⁻³\] at a block of positions \[`R_E`\]; 0 below [`EXOBASE`].
pub(super) fn fill_hydrogen_block_cm3<T: Scalar>(positions: &[[f64; 3]], densities: &mut [T]) {
    let (centre, range) = ([T::of(0.0); 3], [EXOBASE, f64::INFINITY].map(T::of));
    fill_radial_block(positions, densities, centre, range, hydrogen_densities_cm3);
}

/// Turns distances of at least [`EXOBASE`] into densities.
fn hydrogen_densities_cm3<T: Scalar>(distances: &mut [T]) {
    distances.iter_mut().for_each(|r| *r = *r / EXOBASE);
    T::apply(Elementary::Ln, distances);
    T::raise_all(distances, T::of(0.715_831));
    distances.iter_mut().for_each(|power| *power = T::of(10.692) - *power * 4.4431);
    T::apply(Elementary::Exp, distances);
}

impl<T: Scalar> Formula<T> for Geocorona<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        let rayleigh_per_density = self.g_factor * RAYLEIGH_PER_COLUMN_CM2 * EARTH_RADIUS_CM;
        let range = [self.inner_radius, self.outer_radius];
        fill_radial_rates(samples, rates, [T::of(0.0); 3], range, |distances| {
            hydrogen_densities_cm3(distances);
            scale(distances, rayleigh_per_density);
        });
    }
}

emission_of_formula!(Geocorona);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_at_both_radii() {
        let geocorona = Geocorona::new(&BTreeMap::new()).unwrap();
        let density = |r: f64| geocorona.density_cm3([0.0, -r, 0.0]);
        assert!((density(1.08) / 10.692_f64.exp() - 1.0).abs() < 1e-14);
        assert!(density(1.079_999) <= 0.0 && density(12.000_001) <= 0.0 && density(12.0) > 10.0);
    }

    #[test]
    fn radii_in_the_wrong_order_are_refused() {
        let parameters = BTreeMap::from([("outer_radius".to_owned(), 1.08)]);
        assert_eq!(
            Geocorona::new(&parameters).unwrap_err().to_string(),
            "parameter `outer_radius` of model `geocorona` is 1.08: expected more than \
             inner_radius = 1.08"
        );
    }
}
