//! Coverage: scattered samples that tell how small a structure would have been seen.
//!
//! Lines lie on lattices, and what is compact may lie between all of them. So each layer of a view is
//! sampled at scattered points too, and each sample is compared with what the lines around it let
//! expect. From the samples that agree least an ascent looks for larger differences; what it finds gets
//! a line of the exam. How large a difference passes is known at each sample, and with it the size of
//! the Gaussian that is seen wherever it is.

use super::ascent::{self, Ascents};
use super::dyadic::spacing;
use super::engine::Engine;
use super::exam::{Lines, dyadic};
use super::image_tree::Place;
use super::lattice;
use super::local_fit::{Known, MOST_VALUES, expected};
use super::nearest::Nearest;
use super::sheet::Sheet;
use super::sights::Stop;
use super::{FEATURE_CONTRAST, FeatureSize, whole};
use crate::error::OptionError;
use crate::exchange::MethodError;
use crate::projection::Projection;
use crate::tile::Tile;
use rayon::prelude::*;

/// Scattered samples of a view, at the least: they see a Gaussian of 1/40 of the cube's edge.
const LEAST_SAMPLES: usize = 1024;
/// …and this share of all evaluations, so that expensive views are covered more finely.
const SHARE_OF_EVALUATIONS: f64 = 0.05;
/// A feature of which a sample has this share of its amplitude is seen, if the lines around agree among
/// themselves: what more samples are made for when a smaller feature is asked for.
pub(crate) const SEEN_SHARE: f64 = 4e-3;
/// Samples are doubled this often if a feature that was asked for is not covered.
const MOST_DOUBLINGS: u32 = 3;
/// No ascent begins below this share of the error allowed.
const ASCENT_FROM: f64 = 0.02;
/// What an ascent has found gets a line of the exam, or goes into an interpolant, from this share of the
/// error allowed on.
pub(crate) const LINE_FROM: f64 = 0.2;
/// Levels of depths around a sample on its line, down to a part of the feature.
const FEATURE_PARTS: f64 = 2.0;
/// Places and sizes that the size covered is found from: each size is this much larger than the former.
const PLACES: usize = 512;
const SMALLEST: f64 = 1e-3;
const SIZE_RATIO: f64 = 1.05;
const SIZES: i32 = 130;
/// Samples near a place that may see a feature there.
const NEAR: usize = 16;
/// The probability with which a feature is seen.
const PROBABILITY: f64 = 0.99;
/// √(2π): the integral of a Gaussian over its amplitude and standard deviation.
pub(crate) const WIDTH_OF_GAUSSIAN: f64 = 2.506_628_274_631_000_5;

/// The scattered samples of all layers of a view.
#[derive(Debug)]
pub(crate) struct Coverage {
    /// The feature that was asked for, as a fraction of the view's cube.
    wanted: Option<f64>,
    layers: Vec<LayerSamples>,
    /// The size of the feature that is covered, once it is known.
    pub(crate) smallest: Option<f64>,
}

/// The scattered samples of one layer.
#[derive(Debug, Default)]
pub(crate) struct LayerSamples {
    /// Points of the lattice that have been looked at, in view or not.
    number: usize,
    points: Vec<[f64; 3]>,
    /// G = g · ds/dz at the points.
    rates: Vec<f64>,
}

/// A sample beside what the lines around it let expect.
#[derive(Clone, Copy, Debug)]
struct Deviation {
    /// What the sample differs by, less the error of what was expected; in units of G.
    excess: f64,
    /// That error.
    error: f64,
    /// The error of a pixel for a rate of 1 along a unit of depth, over the error allowed.
    effect: f64,
}

impl LayerSamples {
    /// The scattered samples that a search for an interpolant has made, G times `density`.
    pub(crate) fn of_probes(
        points: &[[f64; 3]],
        rates: &[f64],
        density: impl Fn([f64; 2]) -> f64,
    ) -> Self {
        let rate = |(point, rate): (&[f64; 3], &f64)| match density([point[0], point[1]]) {
            0.0 => 0.0,
            density => rate / density,
        };
        let rates = points.iter().zip(rates).map(rate).collect();
        Self { number: points.len(), points: points.to_vec(), rates }
    }
}

