//! Energetic neutral atoms of the Earth's ring current, by their energy.

use super::charge_exchange::cross_section_at_kev_cm2;
use super::constants::{EARTH_RADIUS_CM, JOULE_PER_KEV, PROTON_MASS_KG};
use super::fill_blocks;
use super::geocorona::{EXOBASE, fill_hydrogen_block_cm3};
use super::radial::radius;
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::{Scalar, digamma};
use core::f64::consts::PI;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "ena_ring",
    title: "Energetic neutral atoms of the ring current",
    summary: "Hydrogen atoms by their energy, from the charge exchange of a ring of hot protons in \
              a dipole field with the geocorona; hotter closer to the Earth.",
    source: "method: E. C. Roelof 1987, Geophys. Res. Lett. 14, 652, \
             doi:10.1029/GL014i006p00652; cross section: B. G. Lindsay and R. F. Stebbings 2005, J. \
             Geophys. Res. 110, A12213, doi:10.1029/2005JA011298; hydrogen: R. L. Rairden et al. \
             1986, J. Geophys. Res. 91, 13613, doi:10.1029/JA091iA12p13613; kappa distribution: G. \
             Livadiotis and D. J. McComas 2009, J. Geophys. Res. 114, A11105, \
             doi:10.1029/2009JA014352",
    length_unit: "R_E",
    image_unit: "cm-2 s-1 sr-1 keV-1",
    energy_unit: Some("keV"),
    parameters: &[
        ParameterDescription {
            name: "ion_density",
            unit: "cm-3",
            default: ParameterDefault::Value(3.0),
            meaning: "density of the protons at the peak of the ring",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "ion_temperature",
            unit: "keV",
            default: ParameterDefault::Value(8.0),
            meaning: "k T of the protons at the peak of the ring",
            range: AcceptedRange::Between(1e-3, 1e4),
        },
        ParameterDescription {
            name: "temperature_exponent",
            unit: "1",
            default: ParameterDefault::Value(8.0 / 3.0),
            meaning: "how fast the temperature falls outwards: as L^-n; 8/3 is adiabatic",
            range: AcceptedRange::Between(0.0, 10.0),
        },
        ParameterDescription {
            name: "kappa",
            unit: "1",
            default: ParameterDefault::Value(5.0),
            meaning: "index of the energetic tail; large values are Maxwellian",
            range: AcceptedRange::Between(1.6, 1e4),
        },
        ParameterDescription {
            name: "shell",
            unit: "R_E",
            default: ParameterDefault::Value(4.0),
            meaning: "L of the peak: where its field lines cross the equator",
            range: AcceptedRange::Between(EXOBASE, 20.0),
        },
        ParameterDescription {
            name: "shell_width",
            unit: "R_E",
            default: ParameterDefault::Value(0.8),
            meaning: "standard deviation of the ring in L",
            range: AcceptedRange::Between(0.01, 20.0),
        },
        ParameterDescription {
            name: "latitude_width",
            unit: "deg",
            default: ParameterDefault::Value(30.0),
            meaning: "standard deviation of the ring in magnetic latitude",
            range: AcceptedRange::Between(0.1, 1e6),
        },
    ],
    jumps_move_with: &[],
    edges: |_| spheres([0.0; 3], [EXOBASE]),
    singular_points: nowhere,
    build: formula!(|values| EnaRing::from_values(values)),
};

/// Hydrogen atoms of energy E that leave where the protons of the ring current exchange charge with
/// the geocorona, each in the direction and with the energy of its proton (Roelof 1987,
/// doi:10.1029/GL014i006p00652):
///
/// g(r, E) = nH σ(E) j(r, E).
///
/// * nH: the hydrogen of Rairden et al. 1986, as in [`Geocorona`](super::Geocorona), beyond their
///   12 `R_E` too; 0 below 1.08 `R_E`.
/// * σ: the cross section of Lindsay and Stebbings 2005 (doi:10.1029/2005JA011298), measured up to
///   250 keV.
/// * j: the isotropic flux of protons, of a kappa distribution in the form that has
///   the temperature T for every κ (doi:10.1029/2009JA014352), with θ = (κ − 3/2) kT:
///
///   j = n 2E m^(−1/2) (2π θ)^(−3/2) Γ(κ + 1)/Γ(κ − 1/2) (1 + E/θ)^(−κ − 1).
///
/// In a dipole field along z, with λ the magnetic latitude and L = r/cos²λ,
///
/// n = n0 exp(−(L − L0)²/2w² − λ²/2s²), T = T0 (L0/L)^p.
///
/// p = 8/3 is the adiabatic law for isotropic pressures, for a tube of flux has a
/// volume as L⁴. The latitude stands for pitch angles that are not: a large s is a density that is
/// constant along field lines.
///
/// As an [`Emission`](emitree::Emission) it gives cm⁻² s⁻¹ sr⁻¹ keV⁻¹ per `R_E` of 6.371·10⁸ cm, with energies in keV:
/// an image over `R_E` is in cm⁻² s⁻¹ sr⁻¹ keV⁻¹. For an energy that is not more than 0, or without
/// one, it is not a number. The Earth does not occult: a scene with the Earth in view needs
/// an occulter there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnaRing<T = f64> {
    /// n0 2 m^(−1/2) (2π (κ − 3/2))^(−3/2) Γ(κ + 1)/Γ(κ − 1/2) \[cm⁻² s⁻¹ keV^(−1/2)\]
    flux: T,
    temperature_kev: T,
    temperature_exponent: T,
    kappa: T,
    shell: T,
    shell_width: T,
    latitude_width_rad: T,
}

