//! Units: from those of the emission to those of the image.
//!
//! An emission has a rate unit and a length unit of its own; the scene has a length unit, and may set
//! another unit for the image. All of it becomes two factors: one on positions, one on rates. The
//! renderer works with pure numbers.

use super::absorption::SceneAbsorption;
use super::emission::{EmissionFailure, EmissionSource};
use super::error::SceneError;
use super::source::Place;
use super::table::Table;
use crate::energies::Energies;
use crate::exposure::{Events, Exposure};
use crate::units::{Dimension, Unit, UnitError, band_unit, image_unit};
use emitree::{Emission, Samples};
use std::sync::Arc;

/// A text and where it was written.
type Text = (String, Place);

/// What the pixels of an image are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// F(Ω)/Ω: the mean over the pixel's solid angle.
    Radiance,
    /// F(Ω): the integral over the pixel's solid angle.
    Irradiance,
}

impl Quantity {
    /// The name, as scenes and reports write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radiance => "radiance",
            Self::Irradiance => "irradiance",
        }
    }
}

/// The units in `[emission]`.
pub(super) struct EmissionUnits {
    unit: Option<Text>,
    photon_energy_ev: Option<(f64, Place)>,
}

impl EmissionUnits {
    pub(super) fn read(table: &mut Table) -> Result<Self, SceneError> {
        const EXPECTED: &str = "an energy in eV above 0";
        let unit = table.text("unit")?;
        let photon_energy_ev = match table.take("photon_energy") {
            None => None,
            Some(node) => match node.number()? {
                energy if energy > 0.0 => Some((energy, node.place)),
                other => return Err(node.refuse(&other.to_string(), EXPECTED)),
            },
        };
        Ok(Self { unit, photon_energy_ev })
    }

    /// Where there is an energy axis, refuses a number of photons or counts that is not per energy,
    /// and an energy of the photons, which have those of their bins.
    fn check_per_energy(&self) -> Result<(), SceneError> {
        if let Some((energy, place)) = &self.photon_energy_ev {
            let message = format!("`emission.photon_energy` is {energy}");
            return Err(SceneError::at(place, message).label(
                "expected none: with `[energy]` photons have all energies of their bin, and a cube \
                 in photons can't become one in energies",
            ));
        }
        let Some((text, place)) = &self.unit else { return Ok(()) };
        // A unit that can't be read is refused where its dimension is needed.
        let dimension = Unit::parse(text).map_or(Dimension::NONE, |unit| unit.dimension());
        let is_number = dimension.photon != 0 || dimension.count != 0;
        if is_number && dimension.mass == 0 {
            let message = format!("`emission.unit` is \"{text}\", and the scene has `[energy]`");
            return Err(SceneError::at(place, message)
                .label(format!("expected the rate per unit of energy, as in \"{text} keV-1\"")));
        }
        Ok(())
    }
}

/// The units in `[image]`.
pub(super) struct ImageUnits {
    unit: Option<Text>,
    quantity: Option<Text>,
}

impl ImageUnits {
    pub(super) fn read(table: &mut Table) -> Result<Self, SceneError> {
        Ok(Self { unit: table.text("unit")?, quantity: table.text("quantity")? })
    }
}

/// The emission of a scene, in the scene's units: an [`Emission`] whose line-of-sight integral over the
/// scene's length unit is the image in its own unit.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SceneEmission {
    /// The emission, in its own units.
    pub source: EmissionSource,
    /// Length units of the source in one of the scene.
    pub length_factor: f64,
    /// Energy units of the source in one of the scene.
    pub energy_factor: f64,
    /// What the source's rates are multiplied with.
    pub rate_factor: f64,
    /// The unit of the source's rates as it is written, or empty: of a model that of its image over its length
    /// unit.
    pub rate_unit: String,
    /// The absorption coefficient of the medium, if it absorbs.
    pub absorption: Option<SceneAbsorption>,
    /// Where and when samples of the camera are evaluated, if that is not where and when they are: the observer
    /// moves, or light takes time.
    pub events: Option<Arc<Events>>,
}

