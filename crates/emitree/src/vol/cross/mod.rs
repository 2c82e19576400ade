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

use super::VolOptions;
use super::engine::{
    Found, LOOSEST_TOLERANCE, STOP, finest_level, first_look, radiance_per_density,
};
use super::seeds::Looks;
use super::sights::Stop;
use crate::cube::Cube;
use crate::emission::Emission;
use crate::error::RenderError;
use crate::image::Image;
use crate::meter::Meter;
use crate::render::{Frame, RenderOptions, Tile};
use crate::tree::Ending;
use core::ops::ControlFlow;
use forecast::Forecast;
use probes::Left;
use search::{End, Search, View};

/// A budget below so many first looks of the image tree is left to the tree…
const LEAST_BUDGET: u64 = 4;
/// …and no search takes more than this share of a budget.
const MOST_OF_BUDGET: f64 = 0.25;
/// While the search goes on, the image has no more pixels than this along a side.
const COARSE_PIXELS: usize = 64;
/// More functions along an axis than this, and the tree is better.
const MOST_FUNCTIONS: usize = 60;

/// Probes that have to agree for tolerances from each of these on.
const PROBES: [(f64, usize); 3] = [(0.2, 256), (0.03, 512), (0.0, 1024)];
/// Twice as many for each level beyond this that fibers need: there may be more of what is so small.
const USUAL_LEVEL: u8 = 6;

/// The image to the tolerance of `vol` from an interpolant of G, or the best one that a part of the
/// budget allows; `None` if an image tree is the better way, for all that is known.
pub(crate) fn attempt<E: Emission>(
    meter: &Meter<'_, E>,
    tiles: &[Tile<'_>],
    vol: &VolOptions,
    options: &RenderOptions<'_>,
) -> Result<Option<Found>, RenderError<E::Error>> {
    let &[tile] = tiles else { return Ok(None) };
    let layers = tile.projection.layers();
    let [layer] = &layers[..] else { return Ok(None) };
    let budget = meter.evaluations_left();
    let is_small = budget / LEAST_BUDGET < first_look(vol.base_level);
    let finest_level = finest_level(tile.shape, vol.base_level);
    let looks = Looks::at(options.seeds, &**layer, vol.base_level, finest_level);
    if is_small || tile.projection.has_regions() || !looks.are_none() {
        return Ok(None);
    }
    let coarse = tile.shape.map(|pixels| pixels.min(COARSE_PIXELS));
    let mut attempt = Attempt {
        meter,
        search: Search::new(View { meter, layer: &**layer }, vol.tolerance),
        scale: radiance_per_density(tile.projection, tile.shape),
        coarse_scale: radiance_per_density(tile.projection, coarse),
        tolerance: vol.tolerance.min(LOOSEST_TOLERANCE),
        options,
        most: MOST_OF_BUDGET * budget as f64,
        vol,
    };
    match attempt.run() {
        Ok(found) => Ok(Some(found)),
        Err(End::Hopeless) => Ok(None),
        Err(End::Stopped(Stop::Budget)) => {
            let left = attempt.search.judge().left;
            Ok(Some(attempt.found(&left, Ending::Budget)))
        }
        Err(End::Stopped(Stop::Failed(error))) => Err(error),
    }
}

struct Attempt<'a, 'b, E> {
    meter: &'a Meter<'b, E>,
    search: Search<'a, 'b, E>,
    /// Radiances over means of the irradiance density, for the pixels…
    scale: Image,
    /// …and for those of a coarser image.
    coarse_scale: Image,
    tolerance: f64,
    options: &'a RenderOptions<'a>,
    /// Evaluations that may be made.
    most: f64,
    vol: &'a VolOptions,
}

impl<E: Emission> Attempt<'_, '_, E> {
    fn run(&mut self) -> Result<Found, End<E::Error>> {
        self.search.probe()?;
        let mut forecast = Forecast::new(STOP * self.tolerance);
        loop {
            let judgement = self.search.judge();
            self.show(&judgement.left)?;
            let [image, error] = self.maps(&judgement.left, &self.coarse_scale);
            if !image.pixels().iter().all(|pixel| pixel.is_finite()) {
                // A sum beyond all numbers: the tree finds the pixel.
                return Err(End::Hopeless);
            }
            let error = error.largest() / image.largest();
            if error <= STOP * self.tolerance && self.search.probes() < self.probes_needed() {
                self.search.probe()?;
                continue;
            }
            if error <= STOP * self.tolerance {
                // The image of all pixels has to be as good.
                let found = self.found(&judgement.left, Ending::Complete);
                if found.estimated_error() <= STOP * self.tolerance {
                    return Ok(found);
                }
            }
            let ranks = self.search.interpolant.ranks();
            if ranks.iter().any(|&rank| rank > MOST_FUNCTIONS) {
                return Err(End::Hopeless);
            }
            if self.spent() > self.most {
                return Err(Stop::Budget.into());
            }
            forecast.note(ranks, error);
            let missing = self.probes_needed().saturating_sub(self.search.probes());
            let shape = [self.coarse_scale.height(), self.coarse_scale.width()];
            if forecast.prefers_tree(&self.search.interpolant, self.spent(), missing, shape) {
                return Err(End::Hopeless);
            }
            let before = self.search.interpolant.clone();
            if let Err(end) = self.search.grow(&judgement) {
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
        let of_tolerance = PROBES.iter().find(|(from, _)| self.vol.tolerance >= *from);
        let least = of_tolerance.map_or(0, |(_, probes)| *probes);
        let beyond = self.search.interpolant.finest_level().saturating_sub(USUAL_LEVEL);
        let of_level = least << beyond;
        // A base finer than usual was asked for because there is something small.
        let is_fine = self.vol.base_level > VolOptions::default().base_level;
        let of_base = if is_fine { first_look(self.vol.base_level) } else { 0 };
        of_level.max(usize::try_from(of_base).unwrap_or(usize::MAX))
    }

    /// Image and error at the pixels of `scale`.
    fn maps(&self, left: &Left, scale: &Image) -> [Image; 2] {
        let mut image = self.search.interpolant.image([scale.height(), scale.width()]);
        for (pixel, scale) in image.pixels_mut().iter_mut().zip(scale.pixels()) {
            *pixel *= scale;
        }
        [image, left.error_map(scale)]
    }

    /// Shows the image so far to those who want to see it.
    fn show(&self, left: &Left) -> Result<(), End<E::Error>> {
        let Some(callback) = self.options.frame else { return Ok(()) };
        if self.search.interpolant.ranks().contains(&0) {
            return Ok(()); // There is nothing to see yet.
        }
        let [image, error] = &self.maps(left, &self.scale);
        let (evaluations, batches) = (self.meter.evaluations(), self.meter.batches());
        match callback(&Frame { image, error, evaluations, batches }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Stop::Failed(RenderError::Interrupted).into()),
        }
    }

    /// The image as it is.
    fn found(&self, left: &Left, ending: Ending) -> Found {
        let [image, error] = self.maps(left, &self.scale);
        Found {
            cube: Cube::from_bands(vec![image]),
            error: Cube::from_bands(vec![error]),
            ending,
            base_level: self.vol.base_level,
            energies: Vec::new(),
        }
    }
}
