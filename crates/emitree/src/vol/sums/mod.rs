//! Sums over regions, each to a tolerance of its own.
//!
//! The error of a sum is not the sum of the errors of its pixels, most of which cancel. It is estimated
//! from lines of sight, or points, that take no part in the image, scattered over the region: the mean of their
//! differences from the image is an unbiased estimate of the error of the sum, with a standard error. If
//! that is too large, more lines are taken or, if they are expected to cost more, the image is made again
//! with smaller errors in the region; rates that are known are not requested again.
//!
//! * `functional`: a sum as coefficients of voxels, its value, the sum of errors;
//! * `scattered`: places in a region, and the part of a pixel that its neighbours explain;
//! * `lines`: the integrals of lines of sight;
//! * `points`: single points, where the image is made of a function of three coordinates;
//! * `residuals`: the lines or points of one sum, and the error that follows from them;
//! * `tighter`: options with smaller errors in regions.

mod functional;
mod lines;
mod points;
mod residuals;
mod scattered;
mod tighter;

use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::radiance::solid_angles;
use crate::sums::RegionSum;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::choose;
use crate::vol::error_weights::ErrorWeights;
use crate::vol::sums::functional::{Functional, check};
use crate::vol::sums::residuals::{Budget, Residuals};
use crate::vol::sums::tighter::Tighter;
use crate::vol::tuning::TUNING;

/// The most images that are made for the sums. Each divides the errors in a region by 2 at the least.
const MOST_IMAGES: u32 = 12;

/// What is rendered.
#[derive(Clone, Copy)]
struct View<'a> {
    meter: &'a Meter,
    tiles: &'a [Tile<'a>],
    axis: Option<&'a EnergyAxis>,
    /// The solid angle of each pixel of all tiles.
    solid_angles: &'a Image,
}

/// Renders an image or a cube to the tolerance of `vol`, and its sums to theirs.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<MethodOutput, MethodError> {
    if vol.sums.is_empty() {
        return choose::render_in_time(meter, tiles, axis, vol).await;
    }
    check(&vol.sums, tiles[0].shape_of_image())?;
    let of_tiles: Vec<Image> =
        tiles.iter().map(|tile| solid_angles(tile.projection, tile.shape)).collect();
    let solid_angles = &Image::stacked(of_tiles.iter());
    let view = View { meter, tiles, axis, solid_angles };
    let functionals: Vec<Functional<'_>> = vol
        .sums
        .iter()
        .enumerate()
        .map(|(number, sum)| Functional::new(number, sum, solid_angles, axis))
        .collect::<Result<_, _>>()?;
    let mut residuals: Vec<Residuals> = functionals.iter().map(|_| Residuals::default()).collect();
    let mut tighter = Tighter::new(vol);
    let mut made = choose::render_in_time(meter, tiles, axis, vol).await?;
    for image in 1.. {
        made.sums = estimate(view, &functionals, &mut residuals, &made, image).await?;
        let is_met = made.sums.iter().all(RegionSum::is_within_tolerance);
        if is_met || made.ending != StopReason::Complete {
            break;
        }
        let is_spent = meter.evaluations_left() == 0;
        if is_spent || image == MOST_IMAGES {
            made.ending = if is_spent { StopReason::Budget } else { StopReason::MaxLevel };
            break;
        }
        tighter.tighten(&made);
        meter.restart_evaluations_per_pixel();
        let options = tighter.options(vol, &functionals, made.surfaces.is_some());
        let mut next = match choose::render(meter, tiles, axis, &options).await {
            Ok(next) => next,
            // The image so far is better than none.
            Err(RenderError::Budget { .. } | RenderError::Time { .. }) => {
                made.ending = StopReason::Budget;
                break;
            }
            Err(error) => return Err(error),
        };
        next.error_over_allowed = share_of_allowed(vol, &next);
        if next.ending != StopReason::Complete {
            // It may be worse where the budget has ended it.
            next.sums = estimate(view, &functionals, &mut residuals, &next, image).await?;
            let is_better = worst(&next.sums) < worst(&made.sums)
                && next.error_over_allowed.is_some_and(|share| share <= 1.0);
            let is_met = is_better && next.sums.iter().all(RegionSum::is_within_tolerance);
            let ending = if is_met { StopReason::Complete } else { next.ending };
            made = if is_better { next } else { made };
            made.ending = ending;
            break;
        }
        made = next;
    }
    Ok(made)
}

/// The largest error of a value over the error that the options allow.
fn share_of_allowed(vol: &VolOptions, made: &MethodOutput) -> Option<f64> {
    let vol = &VolOptions { tolerance: vol.of_largest(), ..vol.clone() };
    made.error.as_ref().map(|errors| ErrorWeights::over_allowed(vol, &made.cube, errors))
}

/// The largest error of a sum over the error allowed.
fn worst(sums: &[RegionSum]) -> f64 {
    let share = |sum: &RegionSum| if sum.error > 0.0 { sum.error / sum.allowed } else { 0.0 };
    sums.iter().map(share).fold(0.0, f64::max)
}

/// The sums of an image, with their errors; `image` is its number, from 1.
async fn estimate(
    view: View<'_>,
    functionals: &[Functional<'_>],
    residuals: &mut [Residuals],
    made: &MethodOutput,
    image: u32,
) -> Result<Vec<RegionSum>, MethodError> {
    // A later image has not helped enough: more of the evaluations are for lines.
    let share = TUNING.sums.share_of_evaluations * f64::from(image);
    let mut sums = Vec::with_capacity(functionals.len());
    for (functional, residuals) in functionals.iter().zip(residuals) {
        let most = share * view.meter.kept_evaluations() as f64;
        sums.push(residuals.estimate(view, functional, made, Budget { most }).await?);
    }
    Ok(sums)
}

#[cfg(test)]
mod tests;
