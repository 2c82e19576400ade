//! Checks of the options, and of views whose images are to be made row by row.

use crate::energy::EnergyAxis;
use crate::error::OptionError;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::RowsWanted;
use crate::vol::view::part::Parts;
use crate::vol::{BASE_LEVELS, PixelTolerance, VolOptions};

/// Returns an error if an option is out of range.
pub(super) fn check(
    vol: &VolOptions,
    shape: [usize; 2],
    axis: Option<&EnergyAxis>,
) -> Result<(), MethodError> {
    // Where sums alone matter, the tolerance of pixels may be as loose as it can be.
    let is_below = vol.tolerance < 1.0 || (vol.tolerance <= 1.0 && !vol.sums.is_empty());
    if !(vol.tolerance > 0.0 && is_below) {
        return Err(OptionError::Tolerance(vol.tolerance).into());
    }
    if let Some(by_pixel) = &vol.by_pixel {
        check_by_pixel(by_pixel)?;
    }
    if let Some(weights) = &vol.weights {
        check_weights(weights, shape)?;
    }
    if vol.per_band && axis.is_none() {
        return Err(OptionError::PerBand.into());
    }
    if !BASE_LEVELS.contains(&vol.base_level) {
        let expected = [*BASE_LEVELS.start(), *BASE_LEVELS.end()];
        return Err(OptionError::BaseLevel { level: vol.base_level, expected }.into());
    }
    Ok(())
}

fn check_by_pixel(by_pixel: &PixelTolerance) -> Result<(), OptionError> {
    let PixelTolerance { rtol, atol, floor } = *by_pixel;
    if !(atol >= 0.0 && atol.is_finite()) {
        return Err(OptionError::AbsoluteTolerance(atol));
    }
    if !(0.0..1.0).contains(&rtol) || (rtol == 0.0 && atol == 0.0) {
        return Err(OptionError::RelativeTolerance(rtol));
    }
    if !(0.0..1.0).contains(&floor) {
        return Err(OptionError::Floor(floor));
    }
    Ok(())
}

fn check_weights(weights: &Image, shape: [usize; 2]) -> Result<(), OptionError> {
    let given = [weights.height(), weights.width()];
    if given != shape {
        return Err(OptionError::WeightsShape { given, expected: shape });
    }
    let is_weight = |weight: &f64| *weight >= 0.0 && weight.is_finite();
    if let Some(pixel) = weights.pixels().iter().position(|weight| !is_weight(weight)) {
        let [row, column] = [pixel / shape[1], pixel % shape[1]];
        return Err(OptionError::Weight { weight: weights.pixels()[pixel], row, column });
    }
    match weights.largest() > 0.0 {
        true => Ok(()),
        false => Err(OptionError::NoWeights),
    }
}

/// Refuses a view whose bands can't be made of products row by row, before anything is evaluated in its parts.
pub(super) fn check_rows(
    parts: &Parts<'_>,
    is_cube: bool,
    wanted: RowsWanted,
) -> Result<(), MethodError> {
    // The squares about a singularity are those of pixels of the search.
    if parts.has_singularities() {
        return Err(wanted.refused("a singularity of the emission is in its view"));
    }
    let parts = &parts.parts[..];
    if parts.iter().all(|part| part.footing.is_raster_of_pixels()) {
        return Ok(());
    }
    if parts.iter().any(|part| part.footing.is_of_pixels()) {
        return Err(wanted.refused("the rim of a disc divides its pixels"));
    }
    if is_cube {
        return Err(wanted
            .refused("a body, bounds or an ellipsoidal edge divides its view, and it is a cube"));
    }
    Ok(())
}
