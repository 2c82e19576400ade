//! The Sun's K corona: light scattered by the electrons of Saito 1970.

use super::constants::{SOLAR_RADIUS_CM, THOMSON_CROSS_SECTION_CM2};
use super::fill_directional_rates;
use super::radial::radius;
use super::thomson::VanDeHulst;
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "k_corona",
    title: "K corona of the solar minimum (Saito 1970)",
    summary: "Sunlight scattered by the electrons of the corona, whose axis is +z, in units of the \
              mean brightness of the Sun's disk; it depends on the direction.",
    source: "density: K. Saito 1970, Ann. Tokyo Astron. Obs. 12, 53; scattering: H. C. van de \
             Hulst 1950, Bull. Astron. Inst. Neth. 11, 135",
    length_unit: "R_sun",
    image_unit: "",
    energy_unit: None,
    parameters: &[LIMB_DARKENING],
    jumps_move_with: &[],
    edges: |_| spheres([0.0; 3], [1.0]),
    singular_points: nowhere,
    build: formula!(|values| KCorona::from_values(values)),
};

/// The parameter of the Sun's disk.
pub(super) const LIMB_DARKENING: ParameterDescription = ParameterDescription {
    name: "limb_darkening",
    unit: "1",
    default: ParameterDefault::Value(0.58),
    meaning: "u of the Sun's brightness 1 - u + u cos(theta) across its disk",
    range: AcceptedRange::Between(0.0, 1.0),
};

/// The K corona of the solar minimum: electrons of the density of Saito 1970,
///
/// Ne = 3.09·10⁸ r⁻¹⁶ (1 − ½ s) + 1.58·10⁸ r⁻⁶ (1 − 0.95 s) + 0.0251·10⁸ r^−2.5 (1 − √s) cm⁻³,
///
/// s = |sin latitude|, r in `R_sun`, the Sun's axis along +z. They scatter the light of a disk of
/// brightness 1 − u + u cos θ (Thomson scattering, van de Hulst 1950, with his A to D):
///
/// g = Ne (tot − pol sin² χ), tot = 2 K \[C + u (D − C)\]/(1 − u/3), pol = K \[A + u (B − A)\]/(1 − u/3)
///
/// with the angle χ between the radius and the direction of emission.
///
/// # Units
///
/// An image is in units of the mean brightness of the Sun's disk, (1 − u/3) times that of its
/// centre: a pure number, so that the image has no unit. K then is ½π re², that is 3/16 of the
/// Thomson cross section: an electron far away receives the mean brightness in a solid angle π/r² and
/// scatters ½ re² (1 + cos² χ) of it into a steradian, and there tot − pol sin² χ →
/// K (1 + cos² χ)/r². As an [`Emission`](emitree::Emission) it gives that per `R_sun` of 6.957·10¹⁰ cm.
///
/// There is no emission inside the Sun, r < 1, but the model does not occult: a scene with the Sun in
/// view needs an occulter there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KCorona<T = f64> {
    limb_darkening: T,
}

/// ½π re² \[cm²\]
const SCATTERING_CM2: f64 = 3.0 / 16.0 * THOMSON_CROSS_SECTION_CM2;

impl KCorona {
    /// The corona with these parameters: `limb_darkening` or nothing.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for another parameter, or a limb darkening outside 0 to 1.
    ///
    /// ```
    /// use emitree_models::models::KCorona;
    /// use std::collections::BTreeMap;
    ///
    /// let corona = KCorona::new(&BTreeMap::new())?;
    /// let equator = [2.0, 0.0, 0.0];
    /// assert!((corona.electron_density_cm3(equator) / 2.917e6 - 1.0).abs() < 1e-3);
    /// // Scattering straight on, or back, is not weakened as scattering sideways is.
    /// let (along, across) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// assert!(corona.rate(equator, along) > 1.5 * corona.rate(equator, across));
    /// assert_eq!(corona.rate([0.5, 0.0, 0.0], along), 0.0); // inside the Sun
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    /// Ne \[cm⁻³\] at a position \[`R_sun`\]; 0 inside the Sun.
    pub fn electron_density_cm3(&self, position: [f64; 3]) -> f64 {
        electron_density_cm3(position)
    }

