//! Soft X-rays of the magnetosheath, after Jorgensen et al. 2019.

use super::fill_rates;
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

/// How far the bow shock lies ahead of the magnetopause \[`R_E`\], and how much wider it flares.
const BOW_SHOCK_DISTANCE: f64 = 3.0;
const BOW_SHOCK_FLARING: f64 = 0.2;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "jorgensen",
    title: "Magnetosheath soft X-rays, Jorgensen et al. 2019",
    summary: "Solar-wind charge exchange between a magnetopause and a bow shock of Shue's form; \
              no emission inside the magnetopause.",
    source: "Jorgensen et al. 2019, doi:10.1029/2018JA026153",
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
            name: "magnetopause_r0",
            unit: "R_E",
            default: ParameterDefault::Derived(Derivation {
                formula: "(11.4 + c bz) Pd^(-1/6.6), c = 0.013 if bz >= 0 else 0.14, \
                          Pd = 0.5 m_p density velocity^2 [nPa]",
                value: derived!(magnetopause_nose),
            }),
            meaning: "distance of the magnetopause's nose",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "magnetopause_ay",
            unit: "1",
            default: ParameterDefault::Derived(MAGNETOPAUSE_FLARING),
            meaning: "flaring of the magnetopause across z",
            range: AcceptedRange::Between(0.0, 10.0),
        },
        ParameterDescription {
            name: "magnetopause_az",
            unit: "1",
            default: ParameterDefault::Derived(MAGNETOPAUSE_FLARING),
            meaning: "flaring of the magnetopause along z",
            range: AcceptedRange::Between(0.0, 10.0),
        },
        ParameterDescription {
            name: "bow_shock_r0",
            unit: "R_E",
            default: ParameterDefault::Derived(Derivation {
                formula: "magnetopause_r0 + 3",
                value: derived!(|values| values.of("magnetopause_r0") + BOW_SHOCK_DISTANCE),
            }),
            meaning: "distance of the bow shock's nose",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "bow_shock_ay",
            unit: "1",
            default: ParameterDefault::Derived(Derivation {
                formula: "magnetopause_ay + 0.2",
                value: derived!(|values| values.of("magnetopause_ay") + BOW_SHOCK_FLARING),
            }),
            meaning: "flaring of the bow shock across z",
            range: AcceptedRange::Between(0.0, 10.0),
        },
        ParameterDescription {
            name: "bow_shock_az",
            unit: "1",
            default: ParameterDefault::Derived(Derivation {
                formula: "magnetopause_az + 0.2",
                value: derived!(|values| values.of("magnetopause_az") + BOW_SHOCK_FLARING),
            }),
            meaning: "flaring of the bow shock along z",
            range: AcceptedRange::Between(0.0, 10.0),
        },
        ParameterDescription {
            name: "A1",
            unit: "eV cm-3 s-1",
            default: ParameterDefault::Value(3.2e-5),
            meaning: "emissivity of the sheath at 10 R_E towards the Sun",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "A2",
            unit: "eV cm-3 s-1",
            default: ParameterDefault::Value(1.3e-5),
            meaning: "emissivity of the solar wind at 10 R_E",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "B",
            unit: "eV cm-3 s-1",
            default: ParameterDefault::Value(-1.8e-5),
            meaning: "what the sheath's emissivity gains at the flanks, as sin^8 theta",
            range: AcceptedRange::Finite,
        },
        ALPHA_PARAMETER,
        BETA_PARAMETER,
    ],
    jumps_move_with: &[
        "magnetopause_r0",
        "magnetopause_ay",
        "magnetopause_az",
        "bow_shock_r0",
        "bow_shock_ay",
        "bow_shock_az",
    ],
    edges: nowhere,
    singular_points: nowhere,
    build: formula!(|values| Jorgensen::from_values(values)?),
};

const MAGNETOPAUSE_FLARING: Derivation = Derivation {
    formula: "(0.58 - 0.010 bz)(1 + 0.010 Pd)",
    value: derived!(|values| SolarWind::new(values).flaring()),
};

