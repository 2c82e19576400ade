//! What the magnetosheath models have in common: falloffs of the emissivity, and its unit.

use super::constants::EARTH_RADIUS_CM;
use super::sun_angles::SunAngles;
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription};
use crate::scalar::Scalar;
use core::f64::consts::PI;

/// Directional rate \[keV cm⁻² s⁻¹ sr⁻¹ per `R_E`\] of an emissivity of 1 eV cm⁻³ s⁻¹: one `R_E` is
/// 6.371·10⁸ cm, the emission goes into 4π sr, and a keV has 1000 eV.
pub(super) const RATE_PER_EMISSIVITY: f64 = EARTH_RADIUS_CM / (4.0 * PI) / 1000.0;

/// The unit of images over `R_E` of [`RATE_PER_EMISSIVITY`], in the grammar of FITS.
pub(super) const IMAGE_UNIT: &str = "keV cm-2 s-1 sr-1";

/// The distance at which the coefficients A are the emissivity \[`R_E`\].
const REFERENCE_DISTANCE: f64 = 10.0;

const ALPHA: f64 = 2.5;
const BETA: f64 = -1.6;

pub(super) const ALPHA_PARAMETER: ParameterDescription = ParameterDescription {
    name: "alpha",
    unit: "1",
    default: ParameterDefault::Value(ALPHA),
    meaning: "falloff of the sheath's emissivity with distance at the nose",
    range: AcceptedRange::Between(-20.0, 20.0),
};
pub(super) const BETA_PARAMETER: ParameterDescription = ParameterDescription {
    name: "beta",
    default: ParameterDefault::Value(BETA),
    meaning: "what the falloff gains at the flanks, as sin^2 theta",
    ..ALPHA_PARAMETER
};

/// (r/10)^−(α + β sin² θ) in the sheath.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SheathFalloff<T = f64> {
    pub(super) alpha: T,
    pub(super) beta: T,
}

impl<T: Scalar> SheathFalloff<T> {
    pub(super) fn at(&self, at: &SunAngles) -> T {
        let slope = self.alpha + self.beta * at.sin_theta * at.sin_theta;
        T::of(at.r / REFERENCE_DISTANCE).powf(-slope)
    }
}

/// (r/10)⁻³ in the solar wind beyond the bow shock.
pub(super) fn wind_falloff(at: &SunAngles) -> f64 {
    (REFERENCE_DISTANCE / at.r).powi(3)
}