impl SceneEmission {
    /// Calls a function with samples of the camera where and when they are seen.
    pub fn seen<T>(&self, samples: &Samples<'_>, of: impl FnOnce(&Samples<'_>) -> T) -> T {
        match &self.events {
            Some(events) => events.seen(samples, of),
            None => of(samples),
        }
    }
}

impl Emission for SceneEmission {
    type Error = EmissionFailure;

    #[expect(clippy::float_cmp, reason = "only a factor of exactly 1 changes nothing")]
    fn emission_rates(
        &self,
        samples: &Samples<'_>,
        rates: &mut [f64],
    ) -> Result<(), EmissionFailure> {
        let factors = [self.length_factor, self.energy_factor];
        self.seen(samples, |samples| {
            samples_in_units(samples, factors, |samples| self.source.emission_rates(samples, rates))
        })?;
        if self.rate_factor != 1.0 {
            rates.iter_mut().for_each(|rate| *rate *= self.rate_factor);
        }
        Ok(())
    }

    fn absorbs(&self) -> bool {
        self.absorption.is_some()
    }

    fn absorption_coefficients(
        &self,
        samples: &Samples<'_>,
        coefficients: &mut [f64],
    ) -> Result<(), EmissionFailure> {
        match &self.absorption {
            Some(absorption) => {
                self.seen(samples, |samples| absorption.coefficients(samples, coefficients))
            }
            None => {
                coefficients.fill(0.0);
                Ok(())
            }
        }
    }
}