impl EnaRing {
    /// The ring with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range.
    ///
    /// ```
    /// use emitree_models::models::EnaRing;
    /// use std::collections::BTreeMap;
    ///
    /// let ring = EnaRing::new(&BTreeMap::new())?;
    /// let (inner, outer) = ([3.5, 0.0, 0.0], [0.0, -4.5, 0.0]);
    /// assert!(ring.temperature_kev(inner) > 1.9 * ring.temperature_kev(outer));
    /// assert!(ring.rate(inner, 100.0) > ring.rate(outer, 100.0));
    /// assert_eq!(ring.rate([0.0, 1.0, 0.0], 100.0), 0.0); // below the exobase
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    /// k T of the protons \[keV\] at a position \[`R_E`\]; 0 on the axis of the dipole.
    pub fn temperature_kev(&self, position: [f64; 3]) -> f64 {
        self.temperature_at(l_shell(position))
    }

    /// The flux of protons \[cm⁻² s⁻¹ sr⁻¹ keV⁻¹\] at a position outside of the Earth \[`R_E`\] and an
    /// energy \[keV\]; NaN for an energy that is not more than 0.
    pub fn proton_flux(&self, position: [f64; 3], energy_kev: f64) -> f64 {
        self.flux_of_protons(position, energy_kev)
    }

    /// The rate g \[cm⁻² s⁻¹ sr⁻¹ keV⁻¹ `R_E`⁻¹\] at a position \[`R_E`\] and an energy \[keV\]; 0
    /// below the exobase of the hydrogen, and NaN for an energy that is not more than 0.
    pub fn rate(&self, position: [f64; 3], energy_kev: f64) -> f64 {
        let mut hydrogen_cm3 = [0.0];
        fill_hydrogen_block_cm3(&[position], &mut hydrogen_cm3);
        self.rate_in(hydrogen_cm3[0], position, energy_kev)
    }
}

impl<T: Scalar> EnaRing<T> {
    fn from_values(values: &Values<T>) -> Self {
        let kappa = values.of("kappa");
        let ln_gammas = |kappa: f64| libm::lgamma(kappa + 1.0) - libm::lgamma(kappa - 0.5);
        let slope = |kappa: f64, _| digamma(kappa + 1.0) - digamma(kappa - 0.5);
        let gammas = kappa.map(ln_gammas, slope).exp();
        let speed_of_one_kev_cm_s = 100.0 * (2.0 * JOULE_PER_KEV / PROTON_MASS_KG).sqrt();
        // 2 m^(−1/2) is √2 times the speed of a proton of 1 keV.
        let per_density = gammas * (core::f64::consts::SQRT_2 * speed_of_one_kev_cm_s)
            / ((kappa - 1.5) * (2.0 * PI)).powf(T::of(1.5));
        Self {
            flux: values.of("ion_density") * per_density,
            temperature_kev: values.of("ion_temperature"),
            temperature_exponent: values.of("temperature_exponent"),
            kappa,
            shell: values.of("shell"),
            shell_width: values.of("shell_width"),
            latitude_width_rad: values.of("latitude_width") * (PI / 180.0),
        }
    }

    fn temperature_at(&self, l_shell: f64) -> T {
        self.temperature_kev * (self.shell / l_shell).powf(self.temperature_exponent)
    }

    /// The flux of protons at a position outside of the Earth and an energy.
    fn flux_of_protons(&self, position: [f64; 3], energy_kev: f64) -> T {
        if energy_kev.is_nan() || energy_kev <= 0.0 {
            return T::of(f64::NAN);
        }
        let l_shell = l_shell(position);
        let from_peak = (T::of(l_shell) - self.shell) / self.shell_width;
        let [x, y, z] = position;
        let latitudes = T::of(z.atan2(x.hypot(y))) / self.latitude_width_rad;
        let fraction = ((from_peak * from_peak + latitudes * latitudes) * -0.5).exp();
        // Far from the ring the temperature may not be a number more than 0.
        if fraction.value() <= 0.0 {
            return T::of(0.0);
        }
        let temperature_kev = self.temperature_at(l_shell);
        let in_tails = T::of(energy_kev) / ((self.kappa - 1.5) * temperature_kev);
        let spectrum = (-(self.kappa + 1.0) * in_tails.ln_1p()).exp();
        self.flux * fraction * spectrum * energy_kev / (temperature_kev * temperature_kev.sqrt())
    }

