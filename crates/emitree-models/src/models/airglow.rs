//! A layer of airglow about a spherical planet, with the profile of Chapman 1931.

use super::constants::RAYLEIGH_PER_COLUMN_CM2;
use super::radial::radius;
use super::{BLOCK, fill_radial_rates, one, scale};
use crate::catalogue::edges::spheres;
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::elementary::Elementary;
use crate::scalar::Scalar;
use emitree::Samples;
use std::collections::BTreeMap;

const CM_PER_KM: f64 = 1e5;

/// Scale heights below the peak at which e^(1 − z − e^−z) has become 0 in floating point.
const DARK_DEPTH: f64 = 7.0;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "airglow",
    title: "Airglow of a Chapman layer",
    summary: "A spherical layer whose emission follows Chapman's profile with height; the defaults \
              are those of the green line of oxygen, 557.7 nm, at night.",
    source: "profile: S. Chapman 1931, Proc. Phys. Soc. 43, 26, doi:10.1088/0959-5309/43/1/305; \
             the defaults are round numbers for the green line, 380 rayleigh at the zenith",
    length_unit: "km",
    image_unit: "R",
    energy_unit: None,
    parameters: &[
        ParameterDescription {
            name: "planet_radius",
            unit: "km",
            default: ParameterDefault::Value(6371.0),
            meaning: "radius of the planet, from which altitudes are measured; no emission inside",
            range: AcceptedRange::NonNegative,
        },
        ParameterDescription {
            name: "peak_altitude",
            unit: "km",
            default: ParameterDefault::Value(97.0),
            meaning: "altitude of the brightest part of the layer",
            range: AcceptedRange::Finite,
        },
        ParameterDescription {
            name: "scale_height",
            unit: "km",
            default: ParameterDefault::Value(7.0),
            meaning: "height in which the emission above the layer falls by a factor e",
            range: AcceptedRange::Positive,
        },
        ParameterDescription {
            name: "peak_rate",
            unit: "cm-3 s-1",
            default: ParameterDefault::Value(200.0),
            meaning: "photons emitted at the peak",
            range: AcceptedRange::NonNegative,
        },
    ],
    jumps_move_with: &["planet_radius"],
    edges: |values| spheres([0.0; 3], [values.of("planet_radius")]),
    singular_points: nowhere,
    build: formula!(|values| Airglow::from_values(values)),
};

/// A spherical layer of the volume emission rate V = Vpeak e^(1 − z − e^−z), z = (h − hpeak)/H,
/// with the altitude h and the scale height H: the profile of Chapman 1931
/// (doi:10.1088/0959-5309/43/1/305). Seen from below, at the zenith, it has e H Vpeak.
///
/// As an [`Emission`](emitree::Emission) it gives rayleigh per km, with 10⁶ photons cm⁻² s⁻¹ to a rayleigh: an image
/// over km is in rayleigh. The planet does not occult: a scene with the planet in view needs
/// an occulter there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Airglow<T = f64> {
    planet_radius: T,
    peak_altitude: T,
    scale_height: T,
    peak_rate: T,
}

impl Airglow {
    /// The layer with these parameters, and defaults for the others.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a parameter that is unknown or out of its range.
    ///
    /// ```
    /// use emitree_models::models::Airglow;
    /// use std::collections::BTreeMap;
    ///
    /// let layer = Airglow::new(&BTreeMap::new())?;
    /// let peak = layer.volume_emission_rate_cm3_s([0.0, 6371.0 + 97.0, 0.0]);
    /// assert!((peak - 200.0).abs() < 1e-12);
    /// assert_eq!(layer.volume_emission_rate_cm3_s([0.0; 3]), 0.0);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    /// V \[photons cm⁻³ s⁻¹\] at a position \[km\]; 0 inside the planet.
    pub fn volume_emission_rate_cm3_s(&self, position: [f64; 3]) -> f64 {
        let r = radius(position);
        if r < self.planet_radius { 0.0 } else { one(r, |distances| self.at(distances)) }
    }
}

impl<T: Scalar> Airglow<T> {
    fn from_values(values: &Values<T>) -> Self {
        Self {
            planet_radius: values.of("planet_radius"),
            peak_altitude: values.of("peak_altitude"),
            scale_height: values.of("scale_height"),
            peak_rate: values.of("peak_rate"),
        }
    }

    /// Turns distances from the planet's centre into V.
    fn at(&self, distances: &mut [T]) {
        let mut depths = [T::of(0.0); BLOCK];
        let depths = &mut depths[..distances.len()];
        for (depth, r) in depths.iter_mut().zip(&mut *distances) {
            let altitude = *r - self.planet_radius;
            let below_peak = (self.peak_altitude - altitude) / self.scale_height;
            let is_dark = below_peak.value() > DARK_DEPTH;
            *depth = if is_dark { T::of(DARK_DEPTH) } else { below_peak };
            *r = *depth;
        }
        T::apply(Elementary::Exp, distances);
        for (&depth, weakened) in depths.iter().zip(&mut *distances) {
            *weakened = T::of(1.0) + depth - *weakened;
        }
        T::apply(Elementary::Exp, distances);
        scale(distances, self.peak_rate);
    }
}

impl<T: Scalar> Formula<T> for Airglow<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        let rayleigh_per_rate = RAYLEIGH_PER_COLUMN_CM2 * CM_PER_KM;
        let range = [self.planet_radius, T::of(f64::INFINITY)];
        fill_radial_rates(samples, rates, [T::of(0.0); 3], range, |distances| {
            self.at(distances);
            scale(distances, T::of(rayleigh_per_rate));
        });
    }
}

emission_of_formula!(Airglow);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_zenith_has_e_scale_heights_of_the_peak() {
        let layer = Airglow::new(&BTreeMap::new()).unwrap();
        // The midpoint rule, in steps of 0.05 km up to 400 km.
        let column: f64 = (0..8000)
            .map(|step| {
                layer.volume_emission_rate_cm3_s([0.0, 0.0, 6371.025 + f64::from(step) * 0.05])
            })
            .sum();
        let zenith_cm2 = column * 0.05 * 1e5;
        assert!((zenith_cm2 / (1.0_f64.exp() * 7e5 * 200.0) - 1.0).abs() < 1e-9);
        assert!((zenith_cm2 * 1e-6 - 380.6).abs() < 0.1);
    }

    #[test]
    fn nothing_is_lost_where_it_is_cut() {
        assert!((1.0 + DARK_DEPTH - DARK_DEPTH.exp()).exp() <= 0.0);
    }

    #[test]
    fn a_thick_layer_ends_at_the_ground() {
        let thick = [("scale_height".to_owned(), 200.0), ("planet_radius".to_owned(), 1000.0)];
        let layer = Airglow::new(&BTreeMap::from(thick)).unwrap();
        assert!(layer.volume_emission_rate_cm3_s([1000.0, 0.0, 0.0]) > 100.0);
        assert!(layer.volume_emission_rate_cm3_s([999.999, 0.0, 0.0]) <= 0.0);
    }

    #[test]
    fn a_thin_layer_is_finite_at_the_centre_and_far_away() {
        let parameters = BTreeMap::from([("scale_height".to_owned(), 1e-310)]);
        let layer = Airglow::new(&parameters).unwrap();
        for r in [0.0, 6371.0, 6468.0, 1e300] {
            assert!(layer.volume_emission_rate_cm3_s([r, 0.0, 0.0]).is_finite(), "{r}");
        }
    }
}
