//! X-ray spectra of the hot gas in a cluster of galaxies: thermal bremsstrahlung.

use super::BLOCK;
use super::constants::{BOLTZMANN_CONSTANT, JOULE_PER_KEV, KILOPARSEC_CM, PLANCK_CONSTANT_ERG_S};
use super::radial::{CENTRE_X, CENTRE_Y, CENTRE_Z, centre, distance, distances};
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::elementary::Elementary;
use crate::scalar::Scalar;
use core::f64::consts::PI;
use emitree::Samples;
use std::collections::BTreeMap;

/// Of the emissivity of Rybicki and Lightman 1979, eq. 5.14b \[erg s⁻¹ cm⁻³ Hz⁻¹\], for densities
/// in cm⁻³ and a temperature in K, to the digits of the book.
const FREE_FREE: f64 = 6.8e-38;

/// k T of one keV, as a temperature \[K\].
const KELVIN_PER_KEV: f64 = JOULE_PER_KEV / BOLTZMANN_CONSTANT;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "bremsstrahlung",
    title: "X-ray spectra of a cluster of galaxies, thermal bremsstrahlung",
    summary: "Photons by their energy from the hot gas of a spherical cluster: a beta model of the \
              density, and a temperature that is lower in the core and falls outside.",
    source: "emissivity: G. B. Rybicki and A. P. Lightman 1979, Radiative Processes in \
             Astrophysics, eq. 5.14b, doi:10.1002/9783527618170; density: A. Cavaliere and R. \
             Fusco-Femiano 1976, Astron. Astrophys. 49, 137; temperature: A. Vikhlinin et al. 2006, \
             Astrophys. J. 640, 691, doi:10.1086/500288",
    length_unit: "kpc",
    image_unit: "ph cm-2 s-1 sr-1 keV-1",
    energy_unit: Some("keV"),
    parameters: &[
        ParameterDescription {
            name: "density",
            unit: "cm-3",
            default: ParameterDefault::Value(0.01),
            meaning: "density of the electrons at the centre",
            range: AcceptedRange::Between(0.0, 1e6),
        },
        ParameterDescription {
            name: "core_radius",
            unit: "kpc",
            default: ParameterDefault::Value(100.0),
            meaning: "radius of the core of the density",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "beta",
            unit: "1",
            default: ParameterDefault::Value(2.0 / 3.0),
            meaning: "how fast the density falls: as r^(-3 beta) outside the core",
            range: AcceptedRange::Between(0.0, 100.0),
        },
        ParameterDescription {
            name: "temperature",
            unit: "keV",
            default: ParameterDefault::Value(6.0),
            meaning: "k T0, of which the temperature is a fraction everywhere",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "core_fraction",
            unit: "1",
            default: ParameterDefault::Value(0.45),
            meaning: "temperature at the centre over T0; 1 is no cool core",
            range: AcceptedRange::Between(0.01, 1.0),
        },
        ParameterDescription {
            name: "cooling_radius",
            unit: "kpc",
            default: ParameterDefault::Value(45.0),
            meaning: "radius of the cool core, where the fraction is halfway to 1",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "cooling_exponent",
            unit: "1",
            default: ParameterDefault::Value(1.9),
            meaning: "how sharply the cool core ends",
            range: AcceptedRange::Between(0.1, 100.0),
        },
        ParameterDescription {
            name: "decline_radius",
            unit: "kpc",
            default: ParameterDefault::Value(600.0),
            meaning: "radius outside of which the temperature falls",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "decline_exponent",
            unit: "1",
            default: ParameterDefault::Value(0.9),
            meaning: "how fast it falls: as r^-n far outside; 0 is not at all",
            range: AcceptedRange::Between(0.0, 100.0),
        },
        ParameterDescription {
            name: "ion_charge",
            unit: "1",
            default: ParameterDefault::Value(1.14),
            meaning: "sum of Z^2 n over the ions, per electron; 1 in hydrogen alone",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "gaunt_factor",
            unit: "1",
            default: ParameterDefault::Value(1.2),
            meaning: "Gaunt factor, the same at all energies and temperatures",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription { unit: "kpc", ..CENTRE_X },
        ParameterDescription { unit: "kpc", ..CENTRE_Y },
        ParameterDescription { unit: "kpc", ..CENTRE_Z },
    ],
    jumps_move_with: &[],
    edges: nowhere,
    singular_points: nowhere,
    build: formula!(|values| Bremsstrahlung::from_values(values)),
};

