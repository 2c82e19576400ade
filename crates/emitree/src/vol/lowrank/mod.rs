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
//! * `maps`: image and error of a part;
//! * `attempted`: the result of the searches of all parts;
//! * `rows`, `divided_rows`: the image row by row, of an image plane and of charts;
//! * `channel`: products at one energy;
//! * `spectral_places`, `cube`: a spectral cube, from products at a few energies;
//! * `frozen`: the interpolant as a linear map from its values at the pivots;
//! * `jump`: detection of discontinuities;
//! * `kinks`: kinks and jumps at an azimuth of a chart;
//! * `weighted_view`: G times the weights of its errors;
//! * `search`: new crosses at the largest residuals;
//! * `scaling`: a G in which about the same error is allowed everywhere;
//! * `weights`: the weights of errors while the image becomes known;
//! * `start`, `given`: functions of another G with which a search begins, and whether they suffice;
//! * `forecast`, `trial_run`: the expected costs of the rest of the search and of the image tree.

pub(crate) mod attempted;
mod chebyshev;
pub(crate) mod channel;
pub(crate) mod cube;
mod fibers;
mod forecast;
mod frozen;
mod given;
mod interpolant;
pub(crate) mod jump;
mod kinks;
mod maps;
mod probes;
mod rows;
mod divided_rows;
mod trial_run;
mod scaling;
mod search;
mod spectral_places;
pub(crate) mod start;
mod weighted_view;
mod weights;

use crate::error::{OptionError, RenderError};
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::projection::charts::FittedDepth;
use crate::projection::charts::depth::Weights;
use crate::projection::charts::stretch::Stretch;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::engine::{base_evaluations_of, finest_level, samples_wanted};
use crate::vol::featureless::{points_of_view, sky_factor};
use crate::vol::lowrank::attempted::{Attempted, Kink};
use crate::vol::lowrank::forecast::Forecast;
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::lowrank::kinks::Fiber;
use crate::vol::lowrank::maps::{Maps, largest_of_rows, shape_of};
use crate::vol::lowrank::search::{End, Probes, Search};
use crate::vol::lowrank::start::{Functions, Start};
pub(crate) use crate::vol::lowrank::weighted_view::WeightedView;
use crate::vol::sampling::{EnergySample, Stop};
use crate::vol::seeds::SeedTargets;
use crate::vol::tuning::TUNING;
use crate::vol::view::depths::{fitted, fitted_stretch};
use crate::vol::view::faces::reaches_faces;
use crate::vol::view::part::{Footing, Part, Parts, add};
use crate::vol::view::scattered::{fraction_of_view, size_detected};

/// Which image is searched for.
#[derive(Clone, Copy, Default)]
pub(crate) struct ImageOf<'a> {
    /// The energies at which G is sampled, with their weights; none without an energy axis.
    pub(crate) energies: &'a [(EnergySample, f64)],
    /// The |pixel| to which the tolerance is relative, unless another one is larger.
    pub(crate) least_largest: f64,
    /// Whether G at another energy has products: the view is divided as it has to be.
    pub(crate) is_further: bool,
}

