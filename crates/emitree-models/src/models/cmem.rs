//! Soft X-rays of the magnetosheath with cusps: CMEM, after Wharton et al. 2025.

use super::fill_rates;
use super::lin::LinMagnetopause;
use super::magnetosheath::{
    ALPHA_PARAMETER, BETA_PARAMETER, IMAGE_UNIT, RATE_PER_EMISSIVITY, SheathFalloff, wind_falloff,
};
use super::shue::Shue;
use super::solar_wind::{BX, BY, BZ, DENSITY, DIPOLE_TILT, SolarWind, VELOCITY};
use super::sun_angles::SunAngles;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::derived;
use crate::catalogue::parameter::{
    AcceptedRange, Derivation, ParameterDefault, ParameterDescription, Values,
};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "cmem",
    title: "Magnetosheath soft X-rays with cusps, CMEM (Wharton et al. 2025)",
    summary: "Solar-wind charge exchange between the magnetopause of Lin et al. 2010 with its \
              cusps and a bow shock of Shue's form; no emission inside the magnetopause.",
    source: "Wharton et al. 2025 (CMEM); magnetopause: Lin et al. 2010, doi:10.1029/2009JA014235",
    length_unit: "R_E",
    image_unit: IMAGE_UNIT,
    energy_unit: None,
    parameters: &[
        DENSITY,
        VELOCITY,
        BX,
        BY,
        BZ,
        DIPOLE_TILT,
        ParameterDescription {
            name: "p0",
            unit: "1",
            default: ParameterDefault::Derived(Derivation {
                formula: "0.0022 density + 0.7753",
                value: derived!(|values| values.of("density") * 0.0022 + 0.7753),
            }),
            meaning: "scale of the magnetopause's nose distance",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "p1",
            unit: "1",
            default: ParameterDefault::Value(1.0),
            meaning: "scale of the magnetopause's flaring",
            range: AcceptedRange::Between(0.0, 10.0),
        },
        ParameterDescription {
            name: "p2",
            unit: "1",
            default: ParameterDefault::Value(3.0),
            meaning: "scale of the depth of the cusps",
            range: AcceptedRange::Between(0.0, 100.0),
        },
        ParameterDescription {
            name: "p3",
            unit: "1",
            default: ParameterDefault::Value(4.0),
            meaning: "how fast the cusps end away from their axes",
            range: AcceptedRange::Between(0.0, 100.0),
        },
        ParameterDescription {
            name: "bow_shock_r0",
            unit: "R_E",
            default: ParameterDefault::Derived(Derivation {
                formula: "13.24 - 0.12 density",
                value: derived!(|values| values.of("density") * -0.12 + 13.24),
            }),
            meaning: "distance of the bow shock's nose",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "bow_shock_ay",
            unit: "1",
            default: ParameterDefault::Derived(BOW_SHOCK_FLARING),
            meaning: "flaring of the bow shock across z",
            range: AcceptedRange::Between(0.0, 10.0),
        },
        ParameterDescription {
            name: "bow_shock_az",
            unit: "1",
            default: ParameterDefault::Derived(BOW_SHOCK_FLARING),
            meaning: "flaring of the bow shock along z",
            range: AcceptedRange::Between(0.0, 10.0),
        },
        ParameterDescription {
            name: "A1",
            unit: "eV cm-3 s-1",
            default: ParameterDefault::Derived(Derivation {
                formula: "2.7e-6 density - 6.3e-6",
                value: derived!(|values| values.of("density") * 2.7e-6 - 6.3e-6),
            }),
            meaning: "emissivity of the sheath at 10 R_E towards the Sun",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "A2",
            unit: "eV cm-3 s-1",
            default: ParameterDefault::Derived(Derivation {
                formula: "9e-7 density - 1e-6",
                value: derived!(|values| values.of("density") * 9e-7 - 1e-6),
            }),
            meaning: "emissivity of the solar wind at 10 R_E",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "B",
            unit: "1",
            default: ParameterDefault::Value(2.0),
            meaning: "how fast the sheath fades towards the tail",
            range: AcceptedRange::Between(-20.0, 100.0),
        },
        ALPHA_PARAMETER,
        BETA_PARAMETER,
    ],
    // All that the magnetopause and the bow shock depend on.
    jumps_move_with: &[
        DENSITY.name,
        VELOCITY.name,
        BX.name,
        BY.name,
        BZ.name,
        DIPOLE_TILT.name,
        "p0",
        "p1",
        "p2",
        "p3",
        "bow_shock_r0",
        "bow_shock_ay",
        "bow_shock_az",
    ],
    edges: nowhere,
    singular_points: nowhere,
    build: formula!(|values| Cmem::from_values(values)),
};

