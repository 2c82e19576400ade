//! Separable structure: G as a sum of few products of functions of x, y and z, if it is one.
//!
//! A smooth G is often of low rank: what it does along an axis is a mixture of few functions, the same
//! everywhere in the cube. Then a cross of fibers knows all of it, and the image costs hundreds of
//! evaluations where a tree needs thousands. Whether it is so, the evaluations tell as they come; if it
//! is not, the search ends early and the image tree begins.
//!
//! * `chebyshev`: nested places on an axis and the polynomials through them;
//! * `fibers`: G along one axis, and the functions that its fibers span;
//! * `interpolant`: G on the cube and the image, from the fibers of all axes;
//! * `probes`: scattered points that tell what is left, and the error of each pixel;
//! * `jump`: discontinuities, which no sum of products follows;
//! * `search`: fibers where most is left;
//! * `forecast`, `rehearsal`: what the rest of the search would cost, and what the image tree would.

mod chebyshev;
mod fibers;
mod forecast;
mod interpolant;
mod jump;
mod probes;
mod rehearsal;
mod search;

use crate::cube::Cube;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::method::Made;
use crate::radiance::{PixelRows, radiance_per_density};
use crate::tile::Tile;
use crate::tree::Ending;
use crate::vol::VolOptions;
use crate::vol::engine::{base_evaluations, finest_level};
use crate::vol::lattice::points_to_see;
use crate::vol::lowrank::forecast::Forecast;
use crate::vol::lowrank::probes::Left;
use crate::vol::lowrank::search::{End, Search, WeightedView};
use crate::vol::sampling::Stop;
use crate::vol::seeds::SeedTargets;
use crate::vol::tuning::TUNING;
use crate::vol::view::scattered::{LayerSamples, fraction_of_view, size_seen};
use rayon::prelude::*;

/// Standard deviations of Gaussians, in edges of the cube, that the probes have to see before the
/// interpolant is believed, for tolerances from each of these on…
const SMALLEST: [(f64, f64); 3] = [(0.2, 0.045), (0.03, 0.034), (0.0, 0.025)];

/// Tries the image to the tolerance of `vol` from an interpolant of G.
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
        most: TUNING.lowrank.most_of_budget * budget as f64,
        vol,
        wanted,
        smallest: None,
    };
    let found = match attempt.run().await {
        Ok(found) => Some(found),
        // If the time may end before there is an image from lines, this one is better than none.
        Err(End::NotSeparable) if meter.deadline().is_some() => Some(attempt.unfinished()),
        Err(End::NotSeparable) => None,
        Err(End::Stopped(Stop::Budget)) => Some(attempt.unfinished()),
        Err(End::Stopped(Stop::Failed(error))) => return Err(error),
    };
    Ok(Attempted { found, samples: attempt.search.samples() })
}

/// What a search has found.
#[derive(Default)]
pub(crate) struct Attempted {
    /// The image to the tolerance, or the best one that a part of the budget allows; none if an image tree
    /// is the better way, for all that is known.
    pub(crate) found: Option<Made>,
    /// Its scattered samples.
    pub(crate) samples: LayerSamples,
}

struct Attempt<'a> {
    meter: &'a Meter,
    search: Search<'a>,
    /// The image wanted…
    pixels: PixelRows<'a>,
    /// …and of a coarser one, radiances over means of the irradiance density…
    coarse_scale: Image,
    /// …and the largest |pixel| of what the interpolant says now, once it has been asked.
    coarse_largest: Option<f64>,
    tolerance: f64,
    /// Evaluations that may be made.
    most: f64,
    vol: &'a VolOptions,
    /// The feature that was asked for, as a fraction of the view's cube…
    wanted: Option<f64>,
    /// …and what is covered, once it is known.
    smallest: Option<f64>,
}

