//! The polarised brightness of the Sun's K corona.

use super::fill_directional_rates;
use super::k_corona::{KCorona, LIMB_DARKENING};
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::Values;
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "k_corona_polarised",
    title: "polarised brightness of the K corona (Saito 1970)",
    summary: "The tangential minus the radial polarisation of the light of k_corona, pB, in units of the \
              mean brightness of the Sun's disk; it depends on the direction.",
    source: "density: K. Saito 1970, Ann. Tokyo Astron. Obs. 12, 53; scattering: M. Minnaert 1930, Z. \
             Astrophys. 1, 209; H. C. van de Hulst 1950, Bull. Astron. Inst. Neth. 11, 135; \
             doi:10.1007/s11214-009-9542-5",
    length_unit: "R_sun",
    image_unit: "",
    energy_unit: None,
    parameters: &[LIMB_DARKENING],
    jumps_move_with: &[],
    edges: |_| spheres([0.0; 3], [1.0]),
    singular_points: nowhere,
    build: formula!(|values| PolarisedKCorona::from_values(values)),
};

/// The polarised brightness pB of the [`KCorona`]: its light with the electric field perpendicular to the plane of the
/// line of sight and the Sun's centre, minus that with the field in this plane,
///
/// g = Ne pol sin² χ, pol = K \[A + u (B − A)\]/(1 − u/3)
///
/// with K and χ as of [`KCorona`]. All points of a line of sight have the same plane, so that the image is the
/// integral of g, as that of the total brightness is. The degree of polarisation is the quotient of both images.
///
/// # Units
///
/// As of [`KCorona`]; there is no emission inside the Sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarisedKCorona<T = f64>(KCorona<T>);

impl PolarisedKCorona {
    /// The corona with these parameters: `limb_darkening` or nothing.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for another parameter, or a limb darkening outside 0 to 1.
    ///
    /// ```
    /// use emitree_models::models::{KCorona, PolarisedKCorona};
    /// use std::collections::BTreeMap;
    ///
    /// let (total, polarised) = (KCorona::new(&BTreeMap::new())?, PolarisedKCorona::new(&BTreeMap::new())?);
    /// let (far, across) = ([50.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// // Light of a distant Sun that is scattered sideways is polarised, light that goes straight on is not.
    /// assert!(polarised.rate(far, across) > 0.999 * total.rate(far, across));
    /// assert_eq!(polarised.rate(far, [1.0, 0.0, 0.0]), 0.0);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    /// The rate g \[mean brightness of the disk per `R_sun`\] at a position \[`R_sun`\] in a
    /// direction of length 1; 0 inside the Sun.
    pub fn rate(&self, position: [f64; 3], direction: [f64; 3]) -> f64 {
        self.at(position, direction)
    }
}

impl<T: Scalar> PolarisedKCorona<T> {
    fn from_values(values: &Values<T>) -> Self {
        Self(KCorona::from_values(values))
    }

    fn at(&self, position: [f64; 3], direction: [f64; 3]) -> T {
        self.0.scattered(position, direction, |_, polarised| polarised)
    }
}

impl<T: Scalar> Formula<T> for PolarisedKCorona<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_directional_rates(samples, rates, |position, direction| self.at(position, direction));
    }
}

emission_of_formula!(PolarisedKCorona);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_between_0_and_the_total_everywhere() {
        for u in [0.0, 0.58, 1.0] {
            let parameters = BTreeMap::from([("limb_darkening".to_owned(), u)]);
            let total = KCorona::new(&parameters).unwrap();
            let polarised = PolarisedKCorona::new(&parameters).unwrap();
            for r in [1.0, 1.000_001, 1.1, 2.0, 10.0, 215.0] {
                for angle in [0.0, 0.3, 1.0, 1.5, 2.7] {
                    let direction = [f64::cos(angle), f64::sin(angle), 0.0];
                    let position = [0.8 * r, 0.0, 0.6 * r];
                    let [all, part] =
                        [total.rate(position, direction), polarised.rate(position, direction)];
                    assert!((0.0..=all).contains(&part), "{u}, {r}, {angle}: {part}, {all}");
                }
            }
        }
    }
}
