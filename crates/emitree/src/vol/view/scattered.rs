//! Scattered samples of a part of a view, the size of the structure that they detect, and lines through them.

use crate::cell::whole;
use crate::error::OptionError;
use crate::exchange::MethodError;
use crate::parallel::prelude::*;
use crate::projection::Projection;
use crate::rendering::RateAt;
use crate::tile::Tile;
use crate::vol::dyadic::{Place, from_unit, spacing};
use crate::vol::image::nearest::Nearest;
use crate::vol::least_squares::{DataPoint, MOST_VALUES, estimate};
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::part::ProductImage;
use crate::vol::view::sheet::Sheet;
use crate::vol::view::verification::Lines;
use crate::vol::view::verification_lines::FIRST_LINE;
use crate::vol::{FEATURE_CONTRAST, FeatureSize, lattice};

/// The number of places, and the sizes, for which coverage is computed: each size is larger than
/// the former one by the ratio.
const PLACES: usize = 512;
const SMALLEST: f64 = 1e-3;
const SIZE_RATIO: f64 = 1.05;
const SIZES: i32 = 130;
/// The probability with which a feature of the size covered is detected.
const PROBABILITY: f64 = 0.99;
/// √(2π): the integral of a Gaussian over its amplitude and standard deviation.
pub(crate) const WIDTH_OF_GAUSSIAN: f64 = 2.506_628_274_631_000_5;

/// The scattered samples of one part of a view.
#[derive(Debug, Default)]
pub(crate) struct PartSamples {
    /// The number of points of the lattice that have been used, in view or not.
    pub(crate) number: usize,
    pub(crate) points: Vec<[f64; 3]>,
    /// G = g · ds/dz at the points.
    pub(crate) rates: Vec<f64>,
}

/// The difference of a sample from the fit to the lines around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deviation {
    /// The |difference| less the expected error of the fit, in units of G.
    excess: f64,
    /// The expected error of the fit.
    error: f64,
    /// The error of a pixel for a rate of 1 along a unit of depth, in units of the error allowed.
    effect: f64,
}

