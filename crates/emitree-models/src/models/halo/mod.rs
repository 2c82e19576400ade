//! Halos of dark matter: their density, and the radiation of its annihilation or decay.

mod burkert;
mod einasto;
mod nfw;
mod parameters;
mod profile;

pub(crate) use burkert::{BURKERT, BURKERT_DECAY};
pub(crate) use einasto::{EINASTO, EINASTO_DECAY};
pub(crate) use nfw::{NFW, NFW_DECAY};

use super::constants::KILOPARSEC_CM;
use super::radial::{centre, distance};
use super::{fill_radial_rates, one, scale};
use crate::catalogue::edges::{SphericalEdge, spheres};
use crate::catalogue::model::Formula;
use crate::catalogue::parameter::Values;
use crate::catalogue::singular::SingularPoint;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use parameters::OUTER_RADIUS;
use profile::Profile;
use std::collections::BTreeMap;

/// What radiates: pairs of particles, or each by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Process {
    /// g = ρ²; images are J-factors.
    Annihilation,
    /// g = ρ; images are D-factors.
    Decay,
}

impl Process {
    /// p of g = ρᵖ.
    fn power(self) -> i32 {
        match self {
            Self::Annihilation => 2,
            Self::Decay => 1,
        }
    }
}

/// A spherical halo of dark matter: g = ρ² or g = ρ, with the density
///
/// ρ = `local_density` · f(s/`scale_radius`)/f(`local_radius`/`scale_radius`),
///
/// s = √(r² + `core_radius`²), r the distance from a centre, and f one of
///
/// * NFW (Navarro, Frenk and White 1997): f = 1/\[x (1 + x)²\];
/// * Einasto: f = exp\[−(2/α)(x^α − 1)\], as Navarro et al. 2004 write it;
/// * Burkert 1995: f = 1/\[(1 + x)(1 + x²)\].
///
/// ρ is 0 for r more than `outer_radius`. The local density is that of the halo without the core, so
/// that halos with different cores are the same far from the centre.
///
/// # Units
///
/// Lengths are in kpc and ρ in GeV cm⁻³. As an [`Emission`](emitree::Emission) a halo gives GeV² cm⁻⁵ sr⁻¹ or
/// GeV cm⁻² sr⁻¹ for each kpc of 3.0857·10²¹ cm: an image is dJ/dΩ = ∫ ρ² ds or dD/dΩ = ∫ ρ ds, and
/// times the solid angle of a pixel (irradiance) its J-factor \[GeV² cm⁻⁵\] or D-factor
/// \[GeV cm⁻²\]. A factor 1/(4π) belongs to the flux of the particle, and not to these.
///
/// # The centre
///
/// ρ² of NFW grows as r⁻² without a core: the radiance of a line of sight is finite except through the
/// centre itself, and that of every pixel is finite. The rate is infinite at r = 0, and as well where r²
/// is below the smallest number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halo<T = f64> {
    profile: Profile<T>,
    process: Process,
    /// The rate per kpc where f is 1.
    scale: T,
    scale_radius: T,
    core_radius: T,
    outer_radius: T,
    centre: [T; 3],
}