impl Attempt<'_> {
    async fn run(&mut self) -> Result<Made, End> {
        self.search.probe().await?;
        let mut forecast = Forecast::new(TUNING.engine.stop * self.tolerance);
        loop {
            let mut assessment = self.search.assess();
            self.show(&assessment.left);
            let largest = *self.coarse_largest.get_or_insert_with(|| {
                let pixels = self.search.interpolant.pixels(shape_of(&self.coarse_scale));
                largest_of_rows(&self.coarse_scale, |row, values| pixels.row(row, values))
            });
            if !largest.is_finite() {
                // A sum beyond all numbers: the tree finds the pixel.
                return Err(End::NotSeparable);
            }
            let errors = assessment.left.errors(shape_of(&self.coarse_scale));
            let error = largest_of_rows(&self.coarse_scale, |row, values| errors.row(row, values));
            let error = error / largest;
            if error <= TUNING.engine.stop * self.tolerance
                && self.search.probes() < self.probes_needed()
            {
                self.search.probe().await?;
                continue;
            }
            if error <= TUNING.engine.stop * self.tolerance {
                // The image of all pixels has to be as good.
                let maps = self.maps(&assessment.left, self.pixels);
                if maps.largest_error / maps.largest <= TUNING.engine.stop * self.tolerance {
                    // Something small may have touched one of the samples only.
                    let of_rate = self.coarse_scale.largest() / (self.tolerance * largest);
                    let passes = of_rate * self.search.last_followed();
                    self.smallest = Some(size_seen(
                        self.search.probes(),
                        passes.max(TUNING.lowrank.least_pass),
                    ));
                    assessment = self.search.ascend(&assessment).await?;
                    // The errors with what ascents have found, which is more than what probes have.
                    let maps = self.maps(&assessment.left, self.pixels);
                    let is_good = maps.largest_error <= self.tolerance * maps.largest;
                    if is_good && !assessment.hides_feature(of_rate, self.search.probes()) {
                        self.show_maps(&maps);
                        return Ok(self.found(maps, Ending::Complete));
                    }
                }
            }
            let ranks = self.search.interpolant.ranks();
            if ranks.iter().any(|&rank| rank > TUNING.lowrank.most_functions) {
                return Err(End::NotSeparable);
            }
            if self.spent() > self.most
                || self.meter.share_of_time_left() < 1.0 - TUNING.lowrank.most_of_budget
            {
                return Err(Stop::Budget.into());
            }
            forecast.note(ranks, error);
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

    /// The probes that have to agree before the interpolant is believed.
    fn probes_needed(&self) -> usize {
        let of_tolerance = SMALLEST.iter().find(|(from, _)| self.vol.tolerance >= *from);
        let least =
            of_tolerance.map_or(0, |(_, size)| points_to_see(*size, TUNING.lowrank.noticed));
        let beyond =
            self.search.interpolant.finest_level().saturating_sub(TUNING.lowrank.usual_level);
        let of_level = least << beyond;
        // A base finer than usual was asked for because there is something small.
        let is_fine = self.vol.base_level > VolOptions::default().base_level;
        let of_base = if is_fine { base_evaluations(self.vol.base_level) } else { 0 };
        let of_feature =
            self.wanted.map_or(0, |size| points_to_see(size, TUNING.verification.seen_share));
        of_level.max(of_feature).max(usize::try_from(of_base).unwrap_or(usize::MAX))
    }

    /// Image and error at the pixels of `rows`.
    fn maps(&self, left: &Left, rows: PixelRows<'_>) -> Maps {
        let [height, width] = rows.shape;
        let (pixels, errors) =
            (self.search.interpolant.pixels(rows.shape), left.errors(rows.shape));
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

    /// Shows the image so far, if somebody wants to see it and there is something to see.
    fn show(&self, left: &Left) {
        if self.meter.keeps_images() && !self.search.interpolant.ranks().contains(&0) {
            self.show_maps(&self.maps(left, self.pixels));
        }
    }

    fn show_maps(&self, Maps { image, error, .. }: &Maps) {
        if self.meter.keeps_images() {
            self.meter.show([image, error].map(|map| Cube::from_bands(vec![map.clone()])));
        }
    }

    /// The image of a search that has ended before its goal.
    fn unfinished(&mut self) -> Made {
        let left = self.search.assess().left;
        self.found(self.maps(&left, self.pixels), Ending::Budget)
    }

    /// The image as it is.
    fn found(&self, Maps { image, error, .. }: Maps, ending: Ending) -> Made {
        let [cube, error] = [image, error].map(|map| Cube::from_bands(vec![map]));
        let mut made = Made::new(cube, Some(error), ending);
        made.base_level = Some(self.vol.base_level);
        made.smallest_feature = self.smallest;
        made
    }
}

/// An image and its error, with the largest |pixel| of each; that is no number, or infinite, if a pixel
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

/// The larger of two numbers, or what is no number.
fn larger(a: f64, b: f64) -> f64 {
    if a < b || b.is_nan() { b } else { a }
}

#[cfg(test)]
mod tests;
