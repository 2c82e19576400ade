//! Charge exchange between protons and hydrogen atoms.

use super::constants::{JOULE_PER_KEV, PROTON_MASS_KG};
use crate::scalar::Scalar;

/// The cross section \[m²\] of H⁺ + H → H + H⁺ at a relative speed \[m/s\] more than 0.
pub(super) fn cross_section_m2<T: Scalar>(speed_m_s: T) -> T {
    let energy_kev = speed_m_s * (0.5 * PROTON_MASS_KG) * speed_m_s / JOULE_PER_KEV;
    lindsay_stebbings(energy_kev) * 1e-20
}

/// The same \[cm²\] for a proton of an energy \[keV\] more than 0 and an atom at rest.
pub(super) fn cross_section_at_kev_cm2(energy_kev: f64) -> f64 {
    lindsay_stebbings(energy_kev) * 1e-16
}

/// The cross section \[10⁻¹⁶ cm²\] for a proton of an energy E \[keV\],
///
/// σ = (4.15 − 0.531 ln E)² (1 − e^(−67.3/E))^4.5,
///
/// the fit of Lindsay and Stebbings 2005 (doi:10.1029/2005JA011298) to measurements from 5 eV to
/// 250 keV. Elsewhere it is the same formula, which tends to 0 at high energies, and grows as
/// ln² E at low ones, where few particles and little flux are.
fn lindsay_stebbings<T: Scalar>(energy_kev: T) -> T {
    let slow = T::of(4.15) - energy_kev.ln() * 0.531;
    let fast = -(T::of(-67.3) / energy_kev).exp_m1();
    slow * slow * fast.powf(T::of(4.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn speed_m_s(energy_kev: f64) -> f64 {
        (2.0 * energy_kev * JOULE_PER_KEV / PROTON_MASS_KG).sqrt()
    }

    #[test]
    fn as_published() {
        // At 1 keV the logarithm vanishes, and so does e^−67.3.
        assert!((cross_section_m2(speed_m_s(1.0)) / (4.15 * 4.15 * 1e-20) - 1.0).abs() < 1e-14);
        // mpmath with 30 digits: tests/reference/models.py.
        for (energy_kev, expected) in [
            (0.005, 4.848_903_038_557_681e-19),
            (10.0, 8.523_278_302_539_495e-20),
            (250.0, 2.236_413_362_101_991_5e-23),
        ] {
            let error = cross_section_m2(speed_m_s(energy_kev)) / expected - 1.0;
            assert!(error.abs() < 1e-13, "{energy_kev} keV: {error:e}");
            let of_energy = cross_section_at_kev_cm2(energy_kev) * 1e-4;
            assert!((of_energy / expected - 1.0).abs() < 1e-13, "{energy_kev} keV: {of_energy:e}");
        }
    }

    #[test]
    fn fades_beyond_the_measurements() {
        let [fast, faster] = [250.0, 2e4].map(|energy_kev| cross_section_m2(speed_m_s(energy_kev)));
        assert!(faster > 0.0 && faster < 1e-5 * fast);
    }
}
