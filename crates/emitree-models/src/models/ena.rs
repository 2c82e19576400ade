//! Energetic neutral atoms: protons that exchange charge with a hydrogen exosphere.

use super::BLOCK;
use super::charge_exchange;
use super::constants::{BOLTZMANN_CONSTANT, PROTON_MASS_KG};
use super::mars_exosphere::{COEFFICIENT, EXOBASE_RADIUS, EXPONENT, MarsExosphere, OFFSET};
use super::speed_integral::SpeedIntegral;
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::elementary::Elementary;
use crate::scalar::Scalar;
use core::f64::consts::PI;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "ena",
    title: "Energetic neutral atoms from protons in a hydrogen exosphere",
    summary: "Flux of energetic hydrogen atoms from the charge exchange of drifting Maxwellian \
              protons with an exosphere, that of Mars by default; it depends on the direction.",
    source: "M. Holmström, S. Barabash and E. Kallio 2002, J. Geophys. Res. 107, 1277, \
             doi:10.1029/2001JA000325; cross section: B. G. Lindsay and R. F. Stebbings 2005, \
             J. Geophys. Res. 110, A12213, doi:10.1029/2005JA011298",
    length_unit: "m",
    image_unit: "m-2 s-1 sr-1",
    energy_unit: None,
    parameters: &[
        ParameterDescription {
            name: "ion_density",
            unit: "m-3",
            default: ParameterDefault::Value(2.5e6),
            meaning: "density of the protons",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "ion_temperature",
            unit: "K",
            default: ParameterDefault::Value(1.2e5),
            meaning: "temperature of the protons",
            range: AcceptedRange::Between(1e3, 1e9),
        },
        VELOCITY_X,
        ParameterDescription {
            name: "velocity_y",
            default: ParameterDefault::Value(0.0),
            meaning: "bulk velocity of the protons along y",
            ..VELOCITY_X
        },
        ParameterDescription {
            name: "velocity_z",
            default: ParameterDefault::Value(0.0),
            meaning: "bulk velocity of the protons along z",
            ..VELOCITY_X
        },
        ParameterDescription { name: "neutral_coefficient", ..COEFFICIENT },
        ParameterDescription { name: "neutral_offset", ..OFFSET },
        ParameterDescription { name: "neutral_exponent", ..EXPONENT },
        EXOBASE_RADIUS,
    ],
    jumps_move_with: &[EXOBASE_RADIUS.name],
    edges: |values| spheres([0.0; 3], [values.of(EXOBASE_RADIUS.name)]),
    singular_points: nowhere,
    build: formula!(|values| Ena::from_values(values)?),
};

/// The solar wind, which comes from +x; up to where the cross section has been measured.
const VELOCITY_X: ParameterDescription = ParameterDescription {
    name: "velocity_x",
    unit: "m s-1",
    default: ParameterDefault::Value(-4e5),
    meaning: "bulk velocity of the protons along x",
    range: AcceptedRange::Between(-3e6, 3e6),
};

/// Energetic neutral atoms that leave in direction d from a place where protons, a Maxwellian f
/// with a drift u, the same everywhere, exchange charge with the neutral exosphere nH:
///
/// g(r, d) = nH(r) ∫₀^∞ σ(v) v³ f(v d) dv,
/// f(v) = n (π w²)^(−3/2) e^(−|v − u|²/w²), w² = 2 k T/m.
///
/// The neutrals are at rest against the protons, σ is the cross section of Lindsay and Stebbings
/// 2005 (doi:10.1029/2005JA011298), and nH is [`MarsExosphere`]'s, 0 below the exobase.
///
/// With n, T and u the same everywhere the integral depends on d·u alone. It is tabulated when the
/// model is made, and within 10⁻¹¹ of its value at each direction: a rate costs a few functions.
///
/// A cold beam goes almost one way: with the default solar wind, 9 times faster than w, an image
/// is above 0 only along lines of sight within some 20 degrees of the Sun, on +x.
///
/// As an [`Emission`](emitree::Emission) it gives m⁻³ s⁻¹ sr⁻¹: an image over m is in m⁻² s⁻¹ sr⁻¹. The planet does
/// not occult: a scene with it in view needs an occulter there.
#[derive(Clone, Debug, PartialEq)]
pub struct Ena<T = f64> {
    neutrals: MarsExosphere<T>,
    /// u/w
    drift: [T; 3],
    speed_integral: SpeedIntegral<T>,
    /// n π^(−3/2) w \[m⁻² s⁻¹\]: what is left of n (π w²)^(−3/2) v³ dv
    flux: T,
}

impl Ena {
    /// The emission with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range, or an exobase that is
    /// not above `neutral_offset`, where the density of the neutrals grows without bounds.
    ///
    /// ```
    /// use emitree_models::models::Ena;
    /// use std::collections::BTreeMap;
    ///
    /// let atoms = Ena::new(&BTreeMap::new())?;
    /// let position = [0.0, 0.0, 5e6];
    /// let (with_the_wind, against) = ([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    /// assert!(atoms.rate(position, with_the_wind) > 1e30 * atoms.rate(position, against));
    /// assert_eq!(atoms.rate([0.0, 0.0, 3e6], with_the_wind), 0.0); // inside the planet
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Self::from_values(&DESCRIPTION.values(parameters)?)
    }

    /// σ \[m²\] of a proton of this speed \[m/s\] in the hydrogen that it exchanges its charge with;
    /// infinite at rest.
    ///
    /// ```
    /// use emitree_models::models::Ena;
    ///
    /// let one_kev = Ena::cross_section_m2(437.7e3);
    /// assert!((one_kev / 1.722e-19 - 1.0).abs() < 1e-3);
    /// ```
    pub fn cross_section_m2(speed_m_s: f64) -> f64 {
        charge_exchange::cross_section_m2(speed_m_s)
    }

    /// The rate g \[m⁻³ s⁻¹ sr⁻¹\] at a position \[m\] in a direction of length 1, in which the atoms
    /// fly; 0 below the exobase.
    pub fn rate(&self, position: [f64; 3], direction: [f64; 3]) -> f64 {
        let mut rates = [0.0];
        self.fill_block(&[position], &[direction], &mut rates);
        rates[0]
    }
}