fn magnetopause_nose<T: Scalar>(values: &Values<T>) -> T {
    let wind = SolarWind::new(values);
    let slope = if wind.bz.value() >= 0.0 { 0.013 } else { 0.14 };
    (T::of(11.4) + wind.bz * slope) * wind.dynamic_pressure_npa().powf(T::of(-1.0 / 6.6))
}

/// The soft X-ray emission of the magnetosheath of Jorgensen et al. 2019
/// (doi:10.1029/2018JA026153).
///
/// Nothing inside the magnetopause; (A1 + B sin⁸ θ)(r/10)^−(α + β sin² θ) up to the bow shock;
/// A2 (r/10)⁻³ beyond. Both surfaces are of Shue's form, θ is the angle from +x (to the Sun), r is
/// in `R_E`. The dynamic pressure in its derived parameters is Pd = ½ m n v², as in [`Cmem`]; the
/// transverse field and the dipole tilt are accepted and have no effect.
///
/// As an [`Emission`](emitree::Emission) it gives keV cm⁻² s⁻¹ sr⁻¹ per `R_E`.
///
/// [`Cmem`]: super::Cmem
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jorgensen<T = f64> {
    magnetopause: Shue,
    bow_shock: Shue,
    sheath: T,
    flank: T,
    falloff: SheathFalloff<T>,
    wind: T,
}

impl Jorgensen {
    /// The model with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range, or B < −A1, where the
    /// emissivity would be negative.
    ///
    /// ```
    /// use emitree_models::models::Jorgensen;
    /// use std::collections::BTreeMap;
    ///
    /// let model = Jorgensen::new(&BTreeMap::from([("bow_shock_r0".to_owned(), 15.0)]))?;
    /// assert_eq!(model.emissivity([10.0, 0.0, 0.0]), 0.0); // inside the magnetopause
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Self::from_values(&DESCRIPTION.values(parameters)?)
    }

    /// The emissivity \[eV cm⁻³ s⁻¹\] at a position \[`R_E`\]; 0 at the origin.
    pub fn emissivity(&self, position: [f64; 3]) -> f64 {
        self.at(position)
    }
}

impl<T: Scalar> Jorgensen<T> {
    fn from_values(values: &Values<T>) -> Result<Self, ModelError> {
        let surface = |r0, ay, az| {
            // Surfaces decide where a point is, and have no part in the rate there.
            Shue::new(values.of(r0).value(), values.of(ay).value(), values.of(az).value())
        };
        let (sheath, flank) = (values.of("A1"), values.of("B"));
        if (sheath + flank).value() < 0.0 {
            let expected = format!("at least -A1 = {:e}", -sheath.value());
            return Err(DESCRIPTION.out_of_range("B", flank.value(), expected));
        }
        Ok(Self {
            magnetopause: surface("magnetopause_r0", "magnetopause_ay", "magnetopause_az"),
            bow_shock: surface("bow_shock_r0", "bow_shock_ay", "bow_shock_az"),
            sheath,
            flank,
            falloff: SheathFalloff { alpha: values.of("alpha"), beta: values.of("beta") },
            wind: values.of("A2"),
        })
    }

    /// The emissivity at a position.
    fn at(&self, position: [f64; 3]) -> T {
        let Some(at) = SunAngles::new(position) else {
            return T::of(0.0);
        };
        if self.magnetopause.contains(&at) {
            T::of(0.0)
        } else if self.bow_shock.contains(&at) {
            (self.sheath + self.flank * at.sin_theta.powi(8)) * self.falloff.at(&at)
        } else {
            self.wind * wind_falloff(&at)
        }
    }
}

impl<T: Scalar> Formula<T> for Jorgensen<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_rates(samples, rates, |position| self.at(position) * RATE_PER_EMISSIVITY);
    }
}

emission_of_formula!(Jorgensen);