/// Photons that the gas of a cluster emits as thermal bremsstrahlung, by their energy E. The
/// emissivity of Rybicki and Lightman 1979, eq. 5.14b (doi:10.1002/9783527618170),
///
/// εν = 6.8·10⁻³⁸ Σ Z² ni ne T^(−1/2) e^(−hν/kT) g erg s⁻¹ cm⁻³ Hz⁻¹, T in K,
///
/// goes into 4π sr, and has dν/dE/E = 1/(h E) times as many photons per energy:
///
/// g(r, E) = εν/(4π h E).
///
/// The density is that of Cavaliere and Fusco-Femiano 1976, ne = n0 (1 + r²/rc²)^(−3β/2). The
/// temperature is of the form of Vikhlinin et al. 2006, eqs. 4 to 6 (doi:10.1086/500288), with their
/// a = 0 and b = 2,
///
/// T = T0 (x + q)/(x + 1) (1 + r²/rt²)^(−c/2), x = (r/rcool)^acool,
///
/// and by default with the shape of their mean profile for r500 = 1 Mpc. With `core_fraction = 1` and
/// `decline_exponent = 0` the gas is isothermal.
///
/// The Gaunt factor g is a constant. 1.2 is right within some 20 % for the energy that all photons
/// carry together; the true one grows slowly below kT, and is less than 1 far above.
/// There are no lines, no absorption and no redshift: energies are those at the cluster.
///
/// As an [`Emission`](emitree::Emission) it gives photons cm⁻² s⁻¹ sr⁻¹ keV⁻¹ per kpc, with energies in keV: an image
/// over kpc is in photons cm⁻² s⁻¹ sr⁻¹ keV⁻¹. For an energy that is not more than 0, or without
/// one, it is not a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bremsstrahlung<T = f64> {
    /// n0² Σ Z² ni/ne g times all constants \[cm⁻² s⁻¹ sr⁻¹ kpc⁻¹ keV^(1/2)\]
    scale: T,
    core_radius: T,
    beta: T,
    temperature_kev: T,
    core_fraction: T,
    cooling_radius: T,
    cooling_exponent: T,
    decline_radius: T,
    decline_exponent: T,
    centre: [T; 3],
}

impl Bremsstrahlung {
    /// The cluster with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range.
    ///
    /// ```
    /// use emitree_models::models::Bremsstrahlung;
    /// use std::collections::BTreeMap;
    ///
    /// let cluster = Bremsstrahlung::new(&BTreeMap::from([("temperature".to_owned(), 4.0)]))?;
    /// let (centre, outside) = ([0.0; 3], [0.0, 100.0, 0.0]);
    /// assert!((cluster.temperature_kev(centre) - 0.45 * 4.0).abs() < 1e-14);
    /// // Where the gas is hotter, the spectrum is harder.
    /// let hardness = |position| cluster.rate(position, 6.0) / cluster.rate(position, 1.0);
    /// assert!(hardness(outside) > 2.0 * hardness(centre));
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    /// k T \[keV\] at a position \[kpc\].
    pub fn temperature_kev(&self, position: [f64; 3]) -> f64 {
        let mut temperature = [0.0];
        self.temperatures_kev(&[distance(position, self.centre)], &mut temperature);
        temperature[0]
    }

