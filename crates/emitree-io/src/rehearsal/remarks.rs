//! What looks odd about a scene, its image, and the forecast: remarks for people, each with what to do.

use super::{Forecast, vol_of};
use crate::grouped::grouped;
use crate::rendered::nothing_in_view;
use crate::scene::Scene;
use emitree::{Cube, Method, Rendering};

/// Something odd, with what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Remark {
    /// What it is about, in a word: `view`, `rates`, `far`, `data`, `tolerance`, `limits`, `keys` or
    /// `pixels`.
    pub about: &'static str,
    /// The remark.
    pub text: String,
}

impl Remark {
    pub(super) fn new(about: &'static str, text: impl Into<String>) -> Self {
        Self { about, text: text.into() }
    }
}

/// Tolerances above this one are met at this one.
const LOOSEST_TOLERANCE: f64 = 0.05;
/// Below this tolerance the rounding of sums of 64-bit numbers may be all that is left of an error: a Gaussian ball
/// is rendered to 1e-13 with 13,051 evaluations, and to 1e-14 not with millions.
const TIGHTEST_TOLERANCE: f64 = 1e-13;
/// Rates and pixels of these sizes have room for squares and for sums.
const USUAL_SIZES: [f64; 2] = [1e-120, 1e120];
/// A pixel is faint below this fraction of the largest.
const FAINT: f64 = 0.01;
/// The share of pixels that are not faint, below which most of the view is empty.
const LEAST_BRIGHT_SHARE: f64 = 0.01;
/// Fewer pixels than this are too few for a share.
const LEAST_PIXELS: usize = 400;

/// Remarks that need no evaluation of g.
pub(super) fn of_settings(scene: &Scene) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let settings = &scene.render;
    if !settings.ignored.is_empty() {
        let (names, method) = (settings.ignored.join("`, `"), settings.method.name());
        let text = format!("`{names}` have no effect: the method {method} has no such option");
        let text = if settings.ignored.len() == 1 { text.replace(" have ", " has ") } else { text };
        remarks.push(Remark::new("keys", text));
    }
    if let Some(vol) = vol_of(scene)
        && vol.by_pixel.is_none()
        && vol.sums.is_empty()
    {
        let tolerance = vol.tolerance;
        let why = match tolerance {
            _ if tolerance > LOOSEST_TOLERANCE => Some(format!(
                "is met at {LOOSEST_TOLERANCE}: looser searches do not find the structure of an image"
            )),
            _ if tolerance < TIGHTEST_TOLERANCE => Some(format!(
                "may never be met: rounding alone makes errors of that size; expected {TIGHTEST_TOLERANCE:e} or more"
            )),
            _ => None,
        };
        let text = why.map(|why| format!("the tolerance {tolerance:?} {why}"));
        remarks.extend(text.map(|text| Remark::new("tolerance", text)));
    }
    remarks
}

/// Remarks on a rehearsed image.
pub(super) fn of_image(scene: &Scene, rendering: &Rendering<Cube>) -> Vec<Remark> {
    let pixels = || rendering.values.voxels().filter(|pixel| pixel.is_finite());
    let largest = pixels().fold(0.0, |largest: f64, pixel| largest.max(pixel.abs()));
    let largest_rate = rendering.stats.largest_rate.map_or(0.0, |of| of.rate.abs());
    if largest == 0.0 && largest_rate == 0.0 {
        let evaluations = rendering.stats.evaluations;
        return vec![Remark::new("view", nothing_in_view(evaluations))];
    }
    let mut remarks = Vec::new();
    for (what, size) in [("rates", largest_rate), ("pixels", largest)] {
        if size > 0.0 && !(USUAL_SIZES[0]..USUAL_SIZES[1]).contains(&size) {
            let how = if size < 1.0 { "small" } else { "large" };
            let text = format!(
                "{what} are up to {size:.1e}, which is {how} for numbers of 1e-308 to 1e308: expected other units \
                 (emission.unit, length_unit), or a factor"
            );
            remarks.push(Remark::new("rates", text));
            break;
        }
    }
    if largest == 0.0 {
        return remarks;
    }
    let lowest = pixels().fold(0.0, f64::min);
    let error = rendering.estimated_error().unwrap_or(0.0);
    if -lowest > 2.0 * error.max(1e-9) * largest {
        let text = format!(
            "pixels are negative, down to {:.2} of the largest |pixel|: is the emission rate meant to be?",
            lowest / largest
        );
        remarks.push(Remark::new("rates", text));
    }
    let (number, bright) = (pixels().count(), pixels().filter(|p| p.abs() > FAINT * largest));
    let bright = bright.count();
    let share = bright as f64 / number.max(1) as f64;
    if number >= LEAST_PIXELS && share < LEAST_BRIGHT_SHARE {
        let field = match scene.camera.description().has_solid_angles {
            true => "a smaller `field_of_view`",
            false => "a smaller view",
        };
        let text = format!(
            "{} of {} pixels are above 1 % of the largest one: {field} would show more of the source, and a small \
             bright spot is found with [[seed]] or [[singularity]]",
            grouped(bright as u64),
            grouped(number as u64)
        );
        remarks.push(Remark::new("pixels", text));
    }
    remarks
}

/// Remarks on the cost.
pub(super) fn of_forecast(scene: &Scene, forecast: &Forecast) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let allowed = scene.render_options().max_evaluations;
    let is_counted =
        !matches!(scene.render.method, Method::Los(_)) || scene.render.max_evaluations.is_some();
    if is_counted && forecast.evaluations > allowed {
        let text = format!(
            "`max_evaluations`, {}, would end the rendering before its tolerance is met",
            grouped(allowed)
        );
        remarks.push(Remark::new("limits", text));
    }
    if let Some(seconds) =
        scene.render.max_seconds.filter(|&most| forecast.time.as_secs_f64() > most)
    {
        let text = format!(
            "`max_seconds`, {seconds}, would end the rendering before its tolerance is met"
        );
        remarks.push(Remark::new("limits", text));
    }
    remarks
}
