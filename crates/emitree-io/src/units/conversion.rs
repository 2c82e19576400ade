//! What an image needs on top of conversion: units of line-of-sight integrals, radiances of
//! isotropic emission, photons and energies.

use super::magnitude::Magnitude;
use super::unit::{Factor, Unit};
use super::{Dimension, UnitError};
use core::f64::consts::FRAC_1_PI;

/// The unit of the image of an emission rate in `rate`, where lengths are in `length`, and the
/// factor to values in it: the rate's unit times a length.
///
/// The length is taken in the unit of length that the rate itself has, so that cm⁻³ s⁻¹ over Earth
/// radii is an image in cm⁻² s⁻¹ and a factor of 6.371·10⁸. What FITS can't write is converted as
/// by [`Unit::fits`].
///
/// # Errors
///
/// [`UnitError::NotALength`] if `length` is none.
///
/// ```
/// use emitree_io::units::{Unit, image_unit};
///
/// let (unit, factor) = image_unit(&Unit::parse("cm-3 s-1 sr-1")?, &Unit::parse("R_E")?)?;
/// assert_eq!((unit.to_string().as_str(), factor), ("cm-2 s-1 sr-1", 6.371e8));
/// // Rayleighs for each kilometre along the line of sight add up to rayleighs.
/// let (unit, factor) = image_unit(&Unit::parse("R/km")?, &Unit::parse("m")?)?;
/// assert_eq!((unit.to_string().as_str(), factor), ("R", 1e-3));
/// # Ok::<(), emitree_io::units::UnitError>(())
/// ```
pub fn image_unit(rate: &Unit, length: &Unit) -> Result<(Unit, f64), UnitError> {
    if length.dimension() != Dimension::LENGTH {
        let (unit, dimension) = (length.to_string(), length.dimension());
        return Err(UnitError::NotALength { unit, dimension });
    }
    integrated(rate, length)
}

/// The unit of a spectral quantity in `density`, integrated over energies in `energy`, and the factor
/// to values in it.
///
/// As [`image_unit`] does with lengths, it takes the energy in the unit of energy that the density is
/// per: photons for each keV, summed over energies in eV, are photons, and a factor of 10⁻³.
///
/// # Errors
///
/// [`UnitError::NotAnEnergy`] if `energy` is none.
///
/// ```
/// use emitree_io::units::{Unit, band_unit};
///
/// let density = Unit::parse("ph cm-2 s-1 sr-1 keV-1")?;
/// let (unit, factor) = band_unit(&density, &Unit::parse("eV")?)?;
/// assert_eq!((unit.to_string().as_str(), factor), ("ph cm-2 s-1 sr-1", 1e-3));
/// // What is per no energy gets one.
/// let (unit, _) = band_unit(&Unit::parse("cm-2 s-1 sr-1")?, &Unit::parse("keV")?)?;
/// assert_eq!(unit.to_string(), "cm-2 s-1 sr-1 keV");
/// # Ok::<(), emitree_io::units::UnitError>(())
/// ```
pub fn band_unit(density: &Unit, energy: &Unit) -> Result<(Unit, f64), UnitError> {
    if energy.dimension() != Dimension::ENERGY {
        let (unit, dimension) = (energy.to_string(), energy.dimension());
        return Err(UnitError::NotAnEnergy { unit, dimension });
    }
    integrated(density, energy)
}

/// The unit of an integral of values in `density` over `path`, and the factor to values in it.
fn integrated(density: &Unit, path: &Unit) -> Result<(Unit, f64), UnitError> {
    // What the density is per is what the path belongs to: its most negative power of such a unit.
    let per = density
        .factors()
        .iter()
        .filter(|factor| factor.known.dimension == path.dimension() && factor.exponent < 0)
        .min_by_key(|factor| factor.exponent);
    let (path, factor) = match per {
        Some(factor) => {
            let along = Unit::named(Factor { exponent: 1, ..*factor });
            let factor = path.factor_to(&along)?;
            (along, factor)
        }
        None => (path.clone(), 1.0),
    };
    let (unit, rest) = density.times(&path).in_fits();
    Ok((unit, factor * rest))
}