impl Halo {
    /// The halo of Navarro, Frenk and White with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range, or a scale radius for which
    /// the density is no number.
    ///
    /// ```
    /// use emitree_models::models::{Halo, Process};
    /// use std::collections::BTreeMap;
    ///
    /// let halo = Halo::nfw(Process::Annihilation, &BTreeMap::new())?;
    /// let sun = halo.density_gev_cm3([0.0, 8.33, 0.0]);
    /// assert!((sun - 0.3).abs() < 1e-15);
    /// // A cusp: ten times as dense at a tenth of the distance, close to the centre.
    /// let [near, nearer] = [1e-6, 1e-7].map(|r| halo.density_gev_cm3([r, 0.0, 0.0]));
    /// assert!((nearer / near - 10.0).abs() < 1e-5);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn nfw(process: Process, parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        let description = match process {
            Process::Annihilation => &NFW,
            Process::Decay => &NFW_DECAY,
        };
        Self::from_values(description, Profile::Nfw, process, &description.values(parameters)?)
    }

    /// The halo of Einasto's profile, as [`nfw`](Self::nfw).
    ///
    /// # Errors
    ///
    /// As for [`nfw`](Self::nfw).
    ///
    /// ```
    /// use emitree_models::models::{Halo, Process};
    /// use std::collections::BTreeMap;
    ///
    /// let halo = Halo::einasto(Process::Decay, &BTreeMap::new())?;
    /// assert!(halo.density_gev_cm3([0.0; 3]).is_finite());
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn einasto(
        process: Process,
        parameters: &BTreeMap<String, f64>,
    ) -> Result<Self, ModelError> {
        let description = match process {
            Process::Annihilation => &EINASTO,
            Process::Decay => &EINASTO_DECAY,
        };
        let values = description.values(parameters)?;
        let profile = Profile::Einasto { alpha: values.of("alpha") };
        Self::from_values(description, profile, process, &values)
    }

    /// The halo of Burkert's profile, as [`nfw`](Self::nfw).
    ///
    /// # Errors
    ///
    /// As for [`nfw`](Self::nfw).
    ///
    /// ```
    /// use emitree_models::models::{Halo, Process};
    /// use std::collections::BTreeMap;
    ///
    /// let halo = Halo::burkert(Process::Decay, &BTreeMap::new())?;
    /// let [centre, beside] = [0.0, 0.1].map(|r| halo.density_gev_cm3([r, 0.0, 0.0]));
    /// assert!(centre > beside && centre < 1.01 * beside); // no cusp
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn burkert(
        process: Process,
        parameters: &BTreeMap<String, f64>,
    ) -> Result<Self, ModelError> {
        let description = match process {
            Process::Annihilation => &BURKERT,
            Process::Decay => &BURKERT_DECAY,
        };
        Self::from_values(description, Profile::Burkert, process, &description.values(parameters)?)
    }

    /// The rate g at a position \[kpc\]: ρ² \[GeV² cm⁻⁶\] or ρ \[GeV cm⁻³\] times the
    /// centimetres of a kpc.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let distance = distance(position, self.centre);
        if distance > self.outer_radius { 0.0 } else { one(distance, |r| self.at(r)) }
    }

    /// ρ \[GeV cm⁻³\] at a position \[kpc\].
    pub fn density_gev_cm3(&self, position: [f64; 3]) -> f64 {
        let emitted = self.rate(position) / KILOPARSEC_CM;
        match self.process {
            Process::Annihilation => emitted.sqrt(),
            Process::Decay => emitted,
        }
    }
}

impl<T: Scalar> Halo<T> {
    fn from_values(
        description: &ModelDescription,
        profile: Profile<T>,
        process: Process,
        values: &Values<T>,
    ) -> Result<Self, ModelError> {
        let scale_radius = values.of("scale_radius");
        let local = values.of("local_density").powi(process.power()) * KILOPARSEC_CM;
        let mut halo = Self {
            profile,
            process,
            scale: T::of(1.0),
            scale_radius,
            core_radius: values.of("core_radius"),
            outer_radius: values.of("outer_radius"),
            centre: centre(values),
        };
        let at_local = Self { core_radius: T::of(0.0), ..halo }.relative(values.of("local_radius"));
        halo.scale = local / at_local;
        // Profiles fall with the distance: what is finite close to the centre is finite everywhere.
        let highest = halo.scale * halo.relative(scale_radius * profile.least_x());
        let [local, scale, highest] = [at_local, halo.scale, highest].map(T::value);
        if !(local > 0.0 && scale.is_finite() && highest.is_finite()) {
            let expected = "such that the densities at local_radius and at the centre are numbers";
            let name = "scale_radius";
            return Err(description.out_of_range(name, scale_radius.value(), expected.to_owned()));
        }
        Ok(halo)
    }

    /// fᵖ at a distance from the centre.
    fn relative(&self, distance: T) -> T {
        one(distance, |distances| self.fill_relative(distances))
    }

    /// Turns distances into fᵖ.
    fn fill_relative(&self, distances: &mut [T]) {
        let core_squared = self.core_radius * self.core_radius;
        for distance in &mut *distances {
            let softened = if self.core_radius.value() > 0.0 {
                (*distance * *distance + core_squared).sqrt()
            } else {
                *distance
            };
            *distance = softened / self.scale_radius;
        }
        self.profile.fill(distances, self.process.power());
    }

    /// Turns distances into rates.
    fn at(&self, distances: &mut [T]) {
        self.fill_relative(distances);
        scale(distances, self.scale);
    }
}

impl<T: Scalar> Formula<T> for Halo<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        let range = [T::of(0.0), self.outer_radius];
        fill_radial_rates(samples, rates, self.centre, range, |distances| self.at(distances));
    }
}

emission_of_formula!(Halo);

/// Where a halo ends.
fn outer_sphere(values: &Values) -> Vec<SphericalEdge> {
    spheres(centre(values), [values.of(OUTER_RADIUS.name)])
}

/// The centre of a halo, with the power of its rate there if it has one.
fn cusp(values: &Values, exponent: Option<f64>) -> Vec<SingularPoint> {
    vec![SingularPoint::new(centre(values), exponent)]
}

#[cfg(test)]
mod tests;