impl<T: Scalar> Ena<T> {
    fn from_values(values: &Values<T>) -> Result<Self, ModelError> {
        let law = ["neutral_coefficient", "neutral_offset", "neutral_exponent"]
            .map(|name| values.of(name));
        let neutrals = MarsExosphere::of(&DESCRIPTION, law, values.of(EXOBASE_RADIUS.name))?;
        let temperature = values.of("ion_temperature");
        let thermal_speed_m_s = (temperature * (2.0 * BOLTZMANN_CONSTANT) / PROTON_MASS_KG).sqrt();
        let drift = ["velocity_x", "velocity_y", "velocity_z"]
            .map(|name| values.of(name) / thermal_speed_m_s);
        let [ux, uy, uz] = drift.map(T::value);
        let largest_drift = (ux * ux + uy * uy + uz * uz).sqrt();
        Ok(Self {
            neutrals,
            drift,
            speed_integral: SpeedIntegral::new(thermal_speed_m_s, largest_drift),
            flux: values.of("ion_density") * thermal_speed_m_s / (PI * PI.sqrt()),
        })
    }

    fn fill_block(&self, positions: &[[f64; 3]], directions: &[[f64; 3]], rates: &mut [T]) {
        self.neutrals.fill_block(positions, rates);
        let mut exponents = [T::of(0.0); BLOCK];
        let exponents = &mut exponents[..positions.len()];
        let lit = rates.iter().zip(directions).zip(&mut *exponents);
        for ((_, &direction), exponent) in
            lit.filter(|((density_m3, _), _)| density_m3.value() > 0.0)
        {
            *exponent = self.exponent(direction);
        }
        T::apply(Elementary::Exp, exponents);
        for (rate, exponential) in rates.iter_mut().zip(&*exponents) {
            *rate = *rate * self.flux * *exponential;
        }
    }

    /// ln of the flux in a direction over that of protons at rest on average.
    fn exponent(&self, direction: [f64; 3]) -> T {
        let towards = direction.map(T::of);
        let along = dot(towards, self.drift);
        // The part of |v d − u|²/w² that the speed integral leaves: the drift across the direction,
        // or all of it in directions against the drift.
        let with = if along.value() > 0.0 { along } else { T::of(0.0) };
        let across = [0, 1, 2].map(|axis| self.drift[axis] - with * direction[axis]);
        self.speed_integral.ln_at(along) - dot(across, across)
    }
}

fn dot<T: Scalar>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl<T: Scalar> Formula<T> for Ena<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        let blocks = samples.positions().chunks(BLOCK).zip(samples.directions().chunks(BLOCK));
        for ((positions, directions), rates) in blocks.zip(rates.chunks_mut(BLOCK)) {
            self.fill_block(positions, directions, rates);
        }
    }
}

emission_of_formula!(Ena);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plasma_at_rest_is_isotropic() {
        let parameters = BTreeMap::from([("velocity_x".to_owned(), 0.0)]);
        let atoms = Ena::new(&parameters).unwrap();
        let rate = |direction| atoms.rate([4e6, 0.0, 0.0], direction);
        let ratio = rate([0.6, 0.0, -0.8]) / rate([-1.0, 0.0, 0.0]);
        assert!(rate([1.0, 0.0, 0.0]) > 0.0 && (ratio - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_cold_beam_carries_its_flux_along() {
        // Int over directions of the rate, g sigma v of one speed: nH n sigma(u) u.
        let cold = [("ion_temperature".to_owned(), 1e3), ("velocity_x".to_owned(), -1e6)];
        let atoms = Ena::new(&BTreeMap::from(cold)).unwrap();
        let position = [0.0, 4e6, 0.0];
        // About −x by the midpoint rule in the square of the angle; w/u = 0.004.
        let steps = 4000_u32;
        let end = 0.03_f64.powi(2);
        let width = end / f64::from(steps);
        let flux: f64 = (0..steps)
            .map(|step| {
                let (sin, cos) = ((f64::from(step) + 0.5) * width).sqrt().sin_cos();
                let angle = ((f64::from(step) + 0.5) * width).sqrt();
                atoms.rate(position, [-cos, 0.0, sin]) * sin / angle * width * PI
            })
            .sum();
        let neutrals = atoms.neutrals.density_m3(position);
        let expected = neutrals * 2.5e6 * Ena::cross_section_m2(1e6) * 1e6;
        assert!((flux / expected - 1.0).abs() < 1e-4, "{}", flux / expected);
    }

    #[test]
    fn an_exobase_below_the_singularity_is_refused() {
        let parameters = BTreeMap::from([("neutral_offset".to_owned(), 3.6e6)]);
        assert_eq!(
            Ena::new(&parameters).unwrap_err().to_string(),
            "parameter `exobase_radius` of model `ena` is 3595000.0: expected more than the \
             offset of the density, 3600000.0 m"
        );
    }
}