impl Coverage {
    /// For features of a size that was asked for, with samples of the first layer that are `known`.
    pub(crate) fn new(wanted: Option<f64>, known: LayerSamples) -> Self {
        Self { wanted, layers: vec![known], smallest: None }
    }

    /// Whether what was asked for is covered.
    pub(crate) fn is_sufficient(&self) -> bool {
        match (self.wanted, self.smallest) {
            (Some(wanted), Some(smallest)) => smallest <= wanted,
            _ => true,
        }
    }
}

/// The size of a feature as a fraction of the view's cube.
pub(crate) fn fraction_of_view(size: FeatureSize, tiles: &[Tile<'_>]) -> Result<f64, MethodError> {
    match size {
        FeatureSize::Fraction(fraction) if fraction > 0.0 && fraction <= 1.0 => Ok(fraction),
        FeatureSize::Fraction(fraction) => Err(OptionError::FeatureFraction(fraction).into()),
        FeatureSize::Length(length) if !(length > 0.0 && length.is_finite()) => {
            Err(OptionError::FeatureLength(length).into())
        }
        FeatureSize::Length(length) => {
            let volume: f64 = tiles.iter().map(|tile| volume_of_view(tile.projection)).sum();
            let fraction = length / volume.cbrt();
            if !(volume.is_finite() && volume > 0.0) {
                return Err(OptionError::FeatureLengthOfInfiniteView(length).into());
            }
            Ok(fraction.min(1.0))
        }
    }
}

/// The volume in view, by differences at scattered points.
fn volume_of_view(projection: &dyn Projection) -> f64 {
    const POINTS: usize = 512;
    const STEP: f64 = 1e-4;
    let volume = |k: usize| {
        let u = lattice::point(k);
        if projection.world_from_canonical(u).path_per_depth == 0.0 {
            return 0.0;
        }
        let along = |axis: usize| {
            let [low, high] = [-STEP, STEP].map(|step| {
                let mut at = u;
                at[axis] = (at[axis] + step).clamp(0.0, 1.0);
                (at[axis], projection.world_from_canonical(at).position)
            });
            core::array::from_fn::<f64, 3, _>(|k| (high.1[k] - low.1[k]) / (high.0 - low.0))
        };
        let [a, b, c] = [along(0), along(1), along(2)];
        let cross = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        (a[0] * cross(1, 2) + a[1] * cross(2, 0) + a[2] * cross(0, 1)).abs()
    };
    (0..POINTS).map(volume).sum::<f64>() / POINTS as f64
}

/// The size, as a fraction of the view's cube, of the smallest Gaussian that so many scattered samples see
/// with a probability of 99 %, if its peak in the image is [`FEATURE_CONTRAST`] times the error allowed and
/// a rate of `passes` at a sample passes: a rate of 1 along a unit of depth is that error.
pub(crate) fn size_seen(samples: usize, passes: f64) -> f64 {
    // The amplitude falls with the size: some rounds find the size that fits.
    const ROUNDS: usize = 30;
    (0..ROUNDS).fold(0.1, |size, _| {
        let share = passes * WIDTH_OF_GAUSSIAN * size / FEATURE_CONTRAST;
        lattice::smallest_seen(samples, share.clamp(f64::MIN_POSITIVE, 0.99))
    })
}

impl Engine<'_> {
    /// Samples each layer at scattered points; the lines that are wanted where these differ from what is
    /// known, for each sheet, with depths; `target` is the error allowed, in the unit of the image.
    pub(crate) async fn examine_samples(&mut self, target: f64) -> Result<Vec<Lines>, Stop> {
        let layers = self.layers.len();
        self.coverage.layers.resize_with(layers, LayerSamples::default);
        let of_evaluations = SHARE_OF_EVALUATIONS * self.meter.evaluations() as f64;
        let of_feature =
            self.coverage.wanted.map_or(0, |size| lattice::points_to_see(size, SEEN_SHARE));
        let number = LEAST_SAMPLES.max(whole(of_evaluations)).max(of_feature);
        let mut number = (number / self.tiles.len()).next_power_of_two();
        for _ in 0..=MOST_DOUBLINGS {
            let mut lines = Vec::with_capacity(self.sheets.len());
            let mut smallest: Option<f64> = None;
            for layer in 0..layers {
                let (of_layer, size) = self.examine_layer(layer, number, target).await?;
                lines.push(of_layer);
                if let Some(size) = size {
                    smallest = Some(smallest.map_or(size, |of_others| of_others.max(size)));
                }
            }
            lines.resize_with(self.sheets.len(), Vec::new);
            self.coverage.smallest = smallest;
            if self.coverage.is_sufficient() || lines.iter().any(|of_layer| !of_layer.is_empty()) {
                return Ok(lines);
            }
            number *= 2;
        }
        Ok(vec![Vec::new(); self.sheets.len()])
    }

    /// The lines wanted on one layer after so many scattered samples, and the size that these cover, if
    /// anything is in view.
    async fn examine_layer(
        &mut self,
        layer: usize,
        number: usize,
        target: f64,
    ) -> Result<(Lines, Option<f64>), Stop> {
        let sheet = &self.sheets[layer];
        let samples = &mut self.coverage.layers[layer];
        sheet.sample_scattered(samples, number).await?;
        if samples.points.is_empty() {
            return Ok((Vec::new(), None));
        }
        let lines = sheet.scan.sights.nearest_full(&sheet.scan.tree, sheet.scan.tree.len());
        let examined = Examined { sheet, lines, target, number: samples.number };
        let deviations = examined.deviations(&samples.points, &samples.rates);
        let mut order: Vec<usize> = (0..deviations.len()).collect();
        let effect = |i: usize| examined.effect(&deviations[i]);
        order.sort_by(|&a, &b| effect(b).total_cmp(&effect(a)).then(a.cmp(&b)));
        let ascents = ascent::number(samples.points.len());
        let starts: Vec<usize> =
            order.iter().copied().take(ascents).filter(|&i| effect(i) > ASCENT_FROM).collect();
        // What is not followed passes: an excess below that of the last that is.
        let passed = order.get(ascents).map_or(0.0, |&i| effect(i)).max(ASCENT_FROM);
        let starts = starts.into_iter().map(|i| (samples.points[i], deviations[i])).collect();
        let is_open = |at: &[f64; 3]| sheet.is_open(at);
        let size = |of: &Deviation| examined.effect(of);
        let mut ascents = Ascents::new(starts, samples.number);
        while let Some(points) = ascents.next(is_open) {
            let at: Vec<(Place, u32)> = points.iter().map(steps).collect();
            let rates = sheet.scan.view.rates(&at).await?;
            ascents.take(examined.deviations(&points, &rates), size);
        }
        let found = ascents.best();
        let lines = found.iter().filter(|(_, of)| examined.effect(of) > LINE_FROM);
        let lines = lines.map(|(point, _)| examined.line_through(*point)).collect();
        let size = examined.size_covered(&samples.points, &deviations, passed);
        Ok((lines, Some(size)))
    }
}