impl PartSamples {
    /// The scattered samples of a search for an interpolant, which are G times `density`.
    pub(crate) fn of_probes(
        number: usize,
        points: &[[f64; 3]],
        rates: &[f64],
        density: impl Fn([f64; 2]) -> f64,
    ) -> Self {
        let rate = |(point, rate): (&[f64; 3], &f64)| match density([point[0], point[1]]) {
            0.0 => 0.0,
            density => rate / density,
        };
        let rates = points.iter().zip(rates).map(rate).collect();
        Self { number, points: points.to_vec(), rates }
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

/// The volume in view, from difference quotients at scattered points; infinite if a line of sight is.
fn volume_of_view(projection: &dyn Projection) -> f64 {
    const POINTS: usize = 512;
    const STEP: f64 = 1e-4;
    let volume = |k: usize| {
        let u = lattice::point(k);
        if projection.world_from_canonical(u).path_per_depth == 0.0 {
            return 0.0;
        }
        if is_infinite(projection, [u[0], u[1]]) {
            return f64::INFINITY;
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

/// Whether the line of sight at (x, y) is infinite: ds/dz is 0 at an infinite end, and grows without bound
/// towards it.
fn is_infinite(projection: &dyn Projection, [x, y]: [f64; 2]) -> bool {
    const BESIDE_END: f64 = 1e-3;
    const GROWTH: f64 = 1e3;
    let path = |z: f64| projection.world_from_canonical([x, y, z]).path_per_depth;
    let in_the_middle = path(0.5);
    let is_end = |end: f64, beside: f64| path(end) == 0.0 && path(beside) > GROWTH * in_the_middle;
    is_end(0.0, BESIDE_END) || is_end(1.0, 1.0 - BESIDE_END)
}

/// The size, as a fraction of the view's cube, of the smallest Gaussian that this number of samples
/// detects with a probability of 99 %. Its peak in the image is [`FEATURE_CONTRAST`] times the
/// error allowed, and a sample passes up to a rate of `passes`, in units of the rate along a unit
/// of depth that is the error allowed.
pub(crate) fn size_detected(samples: usize, passes: f64) -> f64 {
    // The amplitude decreases with the size: a fixed-point iteration finds the size.
    const ROUNDS: usize = 30;
    (0..ROUNDS).fold(0.1, |size, _| {
        let share = passes * WIDTH_OF_GAUSSIAN * size / FEATURE_CONTRAST;
        lattice::smallest_detected(samples, share.clamp(f64::MIN_POSITIVE, 0.99))
    })
}

impl Sheet<'_> {
    /// Adds samples until `number` points of the lattice have been used.
    pub(crate) async fn sample_scattered(
        &self,
        samples: &mut PartSamples,
        number: usize,
    ) -> Result<(), Stop> {
        let new: Vec<[f64; 3]> = (samples.number..number).map(lattice::point).collect();
        let rates = self.scan.view.rates(&new.iter().map(steps).collect::<Vec<_>>()).await?;
        samples.number = samples.number.max(number);
        samples.points.extend(new);
        samples.rates.extend(rates);
        Ok(())
    }
}

/// What is known of the parts of a view before their trees begin.
pub(crate) struct KnownParts {
    /// Scattered samples of each part.
    pub(crate) samples: Vec<PartSamples>,
    /// Of all points at which g is known, those few at which it is not that of most.
    pub(crate) hits: Vec<RateAt>,
    /// Of the others the nearest one to each of these.
    pub(crate) beside: Vec<RateAt>,
    /// The image of each part by products, if there is one.
    pub(crate) products: Vec<Option<ProductImage>>,
    /// The largest |pixel| of one of them.
    pub(crate) largest: f64,
    /// The size of the smallest feature that is covered in them.
    pub(crate) smallest: Option<f64>,
}

impl KnownParts {
    /// Nothing is known of so many parts.
    pub(crate) fn none(parts: usize) -> Self {
        Self {
            samples: (0..parts).map(|_| PartSamples::default()).collect(),
            hits: Vec::new(),
            beside: Vec::new(),
            products: vec![None; parts],
            largest: 0.0,
            smallest: None,
        }
    }
}

/// The place of the line and the depth of a point.
pub(crate) fn steps(point: &[f64; 3]) -> (Place, u32) {
    let [x, y, depth] = point.map(from_unit);
    ([x, y], depth)
}

/// A sheet with its lines, for the comparison with scattered samples.
pub(crate) struct ScatteredSheet<'a, 'b> {
    pub(crate) sheet: &'a Sheet<'b>,
    /// The full lines, for searches by place.
    pub(crate) lines: Nearest,
    /// The error allowed, in the unit of the image.
    pub(crate) target: f64,
    /// The number of scattered samples, in view or not.
    pub(crate) number: usize,
}

impl ScatteredSheet<'_, '_> {
    /// The differences of the rates at points from the fits to the lines around them.
    pub(crate) fn deviations(&self, points: &[[f64; 3]], rates: &[f64]) -> Vec<Deviation> {
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
            DataPoint { place: [along(0), along(1)], value: scan.node_lines.lines[i].rate(depth) }
        };
        let known: Vec<DataPoint> = near.iter().map(known).collect();
        let (value, error) = estimate(&known).map_or((0.0, 0.0), |of| (of.value, of.error));
        let density = scan.view.chart.density([point[0], point[1]]);
        let [row, column] = self.sheet.pixel(place);
        let effect = density * self.sheet.weighted_scale[(row, column)] / self.target;
        Deviation { excess: (rate - value).abs() - error, error, effect }
    }

    /// The change of a pixel by a feature of the smallest size that is detected, with the excess as
    /// its amplitude, in units of the error allowed.
    pub(crate) fn effect(&self, of: &Deviation) -> f64 {
        of.excess.max(0.0) * of.effect * WIDTH_OF_GAUSSIAN * self.size()
    }

    /// The size that the samples detect.
    fn size(&self) -> f64 {
        lattice::smallest_detected(self.number, TUNING.verification.detection_share)
    }

    /// The line through a point, with depths around the point down to a fraction of the size that
    /// is detected.
    pub(crate) fn line_through(&self, point: [f64; 3]) -> (Place, Vec<u32>) {
        let (place, depth) = steps(&point);
        let finest =
            (TUNING.verification.feature_parts / self.size()).log2().ceil().clamp(1.0, 20.0);
        let base = self.sheet.scan.base_level;
        let levels = base..=u8::try_from(whole(finest)).unwrap_or(base).max(base);
        let around = |level: u8| {
            let step = spacing(level);
            let below = depth / step * step;
            [below, (below + step).min(spacing(0))]
        };
        (place, levels.flat_map(around).collect())
    }

    /// Lines through those of the points at which known rates differ most from the fits to the lines around them, at
    /// a distance from each other.
    pub(crate) fn lines_beside(&self, PartSamples { points, rates, .. }: &PartSamples) -> Lines {
        let deviations = self.deviations(points, rates);
        let effects = deviations.iter().map(|of| self.effect(of)).enumerate();
        let mut differ: Vec<(usize, f64)> =
            effects.filter(|(_, effect)| *effect > TUNING.verification.sample_line_from).collect();
        differ.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut chosen: Vec<[f64; 3]> = Vec::new();
        for (number, _) in differ {
            let is_near = |other: &[f64; 3]| {
                (0..2).all(|axis| {
                    (other[axis] - points[number][axis]).abs()
                        < TUNING.verification.worst_line_distance
                })
            };
            if !chosen.iter().any(is_near) {
                chosen.push(points[number]);
            }
        }
        chosen.into_iter().map(|point| self.line_through(point)).collect()
    }

    /// The standard deviation of the smallest Gaussian that is detected at 99 % of all places, with
    /// a peak in the image of [`FEATURE_CONTRAST`] times the error allowed: at one of the samples
    /// it is above the limit that passes there.
    pub(crate) fn size_covered(
        &self,
        points: &[[f64; 3]],
        deviations: &[Deviation],
        passed: f64,
    ) -> f64 {
        let of_pass = passed / (WIDTH_OF_GAUSSIAN * self.size());
        // The limit at a sample, in units of the amplitude of a Gaussian of size 1.
        let passes = |of: &Deviation| {
            (of.error * of.effect + of_pass) * WIDTH_OF_GAUSSIAN / FEATURE_CONTRAST
        };
        let passes: Vec<f64> = deviations.iter().map(passes).collect();
        let places = (0..PLACES).map(|k| lattice::point(2 * FIRST_LINE + k));
        let places: Vec<[f64; 3]> = places.collect();
        let size = |number: i32| SMALLEST * SIZE_RATIO.powi(number);
        let detected_size = |place: &[f64; 3]| {
            let squares = points.iter().zip(&passes).map(|(point, passes)| {
                ((0..3).map(|k| (point[k] - place[k]).powi(2)).sum::<f64>(), *passes)
            });
            let mut near: Vec<(f64, f64)> = squares.collect();
            let kept = TUNING.verification.nearest_samples.min(near.len());
            if kept < near.len() {
                near.select_nth_unstable_by(kept, |a, b| a.0.total_cmp(&b.0));
            }
            let is_detected = |number: &i32| {
                let size = size(*number);
                near[..kept]
                    .iter()
                    .any(|(square, passes)| (-0.5 * square / (size * size)).exp() >= passes * size)
            };
            (0..SIZES).find(is_detected).unwrap_or(SIZES)
        };
        let mut sizes: Vec<i32> = places.par_iter().map(detected_size).collect();
        sizes.sort_unstable();
        let last = whole((PROBABILITY * sizes.len() as f64).ceil()).max(1) - 1;
        sizes.get(last).map_or(f64::INFINITY, |&number| size(number))
    }
}