impl Unit {
    /// The factor from this unit to the unit of an image: as
    /// [`factor_to`](Self::factor_to), with two more meanings.
    ///
    /// * From a unit that is not per solid angle to one that is, the value becomes the radiance of an
    ///   isotropic emission: 1/(4π) sr⁻¹. So a column emission rate of 10⁶ photons cm⁻² s⁻¹ is one
    ///   rayleigh, as by definition.
    /// * From a unit without photons to one with photons, pure numbers are numbers of particles.
    ///
    /// # Errors
    ///
    /// As for [`factor_to`](Self::factor_to).
    ///
    /// ```
    /// use emitree_io::units::Unit;
    ///
    /// let rayleigh = Unit::parse("R")?;
    /// for text in ["ph cm-2 s-1", "cm-2 s-1"] {
    ///     assert_eq!(Unit::parse(text)?.factor_to_image(&rayleigh)?, 1e-6);
    /// }
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    pub fn factor_to_image(&self, to: &Self) -> Result<f64, UnitError> {
        let (missing, isotropic) = self.missing(to);
        if missing != Dimension::NONE && missing != Dimension::PHOTON {
            return Err(self.incompatible(
                to,
                "units of the same dimension; those of `to` may also be per solid angle, or of \
                 photons, where the others are not",
            ));
        }
        self.finite_factor(to, self.magnitude().times(isotropic).over(to.magnitude()))
    }

    /// The factor as by [`factor_to_image`](Self::factor_to_image) where, besides, photons of
    /// `photon_energy_j` \[J\] may become energy or energy photons.
    ///
    /// # Errors
    ///
    /// As for [`factor_to`](Self::factor_to), and [`UnitError::PhotonEnergy`] if that energy is not
    /// positive and finite.
    ///
    /// ```
    /// use emitree_io::units::Unit;
    ///
    /// let [photons, energies] = [Unit::parse("ph cm-2 s-1")?, Unit::parse("eV cm-2 s-1")?];
    /// let photon_energy_j = 10.2 * Unit::parse("eV")?.factor_to(&Unit::parse("J")?)?;
    /// let factor = photons.factor_with_photon_energy(&energies, photon_energy_j)?;
    /// assert!((factor - 10.2).abs() < 1e-14);
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    pub fn factor_with_photon_energy(
        &self,
        to: &Self,
        photon_energy_j: f64,
    ) -> Result<f64, UnitError> {
        if !(photon_energy_j > 0.0 && photon_energy_j.is_finite()) {
            return Err(UnitError::PhotonEnergy(photon_energy_j));
        }
        let (missing, isotropic) = self.missing(to);
        let energy = Magnitude::new(photon_energy_j, 0);
        let ratio = self.magnitude().times(isotropic).over(to.magnitude());
        let per_photon = Dimension::ENERGY.over(Dimension::PHOTON);
        let ratio = if missing == per_photon || missing == Dimension::ENERGY {
            ratio.times(energy)
        } else if Dimension::NONE.over(missing) == per_photon
            || Dimension::NONE.over(missing) == Dimension::ENERGY
        {
            ratio.over(energy)
        } else if missing == Dimension::NONE || missing == Dimension::PHOTON {
            ratio
        } else {
            return Err(self.incompatible(
                to,
                "units that differ at most by photons or their energy, and by a solid angle",
            ));
        };
        self.finite_factor(to, ratio)
    }

    /// What `to` measures beyond this unit once this is a radiance where `to` is one, and the factor
    /// that makes it one.
    fn missing(&self, to: &Self) -> (Dimension, Magnitude) {
        let missing = to.dimension().over(self.dimension());
        let per_solid_angle = Dimension::NONE.over(Dimension::SOLID_ANGLE);
        if self.dimension().angle == 0 && to.dimension().angle == per_solid_angle.angle {
            let sphere = Magnitude::new(0.25 * FRAC_1_PI, 0);
            return (missing.over(per_solid_angle), sphere);
        }
        (missing, Magnitude::ONE)
    }
}
