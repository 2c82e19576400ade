//! The low-rank approximation: G as a sum of a few products of functions of x, y and z.
//!
//! A smooth G often has a low rank: along each axis it is a combination of a few functions, the
//! same everywhere in the cube. A few crosses of fibers then determine it, and an image costs
//! hundreds of evaluations where an image tree needs thousands. The residuals at the samples show
//! whether this is the case; if it is not, the search ends early and the image tree begins.
//!
//! * `chebyshev`: nested places on an axis and the polynomials through them;
//! * `fibers`: G along one axis, and the functions that its fibers span;
//! * `interpolant`: G on the cube and the image, from the fibers of all axes;
//! * `probes`: residuals at scattered points, and the error of each pixel;
//! * `jump`: detection of discontinuities;
//! * `search`: new crosses at the largest residuals;
//! * `forecast`, `trial_run`: the expected costs of the rest of the search and of the image tree.

mod chebyshev;
mod fibers;
mod forecast;
mod interpolant;
mod jump;
mod probes;
mod trial_run;
mod search;

use crate::cube::Cube;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::parallel::prelude::*;
use crate::radiance::{PixelRows, radiance_per_density};
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::engine::{base_evaluations, finest_level};
use crate::vol::lattice::points_to_detect;
use crate::vol::lowrank::forecast::Forecast;
use crate::vol::lowrank::probes::CellResiduals;
use crate::vol::lowrank::search::{End, Search, WeightedView};
use crate::vol::sampling::Stop;
use crate::vol::seeds::SeedTargets;
use crate::vol::tuning::TUNING;
use crate::vol::view::scattered::{LayerSamples, fraction_of_view, size_detected};

/// For tolerances from the first number on, the standard deviation of the Gaussians, in edges of
/// the cube, that the probes have to detect before the interpolant is accepted.
const SMALLEST: [(f64, f64); 3] = [(0.2, 0.045), (0.03, 0.034), (0.0, 0.025)];

/// Computes the image to the tolerance of `vol` from an interpolant of G, if that is possible.
pub(crate) async fn attempt(
    meter: &Meter,
    tiles: &[Tile<'_>],
    vol: &VolOptions,
) -> Result<Attempted, MethodError> {
    let nothing = Attempted::default();
    let &[tile] = tiles else { return Ok(nothing) };
    let layers = tile.projection.layers();
    let [layer] = &layers[..] else { return Ok(nothing) };
    let budget = meter.evaluations_left();
    let is_small = budget / TUNING.lowrank.least_budget < base_evaluations(vol.base_level);
    let finest_level = finest_level(tile.shape, vol.base_level);
    let targets = SeedTargets::at(&vol.seeds, &**layer, vol.base_level, finest_level);
    if is_small || tile.projection.has_regions() || !targets.are_none() {
        return Ok(nothing);
    }
    let wanted = vol.smallest_feature.map(|size| fraction_of_view(size, tiles)).transpose()?;
    let coarse = tile.shape.map(|pixels| pixels.min(TUNING.lowrank.coarse_pixels));
    let mut attempt = Attempt {
        meter,
        search: Search::new(WeightedView { meter, layer: &**layer }, vol.tolerance),
        pixels: PixelRows { projection: tile.projection, shape: tile.shape },
        coarse_scale: radiance_per_density(tile.projection, coarse),
        coarse_largest: None,
        tolerance: vol.tolerance.min(TUNING.engine.loosest_tolerance),
        most: TUNING.lowrank.most_budget_share * budget as f64,
        vol,
        wanted,
        smallest: None,
    };
    let found = match attempt.run().await {
        Ok(found) => Some(found),
        // If there is a time limit, this image is kept in case that lines give none before.
        Err(End::NotSeparable) if meter.deadline().is_some() => Some(attempt.unfinished()),
        Err(End::NotSeparable) => None,
        Err(End::Stopped(Stop::Budget)) => Some(attempt.unfinished()),
        Err(End::Stopped(Stop::Failed(error))) => return Err(error),
    };
    Ok(Attempted { found, samples: attempt.search.samples() })
}

/// The result of a search.
#[derive(Default)]
pub(crate) struct Attempted {
    /// The image to the tolerance, or the best one for a part of the budget; `None` if the image
    /// tree is expected to cost less or G is not separable.
    pub(crate) found: Option<MethodOutput>,
    /// The scattered samples of the search.
    pub(crate) samples: LayerSamples,
}

struct Attempt<'a> {
    meter: &'a Meter,
    search: Search<'a>,
    /// The rows of the requested image.
    pixels: PixelRows<'a>,
    /// The ratio of the radiance to the mean of the irradiance density, for the pixels of a coarser
    /// image.
    coarse_scale: Image,
    /// The largest |pixel| of the coarser image of the present interpolant, once it has been
    /// computed.
    coarse_largest: Option<f64>,
    tolerance: f64,
    /// The number of evaluations that the search may take.
    most: f64,
    vol: &'a VolOptions,
    /// The size of the smallest feature that the options name, as a fraction of the view's cube.
    wanted: Option<f64>,
    /// The size of the smallest feature that is covered, once it has been determined.
    smallest: Option<f64>,
}