    /// The rate g \[cm⁻² s⁻¹ sr⁻¹ keV⁻¹ kpc⁻¹\] at a position \[kpc\] and an energy \[keV\]; NaN
    /// for an energy that is not more than 0.
    pub fn rate(&self, position: [f64; 3], energy_kev: f64) -> f64 {
        let mut rates = [0.0];
        self.fill_block(&[position], &[energy_kev], &mut rates);
        rates[0]
    }
}

impl<T: Scalar> Bremsstrahlung<T> {
    fn from_values(values: &Values<T>) -> Self {
        let density_cm3 = values.of("density");
        let emissivity = values.of("ion_charge") * FREE_FREE * values.of("gaunt_factor")
            / KELVIN_PER_KEV.sqrt()
            * density_cm3
            * density_cm3;
        Self {
            scale: emissivity / (4.0 * PI * PLANCK_CONSTANT_ERG_S) * KILOPARSEC_CM,
            core_radius: values.of("core_radius"),
            beta: values.of("beta"),
            temperature_kev: values.of("temperature"),
            core_fraction: values.of("core_fraction"),
            cooling_radius: values.of("cooling_radius"),
            cooling_exponent: values.of("cooling_exponent"),
            decline_radius: values.of("decline_radius"),
            decline_exponent: values.of("decline_exponent"),
            centre: centre(values),
        }
    }

    /// k T at a block of distances.
    fn temperatures_kev(&self, distances: &[T], temperatures: &mut [T]) {
        let mut declines = [T::of(0.0); BLOCK];
        let declines = &mut declines[..distances.len()];
        steps(distances, self.decline_radius, declines);
        T::raise_all(declines, self.decline_exponent * -0.5);
        for (x, r) in temperatures.iter_mut().zip(distances) {
            *x = *r / self.cooling_radius;
        }
        T::raise_all(temperatures, self.cooling_exponent);
        for (x, decline) in temperatures.iter_mut().zip(&*declines) {
            // (x + q)/(x + 1), but for x without bounds.
            let one = T::of(1.0);
            let cool = one - (one - self.core_fraction) / (one + *x);
            *x = self.temperature_kev * cool * *decline;
        }
    }

    fn fill_block(&self, positions: &[[f64; 3]], energies_kev: &[f64], rates: &mut [T]) {
        let mut scratch = [[T::of(0.0); BLOCK]; 3];
        let [densities2, temperatures, thermals] =
            scratch.each_mut().map(|numbers| &mut numbers[..positions.len()]);
        distances(positions, self.centre, rates);
        self.temperatures_kev(rates, temperatures);
        steps(rates, self.core_radius, densities2);
        T::raise_all(densities2, self.beta * -3.0);
        for i in 0..positions.len() {
            thermals[i] = T::of(-energies_kev[i]) / temperatures[i];
        }
        T::apply(Elementary::Exp, thermals);
        for (i, rate) in rates.iter_mut().enumerate() {
            let (energy_kev, thermal) = (energies_kev[i], thermals[i]);
            let weighted = self.scale * densities2[i] * thermal;
            *rate = if energy_kev.is_nan() || energy_kev <= 0.0 {
                T::of(f64::NAN)
            } else if thermal.value() <= 0.0 {
                // As cold as that, T^(−1/2) may not be a number.
                T::of(0.0)
            } else {
                weighted / (temperatures[i].sqrt() * energy_kev)
            };
        }
    }
}

/// 1 + (r/r₀)²
fn steps<T: Scalar>(distances: &[T], radius: T, steps: &mut [T]) {
    for (step, r) in steps.iter_mut().zip(distances) {
        let in_radii = *r / radius;
        *step = T::of(1.0) + in_radii * in_radii;
    }
}

impl<T: Scalar> Formula<T> for Bremsstrahlung<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        let nowhere = [f64::NAN; BLOCK];
        let mut energies = samples.energies().chunks(BLOCK);
        let blocks = samples.positions().chunks(BLOCK).zip(rates.chunks_mut(BLOCK));
        for (positions, rates) in blocks {
            let energies = energies.next().unwrap_or(&nowhere[..positions.len()]);
            self.fill_block(positions, energies, rates);
        }
    }
}