    /// The rate where the hydrogen has this density.
    fn rate_in(&self, hydrogen_cm3: T, position: [f64; 3], energy_kev: f64) -> T {
        if energy_kev.is_nan() || energy_kev <= 0.0 {
            return T::of(f64::NAN);
        }
        if hydrogen_cm3.value() <= 0.0 {
            return T::of(0.0);
        }
        let exchanges = hydrogen_cm3 * cross_section_at_kev_cm2(energy_kev);
        exchanges * self.flux_of_protons(position, energy_kev) * EARTH_RADIUS_CM
    }
}

/// L = r/cos²λ \[`R_E`\] of a dipole along z; infinite on its axis.
fn l_shell(position: [f64; 3]) -> f64 {
    let [x, y, _] = position;
    let r = radius(position);
    let secant = r / x.hypot(y);
    r * secant * secant
}

impl<T: Scalar> Formula<T> for EnaRing<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_blocks(samples, rates, fill_hydrogen_block_cm3);
        let energies = samples.energies().iter().copied().chain(core::iter::repeat(f64::NAN));
        for ((rate, &position), energy) in rates.iter_mut().zip(samples.positions()).zip(energies) {
            *rate = self.rate_in(*rate, position, energy);
        }
    }
}

emission_of_formula!(EnaRing);

#[cfg(test)]
mod tests {
    use super::*;

    fn ring<const N: usize>(given: [(&str, f64); N]) -> EnaRing {
        let parameters = given.map(|(name, value)| (name.to_owned(), value));
        EnaRing::new(&BTreeMap::from(parameters)).unwrap()
    }

    /// ∫ f(E) dE from 0 to infinity, by the midpoint rule in the logarithm of E \[keV\].
    fn over_energy(f: impl Fn(f64) -> f64) -> f64 {
        let (from, to, steps) = (1e-8_f64.ln(), 1e12_f64.ln(), 20_000_u32);
        let width = (to - from) / f64::from(steps);
        (0..steps)
            .map(|step| (from + (f64::from(step) + 0.5) * width).exp())
            .map(|energy| f(energy) * energy * width)
            .sum()
    }

    #[test]
    fn the_spectrum_has_its_density_and_temperature() {
        // n = 4π Int j/v dE, and 3/2 kT is the mean energy.
        for kappa in [3.5, 5.0, 40.0, 1e4] {
            let ring = ring([("kappa", kappa), ("ion_temperature", 5.0)]);
            let peak = [0.0, 4.0, 0.0];
            let density_at = |energy: f64| {
                let speed_cm_s = 100.0 * (2.0 * energy * JOULE_PER_KEV / PROTON_MASS_KG).sqrt();
                4.0 * PI * ring.proton_flux(peak, energy) / speed_cm_s
            };
            let density = over_energy(density_at);
            assert!((density / 3.0 - 1.0).abs() < 1e-9, "{kappa}: {density}");
            let energy = over_energy(|energy| energy * density_at(energy)) / density;
            assert!((energy / 7.5 - 1.0).abs() < 1e-9, "{kappa}: {energy}");
        }
    }

    #[test]
    fn a_large_kappa_is_maxwellian() {
        let ring = ring([("kappa", 1e4)]);
        let flux = |energy: f64| ring.proton_flux([4.0, 0.0, 0.0], energy) / energy;
        for energy in [0.1, 5.0, 40.0_f64] {
            let ratio = flux(energy) / flux(1e-6) / (-energy / 8.0).exp();
            assert!((ratio - 1.0).abs() < 3e-3, "{energy}: {ratio}");
        }
    }

    #[test]
    fn field_lines_are_those_of_a_dipole() {
        let wide = ring([("latitude_width", 1e6)]);
        let on_equator = wide.proton_flux([4.4, 0.0, 0.0], 20.0);
        for latitude in [0.3, -0.7, 0.9_f64] {
            let (sin, cos) = latitude.sin_cos();
            let r = 4.4 * cos * cos;
            let along = wide.proton_flux([0.6 * r * cos, -0.8 * r * cos, r * sin], 20.0);
            assert!((along / on_equator - 1.0).abs() < 1e-8, "{latitude}");
        }
        assert!(wide.proton_flux([0.0, 0.0, 2.0], 20.0) <= 0.0);
    }

    #[test]
    fn colder_outside_by_the_adiabatic_law() {
        let ring = ring([]);
        let ratio = ring.temperature_kev([8.0, 0.0, 0.0]) / 8.0;
        assert!((ratio - 2.0_f64.powf(-8.0 / 3.0)).abs() < 1e-15);
        assert!(ring.temperature_kev([0.0, 0.0, 3.0]) <= 0.0);
    }

    #[test]
    fn there_are_no_atoms_without_energy() {
        let ring = ring([]);
        let rate = |energy| ring.rate([4.0, 0.0, 0.0], energy);
        assert!([0.0, -1.0, f64::NAN].iter().all(|&energy| rate(energy).is_nan()));
    }
}