const BOW_SHOCK_FLARING: Derivation = Derivation {
    formula: "(0.58 - 0.010 bz)(1 + 0.010 Pd) + 0.2, Pd = 0.5 m_p density velocity^2 [nPa]",
    value: derived!(|values| SolarWind::new(values).flaring() + 0.2),
};

/// The soft X-ray emission of the magnetosheath and its cusps: CMEM of Wharton et al. 2025.
///
/// Nothing inside the magnetopause, which is that of Lin et al. 2010 (doi:10.1029/2009JA014235)
/// scaled with p0 to p3; A1 exp(−B (θ/2)⁴)(r/10)^−(α + β sin² θ) up to a bow shock of Shue's form;
/// A2 (r/10)⁻³ beyond. θ is the angle from +x (to the Sun), r is in `R_E`.
///
/// With the published p2 and p3 the cusps are deep enough to reach the Earth along their axes,
/// where the emissivity then grows without bounds as r → 0: a scene with the Earth in view needs an
/// occulter there.
///
/// As an [`Emission`](emitree::Emission) it gives keV cm⁻² s⁻¹ sr⁻¹ per `R_E`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cmem<T = f64> {
    magnetopause: LinMagnetopause,
    bow_shock: Shue,
    sheath: T,
    fading: T,
    falloff: SheathFalloff<T>,
    wind: T,
}

impl Cmem {
    /// The model with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range. At densities below
    /// 7/3 cm⁻³ the derived A1 is negative: give A1 (and A2) there.
    ///
    /// ```
    /// use emitree_models::models::Cmem;
    /// use std::collections::BTreeMap;
    ///
    /// let model = Cmem::new(&BTreeMap::from([("density".to_owned(), 5.0)]))?;
    /// // At the nose, half way between magnetopause and bow shock.
    /// let emissivity = model.emissivity([11.5, 0.0, 0.0]);
    /// assert!((emissivity - 7.2e-6 * 1.15_f64.powf(-2.5)).abs() < 1e-18);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    /// The emissivity \[eV cm⁻³ s⁻¹\] at a position \[`R_E`\]; 0 at the origin.
    pub fn emissivity(&self, position: [f64; 3]) -> f64 {
        self.at(position)
    }
}

impl<T: Scalar> Cmem<T> {
    fn from_values(values: &Values<T>) -> Self {
        // Surfaces decide where a point is, and have no part in the rate there.
        let surfaces = values.plain();
        let scales = ["p0", "p1", "p2", "p3"].map(|name| surfaces.of(name));
        let [r0, ay, az] =
            ["bow_shock_r0", "bow_shock_ay", "bow_shock_az"].map(|name| surfaces.of(name));
        Self {
            magnetopause: LinMagnetopause::new(&SolarWind::new(&surfaces), scales),
            bow_shock: Shue::new(r0, ay, az),
            sheath: values.of("A1"),
            fading: values.of("B"),
            falloff: SheathFalloff { alpha: values.of("alpha"), beta: values.of("beta") },
            wind: values.of("A2"),
        }
    }

    /// The emissivity at a position.
    fn at(&self, position: [f64; 3]) -> T {
        let Some(at) = SunAngles::new(position) else {
            return T::of(0.0);
        };
        let theta = at.theta();
        if self.magnetopause.contains(&at, theta) {
            T::of(0.0)
        } else if self.bow_shock.contains(&at) {
            let fading = (-self.fading * (0.5 * theta).powi(4)).exp();
            self.sheath * fading * self.falloff.at(&at)
        } else {
            self.wind * wind_falloff(&at)
        }
    }
}

impl<T: Scalar> Formula<T> for Cmem<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_rates(samples, rates, |position| self.at(position) * RATE_PER_EMISSIVITY);
    }
}

emission_of_formula!(Cmem);
