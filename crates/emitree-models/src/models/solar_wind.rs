//! The solar wind upstream of the Earth: six parameters that the magnetosheath models share.

use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::scalar::Scalar;
use core::f64::consts::{FRAC_PI_2, PI};

/// Mass of the proton \[kg\], to the three digits that reproduce the reference image of CMEM: its
/// largest pixel and errors, which CODATA's 1.67262·10⁻²⁷ misses, for the magnetopause lies 0.03 %
/// closer then.
const PROTON_MASS_KG: f64 = 1.67e-27;

/// Magnetic constant μ0 \[T m/A\], the value before 2019, which differs by 6·10⁻¹⁰.
const MAGNETIC_CONSTANT: f64 = 4e-7 * PI;

const PASCAL_PER_NANOPASCAL: f64 = 1e-9;

const FIELD_RANGE: AcceptedRange = AcceptedRange::Between(-200.0, 200.0);

/// The parameters, with view 1 of the SMILE comparison as their defaults.
pub(super) const DENSITY: ParameterDescription = ParameterDescription {
    name: "density",
    unit: "cm-3",
    default: ParameterDefault::Value(5.0),
    meaning: "proton density of the solar wind",
    range: AcceptedRange::Positive,
};
pub(super) const VELOCITY: ParameterDescription = ParameterDescription {
    name: "velocity",
    unit: "km s-1",
    default: ParameterDefault::Value(400.0),
    meaning: "speed of the solar wind",
    range: AcceptedRange::Between(10.0, 10_000.0),
};
pub(super) const BX: ParameterDescription = ParameterDescription {
    name: "bx",
    unit: "nT",
    default: ParameterDefault::Value(0.0),
    meaning: "interplanetary magnetic field towards the Sun",
    range: FIELD_RANGE,
};
pub(super) const BY: ParameterDescription = ParameterDescription {
    name: "by",
    meaning: "interplanetary magnetic field towards dusk",
    ..BX
};
pub(super) const BZ: ParameterDescription = ParameterDescription {
    name: "bz",
    default: ParameterDefault::Value(5.0),
    meaning: "interplanetary magnetic field towards the north",
    ..BX
};
pub(super) const DIPOLE_TILT: ParameterDescription = ParameterDescription {
    name: "dipole_tilt",
    unit: "rad",
    default: ParameterDefault::Value(0.0),
    meaning: "tilt of the Earth's dipole, positive with its northern end to the Sun",
    range: AcceptedRange::Between(-FRAC_PI_2, FRAC_PI_2),
};

/// A state of the solar wind, in the units of the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SolarWind<T = f64> {
    pub(super) density: T,
    pub(super) velocity: T,
    pub(super) magnetic_field: [T; 3],
    pub(super) bz: T,
    pub(super) dipole_tilt: T,
}

impl<T: Scalar> SolarWind<T> {
    pub(super) fn new(values: &Values<T>) -> Self {
        let bz = values.of("bz");
        Self {
            density: values.of("density"),
            velocity: values.of("velocity"),
            magnetic_field: [values.of("bx"), values.of("by"), bz],
            bz,
            dipole_tilt: values.of("dipole_tilt"),
        }
    }

    /// Pd = ½ m n v² \[nPa\] with the mass m of the proton; the factor ½ is that of Wharton et
    /// al. 2025.
    pub(super) fn dynamic_pressure_npa(&self) -> T {
        let (density_m3, velocity_m_s) = (self.density * 1e6, self.velocity * 1e3);
        density_m3 * (0.5 * PROTON_MASS_KG) * velocity_m_s * velocity_m_s / PASCAL_PER_NANOPASCAL
    }

    /// Pm = B²/(2 μ0) \[nPa\]
    pub(super) fn magnetic_pressure_npa(&self) -> T {
        let [bx, by, bz] = self.magnetic_field;
        let b2_nt = bx * bx + by * by + bz * bz;
        b2_nt * 1e-18 / (2.0 * MAGNETIC_CONSTANT) / PASCAL_PER_NANOPASCAL
    }

    /// (0.58 − 0.010 Bz)(1 + 0.010 Pd), the flaring of the magnetopause of Shue et al. 1997
    /// (doi:10.1029/97JA00196).
    pub(super) fn flaring(&self) -> T {
        let pressure_npa = self.dynamic_pressure_npa();
        (T::of(0.58) - self.bz * 0.010) * (T::of(1.0) + pressure_npa * 0.010)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressures() {
        let wind = SolarWind {
            density: 5.0,
            velocity: 400.0,
            magnetic_field: [3.0, 0.0, -4.0],
            bz: -4.0,
            dipole_tilt: 0.0,
        };
        // 0.5 · 1.67e-27 · 5e6 · (4e5)² = 6.68e-10 Pa
        assert!((wind.dynamic_pressure_npa() - 0.668).abs() < 1e-14);
        // 25e-18/(8π·1e-7) = 9.94718394e-12 Pa
        assert!((wind.magnetic_pressure_npa() - 0.009_947_183_943_243_459).abs() < 1e-16);
    }
}