impl Attempt<'_> {
    async fn run(&mut self) -> Result<MethodOutput, End> {
        self.search.probe().await?;
        let mut forecast = Forecast::new(TUNING.engine.stopping_share * self.tolerance);
        loop {
            let mut assessment = self.search.assess();
            self.show(&assessment.cell_residuals);
            let largest = *self.coarse_largest.get_or_insert_with(|| {
                let pixels = self.search.interpolant.pixels(shape_of(&self.coarse_scale));
                largest_of_rows(&self.coarse_scale, |row, values| pixels.row(row, values))
            });
            if !largest.is_finite() {
                // The sum overflows: the image tree finds the pixel for the message.
                return Err(End::NotSeparable);
            }
            let errors = assessment.cell_residuals.errors(shape_of(&self.coarse_scale));
            let error = largest_of_rows(&self.coarse_scale, |row, values| errors.row(row, values));
            let error = error / largest;
            if error <= TUNING.engine.stopping_share * self.tolerance
                && self.search.probes() < self.probes_needed()
            {
                self.search.probe().await?;
                continue;
            }
            if error <= TUNING.engine.stopping_share * self.tolerance {
                // The error has to be within the tolerance on the requested image, too.
                let maps = self.maps(&assessment.cell_residuals, self.pixels);
                if maps.largest_error / maps.largest
                    <= TUNING.engine.stopping_share * self.tolerance
                {
                    // A small structure may have affected one of the samples only.
                    let of_rate = self.coarse_scale.largest() / (self.tolerance * largest);
                    let passes = of_rate * self.search.last_followed();
                    self.smallest = Some(size_detected(
                        self.search.probes(),
                        passes.max(TUNING.lowrank.least_detected_rate),
                    ));
                    assessment = self.search.ascend(&assessment).await?;
                    // The errors including the residuals found by ascents, which are larger than
                    // those of the probes.
                    let maps = self.maps(&assessment.cell_residuals, self.pixels);
                    let is_complete = maps.largest_error <= self.tolerance * maps.largest;
                    if is_complete
                        && !assessment.is_significant_feature(of_rate, self.search.probes())
                    {
                        self.show_maps(&maps);
                        return Ok(self.found(maps, StopReason::Complete));
                    }
                }
            }
            let ranks = self.search.interpolant.ranks();
            if ranks.iter().any(|&rank| rank > TUNING.lowrank.most_functions) {
                return Err(End::NotSeparable);
            }
            if self.spent() > self.most
                || self.meter.share_of_time_left() < 1.0 - TUNING.lowrank.most_budget_share
            {
                return Err(Stop::Budget.into());
            }
            forecast.record(ranks, error);
            let missing = self.probes_needed().saturating_sub(self.search.probes());
            let shape = shape_of(&self.coarse_scale);
            let deadline = self.meter.deadline();
            let interpolant = &self.search.interpolant;
            if forecast.prefers_tree(interpolant, self.spent(), missing, shape, deadline) {
                return Err(End::NotSeparable);
            }
            self.coarse_largest = None;
            let before = self.search.interpolant.clone();
            if let Err(end) = self.search.grow(&assessment).await {
                self.search.interpolant = before;
                return Err(end);
            }
        }
    }

    fn spent(&self) -> f64 {
        self.meter.evaluations() as f64
    }

    /// The number of probes that have to agree before the interpolant is accepted.
    fn probes_needed(&self) -> usize {
        let of_tolerance = SMALLEST.iter().find(|(from, _)| self.vol.tolerance >= *from);
        let least = of_tolerance
            .map_or(0, |(_, size)| points_to_detect(*size, TUNING.lowrank.probe_detection_share));
        let beyond =
            self.search.interpolant.finest_level().saturating_sub(TUNING.lowrank.usual_fiber_level);
        let of_level = least << beyond;
        // A base lattice that is finer than the default is requested for small structure.
        let is_fine = self.vol.base_level > VolOptions::default().base_level;
        let of_base = if is_fine { base_evaluations(self.vol.base_level) } else { 0 };
        let of_feature = self
            .wanted
            .map_or(0, |size| points_to_detect(size, TUNING.verification.detection_share));
        of_level.max(of_feature).max(usize::try_from(of_base).unwrap_or(usize::MAX))
    }

    /// Image and error at the pixels of `rows`.
    fn maps(&self, cell_residuals: &CellResiduals, rows: PixelRows<'_>) -> Maps {
        let [height, width] = rows.shape;
        let (pixels, errors) =
            (self.search.interpolant.pixels(rows.shape), cell_residuals.errors(rows.shape));
        let (mut image, mut error) = (Image::zeros(height, width), Image::zeros(height, width));
        let of_row =
            |scale: &mut Vec<f64>, (row, (image, error)): (usize, (&mut [f64], &mut [f64]))| {
                scale.resize(width, 0.0);
                rows.radiances_per_density(row, scale);
                pixels.row(row, image);
                errors.row(row, error);
                let mut largest = [0.0; 2];
                for (largest, values) in largest.iter_mut().zip([image, error]) {
                    *largest = scale_and_find_largest(values, scale);
                }
                largest
            };
        let image_rows = image.pixels_mut().par_chunks_mut(width);
        let [largest, largest_error] = image_rows
            .zip(error.pixels_mut().par_chunks_mut(width))
            .enumerate()
            .with_min_len(rows.rows_at_once())
            .map_init(Vec::new, of_row)
            .reduce(|| [0.0; 2], |a, b| [larger(a[0], b[0]), larger(a[1], b[1])]);
        Maps { image, error, largest, largest_error }
    }

    /// Passes the current image to the observer of the rendering, if there is one and the rank is
    /// not 0.
    fn show(&self, cell_residuals: &CellResiduals) {
        if self.meter.keeps_images() && !self.search.interpolant.ranks().contains(&0) {
            self.show_maps(&self.maps(cell_residuals, self.pixels));
        }
    }

    fn show_maps(&self, Maps { image, error, .. }: &Maps) {
        if self.meter.keeps_images() {
            self.meter.show([image, error].map(|map| Cube::from_bands(vec![map.clone()])));
        }
    }

    /// The image of a search that ended before its goal.
    fn unfinished(&mut self) -> MethodOutput {
        let cell_residuals = self.search.assess().cell_residuals;
        self.found(self.maps(&cell_residuals, self.pixels), StopReason::Budget)
    }

    /// The result with the present image.
    fn found(&self, Maps { image, error, .. }: Maps, ending: StopReason) -> MethodOutput {
        let [cube, error] = [image, error].map(|map| Cube::from_bands(vec![map]));
        let mut made = MethodOutput::new(cube, Some(error), ending);
        made.base_level = Some(self.vol.base_level);
        made.smallest_feature = self.smallest;
        made
    }
}

