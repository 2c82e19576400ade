//! Constants of nature and of the Earth and the Sun that several models share.
//!
//! CODATA 2022 (doi:10.1103/RevModPhys.97.025002), but for what is exact in the SI and where
//! another source is named.

/// k \[J K⁻¹\], exact.
pub(super) const BOLTZMANN_CONSTANT: f64 = 1.380_649e-23;

/// e \[C\], exact: one eV in J.
const ELEMENTARY_CHARGE: f64 = 1.602_176_634e-19;

/// One keV \[J\], exact.
pub(super) const JOULE_PER_KEV: f64 = 1e3 * ELEMENTARY_CHARGE;

/// h \[erg s\], exact.
pub(super) const PLANCK_CONSTANT_ERG_S: f64 = 6.626_070_15e-27;

/// G \[m³ kg⁻¹ s⁻²\]
pub(super) const GRAVITATIONAL_CONSTANT: f64 = 6.674_30e-11;

/// Mass of the proton \[kg\].
pub(super) const PROTON_MASS_KG: f64 = 1.672_621_925_95e-27;

/// The Thomson cross section \[cm²\].
pub(super) const THOMSON_CROSS_SECTION_CM2: f64 = 6.652_458_705_1e-25;

/// One `R_E` \[cm\]: the Earth's mean radius, to the digits that the magnetosheath models use.
pub(super) const EARTH_RADIUS_CM: f64 = 6.371e8;

/// One `R_sun` \[cm\]: the nominal solar radius of IAU 2015 resolution B3.
pub(super) const SOLAR_RADIUS_CM: f64 = 6.957e10;

/// One kpc \[cm\], exact: 10³ · 648 000/π astronomical units (IAU 2015 resolution B2) of
/// 149 597 870 700 m (IAU 2012 resolution B2).
pub(super) const KILOPARSEC_CM: f64 = 3.085_677_581_491_367_3e21;

/// Volume emission rates \[cm⁻³ s⁻¹\] along one cm, in rayleigh: 1 R is a column emission rate of
/// 10⁶ photons cm⁻² s⁻¹ (Hunten, Roach and Chamberlain 1956, doi:10.1016/0021-9169(56)90111-8).
pub(super) const RAYLEIGH_PER_COLUMN_CM2: f64 = 1e-6;
