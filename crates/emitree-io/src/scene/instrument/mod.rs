//! `[instrument]`: a camera that counts photons, from the radiance of a cube to counts.

mod parts;

use super::camera::Camera;
use super::document::Node;
use super::error::SceneError;
use super::is_option;
use super::radiometry::Quantity;
use super::source::Place;
use super::table::Table;
use crate::energies::Energies;
use crate::units::{Unit, UnitError};
use emitree::{Cube, EnergyAxis, Image};
use emitree_instrument::{
    EffectiveArea, Instrument, Observation, ObservationError, Redistribution,
};

/// The unit of the radiance that an instrument takes.
const RADIANCE: &str = "ph cm-2 s-1 sr-1 keV-1";

/// A camera that counts photons, with the units of its scene and the seed of its counts.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneInstrument {
    /// The area, the matrix, the point-spread function, the exposure and the background.
    pub instrument: Instrument,
    /// The seed of the counts that are drawn.
    pub seed: u64,
    /// What a radiance of the scene is multiplied with to be in photons s⁻¹ cm⁻² sr⁻¹ for each unit of
    /// its energy axis.
    pub radiance_factor: f64,
    /// How many keV one unit of its energy axis is.
    pub kev_per_unit: f64,
}

impl SceneInstrument {
    /// The counts that are expected from a cube of radiance in the unit of the scene, with the solid
    /// angle of each pixel \[sr\].
    pub(super) fn expected_counts(
        &self,
        radiance: &Cube,
        axis: &EnergyAxis,
        solid_angles_sr: &Image,
    ) -> Result<Observation, ObservationError> {
        let observe = |radiance: &Cube| {
            self.instrument.expected_counts(radiance, axis, self.kev_per_unit, solid_angles_sr)
        };
        if !self.converts() {
            return observe(radiance);
        }
        let mut converted = radiance.clone();
        for band in converted.bands_mut() {
            band.pixels_mut().iter_mut().for_each(|pixel| *pixel *= self.radiance_factor);
        }
        observe(&converted)
    }

    /// The memory that the expected counts of a cube of `[bins, height, width]` take at the most, in
    /// bytes, beside the cube itself.
    pub fn memory_bytes(&self, shape: [usize; 3]) -> u64 {
        let [bins, height, width] = shape;
        let pixels = (height as u64).saturating_mul(width as u64);
        // The solid angles and what they are made of, and the copy of a cube that is converted.
        let maps = 2 + if self.converts() { bins as u64 } else { 0 };
        let copies = pixels.saturating_mul(maps).saturating_mul(size_of::<f64>() as u64);
        self.instrument.memory_bytes(shape).saturating_add(copies)
    }

    /// The number of channels, for a cube of `bins` bins.
    pub fn channels(&self, bins: usize) -> usize {
        self.instrument.redistribution.as_ref().map_or(bins, |matrix| matrix.channels().len())
    }

    #[expect(clippy::float_cmp, reason = "only a factor of exactly 1 changes nothing")]
    fn converts(&self) -> bool {
        self.radiance_factor != 1.0
    }
}

/// The other settings of the scene that an instrument depends on.
#[derive(Clone, Copy)]
pub(super) struct Observer<'a> {
    pub(super) camera: &'a Camera,
    /// Height and width of the image.
    pub(super) shape: [usize; 2],
    pub(super) energies: Option<&'a Energies>,
    pub(super) quantity: Quantity,
    /// The unit of the image, which may be empty.
    pub(super) unit: &'a str,
}

pub(super) fn read(
    mut table: Table,
    observer: Observer<'_>,
) -> Result<SceneInstrument, SceneError> {
    const EXPOSURE: &str = "the exposure in s, above 0";
    const SEED: &str = "a whole number, 0 or more";
    let whole = table.place().clone();
    let exposure = match table.take("exposure") {
        Some(node) => node,
        // An option for a table that the scene has not.
        None if is_option(&whole.source) => {
            return Err(SceneError::at(&whole, "the scene has no `[instrument]`")
                .label("expected a table `[instrument]` with `exposure` and `effective_area`"));
        }
        None => table.require("exposure", EXPOSURE)?,
    };
    let (area, matrix) = (table.take("effective_area"), table.text("redistribution")?);
    let (psf, background) = (table.take("psf"), table.take("background"));
    let seed = table.take("seed").map_or(Ok(0), |node| node.count(SEED))?;
    table.finish()?;

    let exposure_s = positive(&exposure, EXPOSURE)?;
    let energies = energies(observer.energies, &whole)?;
    let kev_per_unit = in_kev(energies).map_err(|error| of_unit(&error, &whole))?;
    let ends = [energies.axis().min(), energies.axis().max()].map(|end| end * kev_per_unit);
    if ends[0] < 0.0 {
        let message =
            format!("`[instrument]` counts photons, and `[energy]` starts at {}", ends[0]);
        return Err(SceneError::at(&whole, format!("{message} keV"))
            .label("expected energies of 0 or more"));
    }
    let radiance_factor = radiance_factor(observer, &whole)? * kev_per_unit;
    let redistribution = matrix.as_ref().map(parts::redistribution).transpose()?;
    let included = redistribution.as_ref().is_some_and(Redistribution::includes_area);
    let area = only_area(area.as_ref(), included, ends, &whole)?;
    let psf = psf.map(|node| parts::psf(node, observer)).transpose()?;
    let background = background.map(parts::background).transpose()?;
    let instrument = Instrument { area, redistribution, psf, exposure_s, background };
    Ok(SceneInstrument { instrument, seed, radiance_factor, kev_per_unit })
}