emission_of_formula!(Bremsstrahlung);

#[cfg(test)]
mod tests {
    use super::*;

    fn cluster<const N: usize>(given: [(&str, f64); N]) -> Bremsstrahlung {
        let parameters = given.map(|(name, value)| (name.to_owned(), value));
        Bremsstrahlung::new(&BTreeMap::from(parameters)).unwrap()
    }

    #[test]
    fn all_photons_carry_the_published_power() {
        // Rybicki and Lightman 1979, eq. 5.15b: 1.4e-27 T^(1/2) ne ni Z² g erg s^-1 cm^-3, into all
        // directions. Int E e^(−E/kT)/E dE by the midpoint rule in t of E = kT t²/(1 − t²).
        let given = [("core_fraction", 1.0), ("decline_exponent", 0.0), ("density", 1.0)];
        let gas = cluster(given);
        let steps = 20_000_u32;
        let kev: f64 = (0..steps)
            .map(|step| {
                let t = (f64::from(step) + 0.5) / f64::from(steps);
                let rest = 1.0 - t * t;
                let energy = 6.0 * t * t / rest;
                let width = 12.0 * t / (rest * rest) / f64::from(steps);
                gas.rate([0.0; 3], energy) * energy * width
            })
            .sum();
        let erg = kev * JOULE_PER_KEV * 1e7 * 4.0 * PI / KILOPARSEC_CM;
        let published = 1.4e-27 * (6.0 * KELVIN_PER_KEV).sqrt() * 1.14 * 1.2;
        // Both constants have two digits.
        assert!((erg / published - 1.0).abs() < 0.02, "{erg:e}, {published:e}");
        // And ours, integrated without approximations: 6.8e-38 T^(1/2) k/h.
        let kt_over_h = 6.0 * JOULE_PER_KEV * 1e7 / PLANCK_CONSTANT_ERG_S;
        let exact = FREE_FREE / (6.0 * KELVIN_PER_KEV).sqrt() * kt_over_h * 1.14 * 1.2;
        assert!((erg / exact - 1.0).abs() < 1e-6, "{erg:e}, {exact:e}");
    }

    #[test]
    fn an_isothermal_cluster_has_one_spectrum() {
        let gas = cluster([("core_fraction", 1.0), ("decline_exponent", 0.0), ("beta", 0.5)]);
        for energy in [0.1, 1.0, 30.0] {
            let ratio = gas.rate([100.0, 0.0, 0.0], energy) / gas.rate([0.0; 3], energy);
            assert!((ratio - 2.0_f64.powf(-1.5)).abs() < 1e-15, "{energy}");
        }
    }

    #[test]
    fn the_temperature_is_that_of_its_parts() {
        let gas = cluster([("cooling_radius", 30.0), ("decline_radius", 3e4)]);
        assert!((gas.temperature_kev([0.0, 0.0, 30.0]) / (6.0 * 0.725) - 1.0).abs() < 1e-6);
        let far = gas.temperature_kev([3e9, 0.0, 0.0]) / (6.0 * 1e5_f64.powf(-0.9));
        assert!((far - 1.0).abs() < 1e-9);
    }

    #[test]
    fn gas_as_cold_as_can_be_is_dark() {
        let gas = cluster([("decline_exponent", 100.0)]);
        assert!(gas.temperature_kev([1e9, 0.0, 0.0]) <= 0.0);
        assert!(gas.rate([1e9, 0.0, 0.0], 1.0) <= 0.0 && gas.rate([1e200, 0.0, 0.0], 1.0) <= 0.0);
    }

    #[test]
    fn there_are_no_photons_without_energy() {
        let gas = cluster([]);
        assert!([0.0, -1.0, f64::NAN].iter().all(|&energy| gas.rate([0.0; 3], energy).is_nan()));
    }
}