impl Sheet<'_> {
    /// Whether a point is in view.
    fn is_open(&self, point: &[f64; 3]) -> bool {
        !self.scan.closes || self.scan.view.layer.is_open([point[0], point[1]])
    }

    /// Adds samples until so many points of the lattice have been looked at, those in view sampled.
    async fn sample_scattered(
        &self,
        samples: &mut LayerSamples,
        number: usize,
    ) -> Result<(), Stop> {
        let points = (samples.number..number).map(lattice::point);
        let new: Vec<[f64; 3]> = points.filter(|point| self.is_open(point)).collect();
        let rates = self.scan.view.rates(&new.iter().map(steps).collect::<Vec<_>>()).await?;
        samples.number = samples.number.max(number);
        samples.points.extend(new);
        samples.rates.extend(rates);
        Ok(())
    }
}

/// The line and the depth of a point.
fn steps(point: &[f64; 3]) -> (Place, u32) {
    let [x, y, depth] = point.map(dyadic);
    ([x, y], depth)
}

/// A sheet whose scattered samples are looked at.
struct Examined<'a, 'b> {
    sheet: &'a Sheet<'b>,
    /// Its full lines.
    lines: Nearest,
    /// The error allowed, in the unit of the image.
    target: f64,
    /// The number of scattered samples, in view or not.
    number: usize,
}

impl Examined<'_, '_> {
    /// The rates at points beside those of the lines around them.
    fn deviations(&self, points: &[[f64; 3]], rates: &[f64]) -> Vec<Deviation> {
        let both = points.par_iter().zip(rates);
        both.map(|(point, rate)| self.deviation(point, *rate)).collect()
    }