/// The area between two energies \[keV\], which is a key of the scene or `included` in the matrix.
fn only_area(
    node: Option<&Node>,
    included: bool,
    ends: [f64; 2],
    whole: &Place,
) -> Result<Option<EffectiveArea>, SceneError> {
    match (node, included) {
        (Some(node), false) => parts::area(node, ends).map(Some),
        (None, true) => Ok(None),
        (None, false) => Err(SceneError::at(whole, "`instrument.effective_area` is missing")
            .label(format!("expected `effective_area` here: {}", parts::AREA))),
        (Some(node), true) => {
            let message = "`instrument.effective_area` is there twice";
            Err(SceneError::at(&node.place, message)
                .label("expected none: `redistribution` includes it"))
        }
    }
}

fn positive(node: &Node, expected: &str) -> Result<f64, SceneError> {
    match node.number()? {
        number if number > 0.0 => Ok(number),
        other => Err(node.refuse(&other.to_string(), expected)),
    }
}

fn energies<'a>(energies: Option<&'a Energies>, whole: &Place) -> Result<&'a Energies, SceneError> {
    const MESSAGE: &str =
        "`[instrument]` counts photons by their energy, and the scene has no `[energy]`";
    energies.ok_or_else(|| {
        SceneError::at(whole, MESSAGE)
            .label("expected a table `[energy]` too, with `min`, `max` and `bins`")
    })
}

fn in_kev(energies: &Energies) -> Result<f64, UnitError> {
    energies.unit().factor_to(&Unit::parse("keV")?)
}

/// What radiances of the scene are multiplied with to be in [`RADIANCE`].
fn radiance_factor(observer: Observer<'_>, whole: &Place) -> Result<f64, SceneError> {
    if !observer.camera.description().has_solid_angles {
        let message = "`[instrument]` needs pixels with solid angles";
        return Err(SceneError::at(whole, message)
            .label("expected a camera with a point observer: parallel lines of sight have none"));
    }
    if observer.unit.is_empty() {
        let message = "`[instrument]` needs a radiance with a unit, and the image has none";
        return Err(SceneError::at(whole, message).label(format!(
            "expected `emission.unit` and `projection.length_unit` that make it {RADIANCE}"
        )));
    }
    let factor = Unit::parse(observer.unit).and_then(|unit| {
        let radiance = match observer.quantity {
            Quantity::Irradiance => unit.times(&Unit::parse("sr-1")?),
            Quantity::Radiance => unit,
        };
        radiance.factor_to_image(&Unit::parse(RADIANCE)?)
    });
    factor.map_err(|error| {
        of_unit(&error, whole).label(format!(
            "expected an image in {RADIANCE} or a unit that converts to it, and not \"{}\"",
            observer.unit
        ))
    })
}

fn of_unit(error: &UnitError, whole: &Place) -> SceneError {
    SceneError::at(whole, format!("`[instrument]`: {error}"))
}

/// The size of a pixel in the middle of the image along \[x, y\] \[rad\]; none where pixels are on no
/// plane.
fn pixel_rad(observer: Observer<'_>) -> Option<[f64; 2]> {
    if !observer.camera.description().has_plane {
        return None;
    }
    let [height, width] = observer.shape;
    // The step of all spherical projections is that at their reference point, which is the middle.
    let wcs = observer.camera.wcs(height, width, &Unit::one())?;
    Some([wcs.axes.first()?.cdelt.to_radians(), wcs.axes.get(1)?.cdelt.to_radians()])
}

#[cfg(test)]
mod tests;