/// Calls a function with samples whose positions and energies are multiplied with factors.
#[expect(clippy::float_cmp, reason = "only a factor of exactly 1 changes nothing")]
pub(super) fn samples_in_units<T>(
    samples: &Samples<'_>,
    [length_factor, energy_factor]: [f64; 2],
    of: impl FnOnce(&Samples<'_>) -> T,
) -> T {
    if length_factor == 1.0 && energy_factor == 1.0 {
        return of(samples);
    }
    let scaled = |position: &[f64; 3]| position.map(|along| along * length_factor);
    let positions: Vec<[f64; 3]> = samples.positions().iter().map(scaled).collect();
    let energies: Vec<f64> =
        samples.energies().iter().map(|energy| energy * energy_factor).collect();
    of(&Samples::new(&positions, samples.directions()).at_energies(&energies))
}

/// What the camera has to do with units.
pub(super) struct CameraUnits {
    /// The length unit that the scene names.
    pub(super) length: Option<Text>,
    pub(super) has_solid_angles: bool,
}

/// The emission in the units of the scene, the scene's length unit, and quantity and unit of the
/// image.
pub(super) struct Radiometry {
    pub(super) emission: SceneEmission,
    pub(super) length_unit: Option<String>,
    pub(super) quantity: Quantity,
    pub(super) unit: String,
    pub(super) band: BandUnit,
}

/// The unit of the image of all energies, empty if it is not known, and what a sum of voxels times bins
/// is multiplied with for it.
#[derive(Clone, Debug)]
pub(super) struct BandUnit {
    pub(super) unit: String,
    pub(super) factor: f64,
}

impl BandUnit {
    /// Of a cube in `unit`, which may be empty.
    fn of(unit: &str, energies: Option<&Energies>, exposure: Option<&Exposure>) -> Self {
        if let Some(exposure) = exposure {
            // The mean over all times.
            let [start_s, stop_s] = exposure.range_s();
            return Self { unit: unit.to_owned(), factor: 1.0 / (stop_s - start_s) };
        }
        let known = energies.filter(|_| !unit.is_empty());
        let found = known.and_then(|energies| {
            let (unit, factor) = band_unit(&Unit::parse(unit).ok()?, energies.unit()).ok()?;
            let (text, of_text) = unit.fits();
            Some(Self { unit: text.unwrap_or_default(), factor: factor * of_text })
        });
        found.unwrap_or_else(|| Self { unit: String::new(), factor: 1.0 })
    }
}

pub(super) fn resolve(
    source: EmissionSource,
    of_emission: &EmissionUnits,
    of_image: &ImageUnits,
    CameraUnits { length: length_unit, has_solid_angles }: CameraUnits,
    energies: Option<&Energies>,
    exposure: Option<&Exposure>,
) -> Result<Radiometry, SceneError> {
    if energies.is_some() {
        of_emission.check_per_energy()?;
    }
    let quantity = quantity(of_image.quantity.as_ref(), has_solid_angles)?;
    let length_factor = length_factor(source.length_unit(), length_unit.as_ref())?;
    let energy_factor = energy_factor(source.energy_unit(), energies);
    let scene_length = length_unit.as_ref().map(|(unit, _)| unit.clone());
    let scene_length = scene_length.or(source.length_unit().map(str::to_owned));
    let native = native(&source, of_emission, scene_length.as_deref(), length_unit.as_ref())?;
    let (unit, factor) = in_wanted_unit(native, of_emission, of_image, quantity).map_err(
        |error| match energies {
            Some(_) => error.help("with `[energy]` images are per unit of energy, as in keV-1"),
            None => error,
        },
    )?;
    let rate_unit = rate_unit(&source, of_emission);
    // The source's rates are for its own length unit.
    let rate_factor = length_factor * factor;
    Ok(Radiometry {
        emission: SceneEmission {
            source,
            length_factor,
            energy_factor,
            rate_factor,
            rate_unit,
            absorption: None,
            events: None,
        },
        length_unit: scene_length,
        quantity,
        band: BandUnit::of(&unit, energies, exposure),
        unit,
    })
}

/// The unit of the rates of a source, or empty.
fn rate_unit(source: &EmissionSource, of_emission: &EmissionUnits) -> String {
    let of_file = match source {
        EmissionSource::Grid(grid) => grid.unit.clone(),
        _ => None,
    };
    let of_image = || match (source.image_unit(), source.length_unit()) {
        ("", _) | (_, None) => String::new(),
        (image, Some(length)) => format!("{image} {length}-1"),
    };
    let written = of_emission.unit.as_ref().map(|(unit, _)| unit.clone());
    written.or(of_file).unwrap_or_else(of_image)
}

fn quantity(text: Option<&Text>, has_solid_angles: bool) -> Result<Quantity, SceneError> {
    let refuse = |place, message: String, expected: &str| {
        Err(SceneError::at(place, message).label(format!("expected {expected}")))
    };
    match text {
        None => Ok(Quantity::Radiance),
        Some((name, _)) if name == "radiance" => Ok(Quantity::Radiance),
        Some((name, _)) if name == "irradiance" && has_solid_angles => Ok(Quantity::Irradiance),
        Some((name, place)) if name == "irradiance" => {
            let message = "`image.quantity` is \"irradiance\"".to_owned();
            let expected = "`radiance`: the pixels of parallel lines of sight have no solid angles";
            refuse(place, message, expected)
        }
        Some((name, place)) => {
            refuse(place, format!("unknown quantity `{name}`"), "`radiance` or `irradiance`")
        }
    }
}

/// Length units of the source in one of the scene.
pub(super) fn length_factor(
    of_source: Option<&str>,
    of_scene: Option<&Text>,
) -> Result<f64, SceneError> {
    let (Some(source), Some((scene, place))) = (of_source, of_scene) else { return Ok(1.0) };
    if source == scene {
        return Ok(1.0);
    }
    let converted = Unit::parse(scene)
        .and_then(|scene| scene.factor_to(&Unit::parse(source)?))
        .map_err(|error| SceneError::at(place, format!("`length_unit` is \"{scene}\": {error}")));
    converted.map_err(|error| {
        error.label(format!("expected \"{source}\", the length unit of the emission, or another"))
    })
}

/// Energy units of the source in one of the scene.
pub(super) fn energy_factor(of_source: Option<&str>, energies: Option<&Energies>) -> f64 {
    let (Some(source), Some(energies)) = (of_source, energies) else { return 1.0 };
    // A model names a unit of energy; with another one the factor would stay 1.
    let known = Unit::parse(source).and_then(|source| energies.unit().factor_to(&source));
    known.unwrap_or(1.0)
}

/// The unit of the image if the scene sets none, and what the rates are multiplied with for
/// it; none if it is not known.
fn native(
    source: &EmissionSource,
    of_emission: &EmissionUnits,
    scene_length: Option<&str>,
    length_place: Option<&Text>,
) -> Result<Option<(Unit, f64)>, SceneError> {
    let of_source = source.image_unit();
    let (text, place) = match (&of_emission.unit, source) {
        (Some((_, place)), _) if !of_source.is_empty() => {
            return Err(SceneError::at(place, "`emission.unit` has no meaning here")
                .label(format!("expected none: images of this emission are in \"{of_source}\"")));
        }
        (Some((unit, place)), _) => (unit.as_str(), Some(place)),
        (None, EmissionSource::Grid(grid)) => match &grid.unit {
            // The unit in a file is not checked if it is not used.
            Some(unit) if Unit::parse(unit).is_ok() && scene_length.is_some() => {
                (unit.as_str(), None)
            }
            _ => return Ok(None),
        },
        (None, _) => {
            return match Unit::parse(of_source) {
                Ok(unit) if !of_source.is_empty() => Ok(Some((unit, 1.0))),
                _ => Ok(None),
            };
        }
    };
    let at = |error: &UnitError, key: &str, place: Option<&Place>| match place {
        Some(place) => Err(SceneError::at(place, format!("`{key}`: {error}"))),
        None => Ok(None),
    };
    let rate = match Unit::parse(text) {
        Ok(rate) => rate,
        Err(error) => return at(&error, "emission.unit", place),
    };
    let Some(length) = scene_length else {
        return match place {
            Some(place) => Err(SceneError::at(place, "`emission.unit` needs a length unit")
                .label("expected `length_unit` in `[projection]` too, as in \"km\"")),
            None => Ok(None),
        };
    };
    let length_place = length_place.map(|(_, place)| place).or(place);
    match Unit::parse(length) {
        Err(error) => at(&error, "projection.length_unit", length_place),
        Ok(length) => match image_unit(&rate, &length) {
            Ok(found) => Ok(Some(found)),
            Err(error) => at(&error, "emission.unit", place),
        },
    }
}

/// The text of the image's unit, and what the rates are multiplied with for it.
fn in_wanted_unit(
    native: Option<(Unit, f64)>,
    of_emission: &EmissionUnits,
    of_image: &ImageUnits,
    quantity: Quantity,
) -> Result<(String, f64), SceneError> {
    let Some((native, factor)) = native else {
        return match &of_image.unit {
            None => Ok((String::new(), 1.0)),
            Some((_, place)) => Err(SceneError::at(place, "`image.unit` can't be reached")
                .label("expected `emission.unit` too, the unit that the rates have")),
        };
    };
    let (native, factor) = match (quantity, Unit::parse("sr")) {
        // An isotropic emission, into 4π sr, has 1/(4π) of it per steradian.
        (Quantity::Irradiance, Ok(_)) if native.dimension().angle == 0 => {
            (native, factor / (4.0 * std::f64::consts::PI))
        }
        (Quantity::Irradiance, Ok(steradian)) => (native.times(&steradian), factor),
        _ => (native, factor),
    };
    let Some((text, place)) = &of_image.unit else {
        let (text, of_text) = native.fits();
        return Ok((text.unwrap_or_default(), factor * of_text));
    };
    let converted = Unit::parse(text).and_then(|wanted| {
        let of_wanted = match of_emission.photon_energy_ev {
            None => native.factor_to_image(&wanted)?,
            Some((energy, _)) => {
                native.factor_with_photon_energy(&wanted, energy * JOULES_PER_EV)?
            }
        };
        let (text, of_text) = wanted.fits();
        Ok((text.unwrap_or_default(), factor * of_wanted * of_text))
    });
    converted.map_err(|error| SceneError::at(place, format!("`image.unit`: {error}")))
}

/// Exact since 2019: the elementary charge in coulombs.
const JOULES_PER_EV: f64 = 1.602_176_634e-19;

#[cfg(test)]
mod tests;
