//! One rendering of a rehearsal: looser than that of the scene, or with fewer pixels.

use super::{Forecast, vol_of};
use crate::forecast::CostLaw;
use crate::grouped::grouped;
use crate::scene::{EmissionFailure, PixelLayout, Scene};
use emitree::los::Steps;
use emitree::progress::{Frame, Progress};
use emitree::refinement::Threshold;
use emitree::vol::Minimize;
use emitree::{
    Cube, Healpix, Image, Method, RenderError, Rendering, VolOptions, render, render_cube,
};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The tolerance that `vol` meets at least, however loose it is asked to be.
const LOOSEST: f64 = 0.05;
/// How much looser an error by pixel is, and the thresholds of trees.
const LOOSER: f64 = 5.0;
const THRESHOLDS: [f64; 2] = [64.0, 8.0];
/// The most pixels along a side: `los` has the same cost in each, `vol` hardly depends on them.
const LOS_PIXELS: usize = 16;
const VOL_PIXELS: usize = 256;
/// Forecasts from a stage that is 10^d times as loose are right within a factor of 1 + this · d, of `vol` and of
/// trees: docs/guide.md has the scenes on which that was measured.
const SPREAD: [f64; 2] = [1.8, 1.0];

/// A rendering that is `looseness` times as loose as that of the scene.
pub(super) struct Stage {
    method: Method,
    shape: [usize; 2],
    pub(super) looseness: f64,
    /// The pixels of the scene over those of the stage, where the cost is proportional to them.
    ratio_of_pixels: f64,
}

/// What a stage has made.
pub(super) struct Run {
    pub(super) evaluations: u64,
    pub(super) time: Duration,
    pub(super) end: StageEnd,
    /// Evaluations and error over largest pixel of intermediate images.
    course: Vec<(u64, f64)>,
}

/// How a stage ended.
pub(super) enum StageEnd {
    Ended(Box<Rendering<Cube>>),
    /// It would have taken too many evaluations.
    Cut,
}

impl Stage {
    /// The stages of a scene, the loosest one first.
    pub(super) fn all(scene: &Scene) -> Vec<Self> {
        let shape = [scene.height, scene.width];
        match &scene.render.method {
            Method::Vol(vol) => {
                let (mut vol, looseness) = looser(vol);
                // The evaluations of lines through all pixels say nothing of other images.
                vol.minimize = Minimize::Evaluations;
                let shape = if is_of_shape(&vol) { shape } else { shape_within(scene, VOL_PIXELS) };
                let looseness = if shape == [scene.height, scene.width] {
                    looseness
                } else {
                    looseness.max(1.0 + f64::EPSILON)
                };
                vec![Self { method: vol.into(), shape, looseness, ratio_of_pixels: 1.0 }]
            }
            Method::Paper(paper) => {
                let stage = |looseness: f64| {
                    let threshold = match paper.threshold {
                        Threshold::Absolute(size) => Threshold::Absolute(looseness * size),
                        Threshold::Relative(size) => Threshold::Relative(looseness * size),
                    };
                    let mut looser = *paper;
                    looser.threshold = threshold;
                    Self { method: looser.into(), shape, looseness, ratio_of_pixels: 1.0 }
                };
                THRESHOLDS.map(stage).into()
            }
            method => {
                let small = shape_within(scene, LOS_PIXELS);
                let pixels = |[height, width]: [usize; 2]| (height * width) as f64;
                let ratio_of_pixels = pixels(shape) / pixels(small);
                vec![Self { method: method.clone(), shape: small, looseness: 1.0, ratio_of_pixels }]
            }
        }
    }