    fn deviation(&self, point: &[f64; 3], rate: f64) -> Deviation {
        let (place, depth) = steps(point);
        let scan = &self.sheet.scan;
        let near = self.lines.find(place, MOST_VALUES);
        let nearest = near.first().map_or(1.0, |(square, _)| (*square as f64).sqrt().max(1.0));
        let known = |&(_, i): &(u64, usize)| {
            let from = scan.tree.nodes()[i].place;
            let along = |axis: usize| (f64::from(from[axis]) - f64::from(place[axis])) / nearest;
            Known { place: [along(0), along(1)], value: scan.sights.lines[i].rate(depth) }
        };
        let known: Vec<Known> = near.iter().map(known).collect();
        let (value, error) = expected(&known).map_or((0.0, 0.0), |of| (of.value, of.error));
        let density = scan.view.layer.solid_angle_density([point[0], point[1]]);
        let [row, column] = self.sheet.pixel(place);
        let effect = density * self.sheet.scale[(row, column)] / self.target;
        Deviation { excess: (rate - value).abs() - error, error, effect }
    }

    /// What a feature as small as can be seen, with an amplitude of the excess, changes in a pixel, over
    /// the error allowed.
    fn effect(&self, of: &Deviation) -> f64 {
        of.excess.max(0.0) * of.effect * WIDTH_OF_GAUSSIAN * self.size()
    }

    /// The size that the samples are made for.
    fn size(&self) -> f64 {
        lattice::smallest_seen(self.number, SEEN_SHARE)
    }

    /// The line through a point, with depths around the point down to a part of a feature.
    fn line_through(&self, point: [f64; 3]) -> (Place, Vec<u32>) {
        let (place, depth) = steps(&point);
        let finest = (FEATURE_PARTS / self.size()).log2().ceil().clamp(1.0, 20.0);
        let base = self.sheet.scan.base_level;
        let levels = base..=u8::try_from(whole(finest)).unwrap_or(base).max(base);
        let around = |level: u8| {
            let step = spacing(level);
            let below = depth / step * step;
            [below, (below + step).min(spacing(0))]
        };
        (place, levels.flat_map(around).collect())
    }

    /// The standard deviation of the smallest Gaussian that is seen at 99 % of all places, if its peak in
    /// the image is [`FEATURE_CONTRAST`] times the error allowed: at one of the samples it is more than
    /// what passes there.
    fn size_covered(&self, points: &[[f64; 3]], deviations: &[Deviation], passed: f64) -> f64 {
        let of_pass = passed / (WIDTH_OF_GAUSSIAN * self.size());
        // What passes at a sample, in amplitudes of a Gaussian of size 1.
        let passes = |of: &Deviation| {
            (of.error * of.effect + of_pass) * WIDTH_OF_GAUSSIAN / FEATURE_CONTRAST
        };
        let passes: Vec<f64> = deviations.iter().map(passes).collect();
        let places = (0..PLACES).map(|k| lattice::point(2 * super::exam::FIRST_LINE + k));
        let places: Vec<[f64; 3]> = places.filter(|at| self.sheet.is_open(at)).collect();
        let size = |number: i32| SMALLEST * SIZE_RATIO.powi(number);
        let seen_from = |place: &[f64; 3]| {
            let squares = points.iter().zip(&passes).map(|(point, passes)| {
                ((0..3).map(|k| (point[k] - place[k]).powi(2)).sum::<f64>(), *passes)
            });
            let mut near: Vec<(f64, f64)> = squares.collect();
            let kept = NEAR.min(near.len());
            if kept < near.len() {
                near.select_nth_unstable_by(kept, |a, b| a.0.total_cmp(&b.0));
            }
            let is_seen = |number: &i32| {
                let size = size(*number);
                near[..kept]
                    .iter()
                    .any(|(square, passes)| (-0.5 * square / (size * size)).exp() >= passes * size)
            };
            (0..SIZES).find(is_seen).unwrap_or(SIZES)
        };
        let mut sizes: Vec<i32> = places.par_iter().map(seen_from).collect();
        sizes.sort_unstable();
        let last = whole((PROBABILITY * sizes.len() as f64).ceil()).max(1) - 1;
        sizes.get(last).map_or(f64::INFINITY, |&number| size(number))
    }
}