/// Computes the image of each part of the view to the tolerance of `vol` from an interpolant of G, if
/// that is possible. The searches begin with the functions of `start`, if it is of these parts.
pub(crate) async fn attempt(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    vol: &VolOptions,
    start: Option<&Start>,
    probed: Vec<Probed>,
    of: ImageOf<'_>,
) -> Result<Attempted, MethodError> {
    let mut attempted = Attempted::none(parts);
    let is_fixed = meter.start().is_some_and(|start| start.is_fixed);
    let is_divided = parts.parts.iter().any(Part::is_tile_of_several);
    if start.is_some_and(|start| !start.has_functions()) {
        // Its trees are the image.
        return Ok(attempted);
    }
    if is_fixed && is_divided {
        return Err(OptionError::FixedMesh.into());
    }
    let budget = meter.evaluations_left();
    let is_small =
        budget / TUNING.lowrank.least_budget < base_evaluations_of(&parts.parts, vol.base_level);
    if (is_small && !is_fixed) || is_divided {
        return Ok(attempted);
    }
    let wanted = vol.smallest_feature.map(|size| fraction_of_view(size, tiles)).transpose()?;
    let finest_level = finest_level(tiles[0].shape, vol.base_level);
    let is_possible = |part: &Part<'_>| {
        let chart = &*part.chart;
        let targets = SeedTargets::at(&vol.seeds, chart, vol.base_level, finest_level);
        targets.are_none()
    };
    let sky_factor = sky_factor(tiles);
    let is_tree = |part: usize| start.is_some_and(|start| start.functions[part].is_none());
    let possible = parts.parts.iter().enumerate();
    let possible = possible.filter(|(number, part)| !is_tree(*number) && is_possible(part));
    let mut attempts: Vec<(usize, Attempt<'_>)> = possible
        .map(|(number, part)| {
            let attempt = Attempt {
                meter,
                search: Search::new(
                    WeightedView {
                        energies: of.energies,
                        ..WeightedView::new(meter, part, tiles.len())
                    },
                    vol.is_uniform().then_some(vol.tolerance),
                    of.is_further,
                ),
                start: start.and_then(|start| start.functions[number].clone()),
                part,
                parts: parts.parts.len(),
                sky_factor,
                coarse_scale: coarse_scale(part),
                coarse_largest: None,
                pixel_share: 1.0,
                largest_of_others: 0.0,
                of_others: None,
                error: None,
                largest_weighed: None,
                outside: &parts.outside,
                tolerance: vol.tolerance.min(TUNING.engine.loosest_tolerance),
                most: TUNING.lowrank.most_budget_share * budget as f64,
                vol,
                wanted,
                smallest: None,
                failed: None,
                before: 0,
            };
            (number, attempt)
        })
        .collect();
    let are_fixed =
        start.filter(|_| is_fixed).map(|start| start.functions.iter().flatten().count());
    if are_fixed.is_some_and(|fixed| attempts.len() < fixed) {
        return Err(OptionError::FixedMesh.into());
    }
    // All parts are probed first: the brightest one determines the error allowed in all.
    let mut probed = probed.into_iter();
    for (number, attempt) in &mut attempts {
        let own = |of: &Probed| of.part == *number && of.weights == attempt.weights(parts);
        if let Some(of) = probed.find(|of| of.part == *number).filter(own) {
            attempt.search.take_probes(of.probes);
            continue;
        }
        match attempt.search.probe(TUNING.lowrank.first_probes).await {
            Ok(()) => {}
            Err(Stop::Budget) => return Ok(attempted),
            Err(Stop::Failed(error)) => return Err(error),
        }
    }
    let may_divide = start.is_none() && !of.is_further;
    if parts.has_box && may_divide {
        let probed = attempts.iter().flat_map(|(_, attempt)| attempt.search.probed());
        let rates = probed.map(|([_, _, z], rate)| (z, rate));
        attempted.prefers_faces = reaches_faces(rates, vol.tolerance);
        if attempted.prefers_faces {
            return Ok(attempted);
        }
    }
    if !parts.has_fitted_depths() && !parts.has_layers() && may_divide {
        let fitted = |(_, attempt): &(usize, Attempt<'_>)| attempt.fitted_depth(parts);
        attempted.depths = attempts.iter().filter_map(fitted).collect();
        attempted.stretch = attempts.iter().find_map(|(_, attempt)| attempt.fitted_stretch());
        if !attempted.depths.is_empty() || attempted.stretch.is_some() {
            let probed = |(number, attempt): &(usize, Attempt<'_>)| attempt.probed(*number, parts);
            attempted.probed = attempts.iter().map(probed).collect();
            return Ok(attempted);
        }
    }
    attempts.sort_by(|a, b| b.1.brightness().total_cmp(&a.1.brightness()));
    let mut largest = of.least_largest;
    let mut done: Option<[Image; 2]> = None;
    let is_only = parts.parts.len() == 1;
    for (number, mut attempt) in attempts {
        attempt.largest_of_others = largest;
        attempt.of_others = done.clone();
        attempt.before = meter.evaluations();
        let mut is_spare = false;
        let found = match attempt.run().await {
            Ok(found) => Some(found),
            // The other parts do not matter: all have products, or the image serves for nothing.
            Err(End::NotSeparable) if of.is_further => return Ok(attempted),
            Err(End::NotSeparable) => {
                attempted.kinks = attempt.kinks(parts).await?;
                attempted.prefers_halves = attempt.prefers_halves(parts);
                if !attempted.kinks.is_empty() || attempted.prefers_halves {
                    return Ok(attempted);
                }
                // If there is a time limit, the image is kept in case that lines give none before.
                is_spare = is_only && meter.deadline().is_some();
                is_spare.then(|| attempt.unfinished())
            }
            Err(End::Stopped(Stop::Budget))
                if is_only && attempt.search.interpolant.is_filled() =>
            {
                Some(attempt.unfinished())
            }
            Err(End::Stopped(Stop::Budget)) => None,
            Err(End::Stopped(Stop::Failed(error))) => return Err(error),
        };
        attempted.has_jump |= attempt.search.has_jump;
        attempted.known.samples[number] = attempt.search.samples();
        let Some((maps, ending)) = found else { continue };
        if ending == StopReason::FixedMesh && !is_fixed {
            attempted.functions_suffice = false;
            return Ok(attempted);
        }
        largest = largest.max(maps.largest);
        if !vol.is_uniform() {
            add(&mut done, attempt.on_pixels(&maps));
        }
        let before = (attempted.known.largest, attempted.known.smallest);
        attempted.add(number, &attempt, maps, ending, parts);
        if ending == StopReason::Budget {
            // An image tree follows, which must not take these products for finished ones.
            attempted.known.products[number] = None;
        }
        if is_spare {
            // It follows as if there were no limit.
            (attempted.known.largest, attempted.known.smallest) = before;
        }
    }
    Ok(attempted)
}

/// Returns an error if the budget does not suffice for the points of a fixed mesh and the first probes.
pub(crate) fn check_budget(start: &Start, allowed: u64) -> Result<(), MethodError> {
    // The first channel of a cube takes all of its probes before the next one has any.
    let probes = match start.cube {
        None => TUNING.lowrank.first_probes,
        Some(_) => points_of_view(0.0, 1.0),
    };
    let needed = start.points(probes) as u64;
    if needed <= allowed {
        return Ok(());
    }
    let what = "the points of the fixed mesh and samples that show its error".to_owned();
    Err(RenderError::Budget { what, needed, allowed })
}

/// The scale of a part on a raster that is not finer than needed for its largest pixel.
fn coarse_scale(part: &Part<'_>) -> Image {
    let shape = [part.scale.height(), part.scale.width()];
    part.scale_on(shape.map(|pixels| pixels.min(TUNING.lowrank.coarse_pixels)))
}

/// The first probes of a part, which serve as long as its chart has the same weights of the coordinates of depth.
#[derive(Debug)]
pub(crate) struct Probed {
    part: usize,
    weights: Option<Weights>,
    probes: Probes,
}

struct Attempt<'a> {
    meter: &'a Meter,
    search: Search<'a>,
    part: &'a Part<'a>,
    /// Functions of another G that may serve this one.
    start: Option<Functions>,
    /// The number of parts of the view.
    parts: usize,
    /// The number of probes of a view without structure in any of them, in units of that of narrow views.
    sky_factor: usize,
    /// The scale of the part on a coarser raster.
    coarse_scale: Image,
    /// The largest |pixel| of the coarser image of the present interpolant, once it has been
    /// computed.
    coarse_largest: Option<f64>,
    /// The largest |pixel| of the image over the largest mean over a cell of the raster, once the
    /// image has been computed: a pixel may consist of many cells.
    pixel_share: f64,
    /// The numbers of the pixels that belong to no image.
    outside: &'a [usize],
    /// The largest |pixel| of other parts, as far as they are known.
    largest_of_others: f64,
    /// The image of other parts with its error, as far as they are known and weights depend on it.
    of_others: Option<[Image; 2]>,
    /// The error of the image so far, if weights depend on it.
    error: Option<Image>,
    /// The largest |pixel| of those that matter, if the weights of errors are not all 1.
    largest_weighed: Option<f64>,
    tolerance: f64,
    /// The number of evaluations that the search may take.
    most: f64,
    vol: &'a VolOptions,
    /// The size of the smallest feature that the options name, as a fraction of the view's cube.
    wanted: Option<f64>,
    /// The size of the smallest feature that is covered, once it has been determined.
    smallest: Option<f64>,
    /// The newest fiber along the azimuth when the search failed.
    failed: Option<Fiber>,
    /// The number of evaluations before the search, which include those of other parts.
    before: u64,
}

impl Attempt<'_> {
    async fn run(&mut self) -> Result<(Maps, StopReason), End> {
        if let Some(functions) = self.start.take() {
            return Ok(self.by_functions(&functions).await?);
        }
        if self.vol.by_pixel.is_some_and(|of| of.rtol > 0.0) {
            let wanted = self.probes_needed().min(TUNING.lowrank.scaling_probes);
            while self.search.probes() < wanted {
                self.search.probe(wanted).await?;
            }
        }
        if let Some(scaling) = self.fitted_scaling() {
            let level = TUNING.lowrank.first_fiber_level;
            self.search.restart(Interpolant::new(level, Some(scaling)));
        }
        let goal = TUNING.engine.stopping_share * self.tolerance();
        let is_relative = self.vol.by_pixel.is_some_and(|of| of.rtol > 0.0);
        let mut forecast = Forecast::new(goal, is_relative);
        // Whether the weights are those of the errors of the present interpolant, and not of the one before.
        let mut has_present_weights = self.vol.is_uniform();
        loop {
            self.weigh();
            let mut assessment = self.search.assess();
            self.show(&assessment);
            let largest = *self.coarse_largest.get_or_insert_with(|| {
                let pixels = self.search.interpolant.pixels(shape_of(&self.coarse_scale));
                largest_of_rows(&self.coarse_scale, |row, values| pixels.row(row, values))
            });
            if !largest.is_finite() {
                // The sum overflows: the image tree finds the pixel for the message.
                return Err(End::NotSeparable);
            }
            let largest = (self.pixel_share * largest).max(self.largest_of_others);
            let largest = self.largest_weighed.unwrap_or(largest);
            let errors = assessment.cell_residuals.errors(shape_of(&self.coarse_scale));
            let error = largest_of_rows(&self.coarse_scale, |row, values| errors.row(row, values));
            self.keep_error(&assessment);
            // A dark part has no error, and no largest pixel.
            let relative = |error: f64| if error > 0.0 { error / largest } else { 0.0 };
            let error = relative(error);
            if error <= goal && !has_present_weights {
                has_present_weights = true;
                continue;
            }
            if error <= goal && self.search.probes() < self.probes_needed() {
                self.search.probe(self.probes_needed()).await?;
                continue;
            }
            if error <= goal {
                // The error has to be within the tolerance on the requested image, too.
                let mut maps = self.maps(&assessment);
                self.find_pixel_share(&mut maps);
                let of_image = maps.largest.max(self.largest_of_others);
                let of_image = self.largest_weighed.unwrap_or(of_image);
                if maps.largest_error <= goal * of_image {
                    // A small structure may have affected one of the samples only.
                    let of_rate = self.effect_of_rate(largest);
                    let passes = of_rate * self.search.last_followed();
                    let passes = passes.max(TUNING.lowrank.least_detected_rate);
                    let size = size_detected(self.search.probes(), passes);
                    self.smallest = Some(size / self.part.least_feature);
                    assessment = self.search.ascend(&assessment).await?;
                    // The errors including the residuals found by ascents, which are larger than
                    // those of the probes.
                    let mut maps = self.maps(&assessment);
                    maps.largest *= self.pixel_share;
                    let is_complete =
                        maps.largest_error <= self.accepted_share() * self.tolerance() * of_image;
                    if is_complete
                        && !assessment.is_significant_feature(of_rate, self.search.probes())
                    {
                        self.show_maps(&maps);
                        return Ok((maps, StopReason::Complete));
                    }
                }
            }
            let ranks = self.search.interpolant.ranks();
            if ranks.iter().any(|&rank| rank > TUNING.lowrank.most_functions) {
                return Err(End::NotSeparable);
            }
            if self.meter.kept_evaluations() as f64 > self.most
                || self.meter.share_of_time_left() < 1.0 - TUNING.lowrank.most_budget_share
            {
                return Err(Stop::Budget.into());
            }
            // Weights grow as errors fall: those without weights show the course.
            let without_weights = assessment.unweighted.as_ref().map_or(error, |unweighted| {
                let errors = unweighted.errors(shape_of(&self.coarse_scale));
                relative(largest_of_rows(&self.coarse_scale, |row, values| errors.row(row, values)))
            });
            forecast.darkest = self.vol.share_of_darkest(largest);
            forecast.record(ranks, without_weights);
            let missing = self.probes_needed().saturating_sub(self.search.probes());
            let shape = shape_of(&self.coarse_scale);
            let deadline = self.meter.deadline();
            let interpolant = &self.search.interpolant;
            if forecast.prefers_tree(interpolant, self.spent(), missing, shape, deadline) {
                return Err(End::NotSeparable);
            }
            self.coarse_largest = None;
            has_present_weights = self.vol.is_uniform();
            let before = self.search.interpolant.clone();
            if let Err(end) = self.search.grow(&assessment).await {
                self.failed = self.search.azimuth_fiber();
                self.search.interpolant = before;
                return Err(end);
            }
        }
    }

    /// The azimuths at which a chart has a kink or a jump, after a search that failed.
    async fn kinks(&mut self, parts: &Parts<'_>) -> Result<Vec<Kink>, MethodError> {
        if !parts.have_azimuths() {
            return Ok(Vec::new());
        }
        let Footing::Nodes { chart, window, .. } = &*self.part.footing else {
            return Ok(Vec::new());
        };
        let fiber = self.failed.take().or_else(|| self.search.azimuth_fiber());
        let Some(fiber) = fiber else { return Ok(Vec::new()) };
        match self.search.kinks(&fiber).await {
            Ok(found) => {
                let kink = |v| Kink { chart: *chart, window: *window, v };
                Ok(found.into_iter().map(kink).collect())
            }
            Err(Stop::Budget) => Ok(Vec::new()),
            Err(Stop::Failed(error)) => Err(error),
        }
    }

    /// Whether the depths of charts had better be divided at the points nearest to a centre, after a search that
    /// failed.
    fn prefers_halves(&self, parts: &Parts<'_>) -> bool {
        let Footing::Nodes { chart, .. } = &*self.part.footing else { return false };
        self.search.has_coarse_depths && !self.search.has_jump && parts.may_be_halved(*chart)
    }

    /// The weights of the coordinates of depth of its chart that are better for the probes.
    fn fitted_depth(&self, parts: &Parts<'_>) -> Option<FittedDepth> {
        let Footing::Nodes { chart, .. } = &*self.part.footing else { return None };
        let share = |(point, rate): ([f64; 3], f64)| {
            Some((rate * rate, self.part.chart.depth_shares(point)?))
        };
        let samples: Vec<(f64, Weights)> = self.search.probed().filter_map(share).collect();
        let present = parts.weights(*chart)?;
        parts.fitted_depth(*chart, fitted(&present, &samples)?)
    }

    /// The weights of the coordinates of depth in its chart.
    fn weights(&self, parts: &Parts<'_>) -> Option<Weights> {
        let Footing::Nodes { chart, .. } = &*self.part.footing else { return None };
        parts.weights(*chart)
    }

    /// Its probes, for a search in a view with other weights of some coordinates of depth.
    fn probed(&self, part: usize, parts: &Parts<'_>) -> Probed {
        Probed { part, weights: self.weights(parts), probes: self.search.own_probes() }
    }

    /// The stretch of the depth of an image plane that is better for the probes.
    fn fitted_stretch(&self) -> Option<Stretch> {
        if !self.part.footing.is_of_pixels() || self.parts > 1 {
            return None;
        }
        let samples = self.search.probed().map(|([_, _, z], rate)| (rate * rate, z));
        fitted_stretch(&samples.collect::<Vec<_>>())
    }

    /// The share of the tolerance that the error may have in the end. Beside other parts, some of
    /// the rest is that of their trees, and of the quadrature of pixels.
    fn accepted_share(&self) -> f64 {
        if self.parts == 1 { 1.0 } else { TUNING.lowrank.share_beside_parts }
    }

    /// The tolerance of the part: the errors of all parts on a line of sight add up.
    fn tolerance(&self) -> f64 {
        self.tolerance / self.part.pieces_of_line as f64
    }

    /// The error of a pixel for a rate of 1 along a unit of depth, in units of the error allowed.
    fn effect_of_rate(&self, largest: f64) -> f64 {
        if largest > 0.0 { self.coarse_scale.largest() / (self.tolerance() * largest) } else { 0.0 }
    }

    /// The mean |G| of the probes, as a measure of the brightness of the part.
    fn brightness(&self) -> f64 {
        self.coarse_scale.largest() * self.search.mean_rate()
    }

    /// The number of evaluations for this part, with its first probes.
    fn spent(&self) -> f64 {
        let first = TUNING.lowrank.first_probes.min(self.search.probes());
        (self.meter.evaluations() - self.before) as f64 + first as f64
    }

    /// The number of probes that have to agree before the interpolant is accepted.
    fn probes_needed(&self) -> usize {
        let in_part = |size: f64| self.part.least_feature * size;
        // Each part is a part of the view only, and small ones have structure too.
        let share = self.part.share.max(0.5 / self.parts as f64);
        let least = points_of_view(self.vol.tolerance, self.part.least_feature);
        let least = crate::cell::whole(share * least as f64);
        let beyond =
            self.search.interpolant.finest_level().saturating_sub(TUNING.lowrank.usual_fiber_level);
        // A view without emission in any sample has no fiber that shows its structure.
        let is_dark = self.search.probes() > 0
            && self.search.mean_rate() <= 0.0
            && self.largest_of_others <= 0.0;
        // Nor does one with the same rate everywhere.
        let is_featureless =
            is_dark || (self.sky_factor > 1 && self.parts == 1 && self.search.has_one_rate());
        let usual = if is_dark { TUNING.lowrank.dark_factor * least } else { least };
        let of_sky = self.sky_factor * TUNING.lowrank.dark_factor * least;
        let is_affordable = (of_sky as f64) < 0.5 * self.most;
        let least = if is_featureless && is_affordable { of_sky } else { usual };
        let of_level = least << beyond;
        let of_options = samples_wanted(self.vol, self.wanted.map(in_part));
        of_level.max(of_options)
    }
}

#[cfg(test)]
mod tests;