    /// Renders the stage with at most so many evaluations.
    pub(super) fn run(
        &self,
        scene: &Scene,
        most: u64,
        progress: Option<&Progress<'_>>,
    ) -> Result<Run, RenderError<EmissionFailure>> {
        let started = Instant::now();
        let is_cut = AtomicBool::new(false);
        let course = Mutex::new(Vec::new());
        let spent = Mutex::new(0);
        let on_call = |evaluations: u64| {
            let mut spent = spent.lock().unwrap_or_else(PoisonError::into_inner);
            *spent = evaluations.max(*spent);
            if evaluations > most {
                is_cut.store(true, Ordering::Relaxed);
                return ControlFlow::Break(());
            }
            progress.map_or(ControlFlow::Continue(()), |progress| progress(evaluations))
        };
        let on_frame = |frame: &Frame<'_>| {
            let [largest, error] = [frame.image, frame.error].map(largest_of);
            let mut course = course.lock().unwrap_or_else(PoisonError::into_inner);
            course.push((frame.evaluations, error / largest));
            ControlFlow::Continue(())
        };
        let mut options = scene.render_options().with_progress(&on_call);
        options.method = self.method.clone();
        // The limits are those of the rendering, not of its rehearsal.
        options.max_seconds = f64::INFINITY;
        options.rounds = None;
        options.max_evaluations = options.max_evaluations.max(u64::MAX >> 1);
        if matches!(self.method, Method::Vol(_)) {
            options.frame = Some(&on_frame);
        }
        let camera = scene.camera.projection();
        let made = match scene.axis() {
            None => render(&scene.emission, camera, self.shape, &options).map(Into::into),
            Some(axis) => render_cube(&scene.emission, camera, self.shape, axis, &options),
        };
        let end = match made {
            Ok(rendering) => StageEnd::Ended(Box::new(rendering)),
            Err(RenderError::Interrupted) if is_cut.into_inner() => StageEnd::Cut,
            Err(error) => return Err(error),
        };
        let counted = spent.into_inner().unwrap_or_else(PoisonError::into_inner);
        let evaluations = match &end {
            StageEnd::Ended(rendering) => rendering.stats.evaluations,
            StageEnd::Cut => counted,
        };
        let course = course.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(Run { evaluations, time: started.elapsed(), end, course })
    }

    /// The evaluations of the stage with all pixels of the scene.
    pub(super) fn whole(&self, evaluations: u64) -> u64 {
        scaled(evaluations, self.ratio_of_pixels)
    }

    /// The forecast by a law through the stages so far, of which this is the last and took `needed`.
    pub(super) fn forecast(&self, scene: &Scene, law: CostLaw, run: &Run, needed: u64) -> Forecast {
        let is_los = matches!(self.method, Method::Los(_));
        let evaluations = law.evaluations_for(1.0).max(needed);
        let decades = self.looseness.max(1.0).log10();
        let spread = match (vol_of(scene), is_los) {
            (Some(_), _) => 1.0 + SPREAD[0] * decades,
            (None, false) => 1.0 + SPREAD[1] * decades,
            (None, true) if self.ratio_of_pixels <= 1.0 => 1.0,
            (None, true) => 1.3,
        };
        let is_uniform =
            matches!(&self.method, Method::Los(los) if matches!(los.steps, Steps::Fixed(_)));
        let is_exact = self.looseness <= 1.0 && self.ratio_of_pixels <= 1.0;
        let spread = if is_exact {
            1.0
        } else if is_uniform {
            spread.min(1.1)
        } else {
            spread
        };
        let range = [scaled(evaluations, 1.0 / spread).max(1), scaled(evaluations, spread)];
        let time = run.time.mul_f64(evaluations as f64 / run.evaluations.max(1) as f64);
        Forecast { evaluations, range, time, is_exact }
    }

    /// The forecast from the course of a stage that took too many evaluations.
    pub(super) fn forecast_of_cut(&self, scene: &Scene, run: &Run) -> Option<Forecast> {
        let tolerance = vol_of(scene).filter(|vol| vol.by_pixel.is_none())?.tolerance;
        let &(evaluations, error) = run.course.last()?;
        let law = CostLaw::of_course(&run.course, CostLaw::from(evaluations, error)?)?;
        let evaluations = law.evaluations_for(tolerance).max(run.evaluations);
        let time = run.time.mul_f64(evaluations as f64 / run.evaluations.max(1) as f64);
        let range = [run.evaluations, scaled(evaluations, 10.0)];
        Some(Forecast { evaluations, range, time, is_exact: false })
    }

    /// What was rendered, for people.
    pub(super) fn how(&self, scene: &Scene, run: &Run) -> String {
        let [height, width] = self.shape;
        let with_pixels = match self.shape == [scene.height, scene.width] {
            true => String::new(),
            false => format!(", {width} x {height} pixels"),
        };
        let ended = match run.end {
            StageEnd::Ended(_) => "",
            StageEnd::Cut => ", not to its end",
        };
        let what = match &self.method {
            Method::Vol(vol) if vol.by_pixel.is_some() => {
                format!("with {} times the error allowed", self.looseness)
            }
            Method::Vol(vol) => {
                format!("to {} % of the largest pixel", rounded(100.0 * vol.tolerance))
            }
            Method::Paper(_) => format!("with {} times the threshold", self.looseness),
            _ => "as it is".to_owned(),
        };
        format!("{what}{with_pixels}{ended}: {} evaluations", grouped(run.evaluations))
    }
}

/// Looser options, and how much looser they are.
fn looser(vol: &VolOptions) -> (VolOptions, f64) {
    let mut looser = vol.clone();
    if let Some(by_pixel) = &mut looser.by_pixel {
        let factor = if by_pixel.rtol > 0.0 { LOOSER.min(0.5 / by_pixel.rtol) } else { LOOSER };
        let factor = factor.max(1.0);
        by_pixel.rtol *= factor;
        by_pixel.atol *= factor;
        return (looser, factor);
    }
    looser.tolerance = vol.tolerance.max(LOOSEST);
    // A tolerance above the loosest one is met there.
    let looseness = looser.tolerance / vol.tolerance;
    (looser, looseness)
}

/// Whether options are of images of one shape.
fn is_of_shape(vol: &VolOptions) -> bool {
    vol.weights.is_some() || !vol.sums.is_empty()
}

/// The shape of the scene, reduced to so many pixels along its longer side.
fn shape_within(scene: &Scene, most: usize) -> [usize; 2] {
    let longest = scene.height.max(scene.width);
    match scene.camera.description().pixels {
        PixelLayout::Healpix => {
            let nside = scene.width.min((most / 4).next_power_of_two());
            Healpix::shape(nside)
        }
        PixelLayout::Rectangle if longest <= most => [scene.height, scene.width],
        PixelLayout::Rectangle => {
            [scene.height, scene.width].map(|pixels| (pixels * most).div_ceil(longest))
        }
    }
}

/// The largest |pixel|.
fn largest_of(image: &Image) -> f64 {
    image.pixels().iter().fold(0.0, |largest: f64, pixel| largest.max(pixel.abs()))
}

/// A number of evaluations times a factor.
fn scaled(evaluations: u64, factor: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a positive number, which saturates"
    )]
    let scaled = (evaluations as f64 * factor).round() as u64;
    scaled
}

/// A number without the last digits, which are of the binary number and not of what was written.
fn rounded(number: f64) -> f64 {
    format!("{number:.9e}").parse().unwrap_or(number)
}