/// An image and its error, with the largest |pixel| of each, which is infinite or NaN if a pixel
/// is.
struct Maps {
    image: Image,
    error: Image,
    largest: f64,
    largest_error: f64,
}

fn shape_of(image: &Image) -> [usize; 2] {
    [image.height(), image.width()]
}

/// The [larger] of all |value| that `fill` writes to rows, times the scale.
fn largest_of_rows(scale: &Image, fill: impl Fn(usize, &mut [f64])) -> f64 {
    let mut values = vec![0.0; scale.width()];
    let of_row = |(row, scale): (usize, &[f64])| {
        fill(row, &mut values);
        scale_and_find_largest(&mut values, scale)
    };
    scale.rows().enumerate().map(of_row).fold(0.0, larger)
}

/// Multiplies each value with its scale, and finds the [larger] of all their |value|.
fn scale_and_find_largest(values: &mut [f64], scale: &[f64]) -> f64 {
    let mut largest = 0.0;
    for (value, scale) in values.iter_mut().zip(scale) {
        *value *= scale;
        largest = larger(largest, value.abs());
    }
    largest
}

/// The larger of two numbers; NaN if one is NaN.
fn larger(a: f64, b: f64) -> f64 {
    if a < b || b.is_nan() { b } else { a }
}

#[cfg(test)]
mod tests;