    /// The rate g \[mean brightness of the disk per `R_sun`\] at a position \[`R_sun`\] in a
    /// direction of length 1; 0 inside the Sun.
    pub fn rate(&self, position: [f64; 3], direction: [f64; 3]) -> f64 {
        self.at(position, direction)
    }
}

/// Ne \[cm⁻³\] at a position \[`R_sun`\]; 0 inside the Sun.
fn electron_density_cm3(position: [f64; 3]) -> f64 {
    let r = radius(position);
    if r < 1.0 {
        return 0.0;
    }
    // Not above 1, whatever the roundings of r.
    let s = (position[2].abs() / r).min(1.0);
    3.09e8 * r.powi(-16) * (1.0 - 0.5 * s)
        + 1.58e8 * r.powi(-6) * (1.0 - 0.95 * s)
        + 0.0251e8 * r.powf(-2.5) * (1.0 - s.sqrt())
}

impl<T: Scalar> KCorona<T> {
    pub(super) fn from_values(values: &Values<T>) -> Self {
        Self { limb_darkening: values.of("limb_darkening") }
    }

    /// The rate at a position in a direction.
    fn at(&self, position: [f64; 3], direction: [f64; 3]) -> T {
        self.scattered(position, direction, |total, polarised| total - polarised)
    }

    /// The rate of tot and pol sin² χ, both for K/(1 − u/3) of 1, at a position in a direction.
    pub(super) fn scattered(
        &self,
        position: [f64; 3],
        direction: [f64; 3],
        rate_of: impl FnOnce(T, T) -> T,
    ) -> T {
        let r = radius(position);
        if r < 1.0 {
            return T::of(0.0);
        }
        let cos_chi = (0..3).map(|axis| position[axis] / r * direction[axis]).sum::<f64>();
        let sin2_chi = (1.0 - cos_chi * cos_chi).max(0.0);
        let at = VanDeHulst::new(r);
        let u = self.limb_darkening;
        let total = (T::of(at.c) + u * (at.d - at.c)) * 2.0;
        let polarised = T::of(at.a) + u * (at.b - at.a);
        let rate = rate_of(total, polarised * sin2_chi);
        let cm2 = T::of(SCATTERING_CM2) / (T::of(1.0) - u / 3.0) * rate;
        cm2 * electron_density_cm3(position) * SOLAR_RADIUS_CM
    }
}

impl<T: Scalar> Formula<T> for KCorona<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_directional_rates(samples, rates, |position, direction| self.at(position, direction));
    }
}

emission_of_formula!(KCorona);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn k_is_half_pi_times_the_square_of_the_electron_radius() {
        // re = 2.8179403205e-13 cm, CODATA 2022.
        let expected = 0.5 * core::f64::consts::PI * 2.817_940_320_5e-13_f64.powi(2);
        assert!((SCATTERING_CM2 / expected - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_poles_and_the_limb_are_finite() {
        let corona = KCorona::new(&BTreeMap::new()).unwrap();
        let direction = [0.0, 0.0, -1.0];
        for position in [[0.0, 0.0, 1.0], [0.0, 0.0, -3.0], [1.0, 0.0, 0.0], [0.6, 0.0, 0.8]] {
            assert!(corona.rate(position, direction) > 0.0, "{position:?}");
        }
        // At the pole the third term vanishes.
        let pole = corona.electron_density_cm3([0.0, 0.0, 10.0]);
        assert!((pole / (3.09e8 * 1e-16 * 0.5 + 1.58e8 * 1e-6 * 0.05) - 1.0).abs() < 1e-13);
    }
}
