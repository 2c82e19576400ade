//! The lines of sight of one sum, and the error of the sum that follows from them.

use crate::exchange::MethodError;
use crate::output::MethodOutput;
use crate::sums::RegionSum;
use crate::vol::sampling::Stop;
use crate::vol::sums::View;
use crate::vol::sums::functional::Functional;
use crate::vol::sums::lines::{LineOfSight, integrals};
use crate::vol::sums::points::Points;
use crate::vol::sums::scattered::{Distribution, PlacePair};
use crate::vol::tuning::TUNING;

/// What lines may cost.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    /// The most evaluations for lines of one sum beyond the first ones.
    pub(super) most: f64,
}

/// The lines and points of one sum. They take part in no image, and are compared with each: points
/// where the image has a function of three coordinates, otherwise lines.
#[derive(Default)]
pub(super) struct Residuals {
    distribution: Option<Distribution>,
    pairs: Vec<Pair>,
    points: Points,
    /// Evaluations of all lines and points.
    evaluations: u64,
    /// Those of lines.
    of_lines: u64,
}

/// Two lines of sight on opposite sides of the centre of a pixel.
struct Pair {
    places: PlacePair,
    /// The mean of both, in the unit of the voxel, and the mean of their |errors|.
    value: f64,
    error: f64,
}

/// The differences between the lines and an image.
#[derive(Clone, Copy, Debug)]
struct Differences {
    /// The mean: an estimate of the error of the sum.
    mean: f64,
    /// Its standard error.
    deviation: f64,
    /// What the errors of the lines may contribute.
    of_lines: f64,
}

impl Differences {
    fn of(all: &[f64], of_lines: f64) -> Self {
        let number = all.len() as f64;
        let mean = all.iter().sum::<f64>() / number;
        let squares: f64 = all.iter().map(|of| (of - mean).powi(2)).sum();
        Self { mean, deviation: (squares / (number - 1.0) / number).sqrt(), of_lines }
    }

    /// The error of the sum.
    fn error(&self) -> f64 {
        self.mean.abs() + TUNING.sums.deviations * self.deviation + self.of_lines
    }

    /// The number of lines, in terms of the present one, for an error of `allowed`.
    fn more_for(&self, allowed: f64) -> Option<f64> {
        let left = allowed - self.mean.abs() - self.of_lines;
        let is_useful = self.mean.abs() <= TUNING.sums.mean_share * allowed && left > 0.0;
        is_useful.then(|| (TUNING.sums.deviations * self.deviation / left).powi(2))
    }
}

impl Residuals {
    /// The sum of an image with its error, from more lines if these are worthwhile.
    pub(super) async fn estimate(
        &mut self,
        view: View<'_>,
        functional: &Functional<'_>,
        made: &MethodOutput,
        budget: Budget,
    ) -> Result<RegionSum, MethodError> {
        let value = functional.value(&made.cube);
        let bound = functional.sum_of_errors(made.error.as_ref());
        let allowed = functional.sum.allowed(value);
        let mut found = None;
        if bound > allowed && allowed > 0.0 {
            found = self.differences_within(view, functional, made, allowed, budget).await?;
        }
        let error = found.map_or(bound, |found| found.error().min(bound));
        let by_lines = found.is_some_and(|found| found.error() < bound);
        let bands = match (&made.error, view.axis) {
            (Some(errors), Some(_)) => {
                let bands = made.cube.bands().iter().zip(errors.bands());
                bands
                    .map(|(band, errors)| {
                        [functional.of_band(band), functional.error_of_band(errors)]
                    })
                    .collect()
            }
            _ => Vec::new(),
        };
        Ok(RegionSum {
            name: functional.sum.name.clone(),
            kind: functional.sum.kind,
            value,
            error,
            allowed,
            samples: if by_lines { self.samples(made) } else { 0 },
            bands,
        })
    }

    /// The differences from an image, of so many lines that the error is within `allowed` if they cost no more
    /// than the budget; `None` if it does not suffice for the first lines.
    async fn differences_within(
        &mut self,
        view: View<'_>,
        functional: &Functional<'_>,
        made: &MethodOutput,
        allowed: f64,
        budget: Budget,
    ) -> Result<Option<Differences>, MethodError> {
        let tolerance = TUNING.sums.line_share * allowed / functional.total();
        let mut wanted = match &made.model {
            Some(_) => TUNING.sums.first_points,
            None => TUNING.sums.first_pairs,
        };
        let most = self.evaluations as f64 + budget.most;
        loop {
            let sampled = match &made.model {
                Some(_) => self.sample_points(view, functional, made, wanted).await,
                None => self.sample(view, functional, made, wanted, tolerance).await,
            };
            match sampled {
                Ok(()) => {}
                Err(Stop::Budget) if self.samples(made) == 0 => return Ok(None),
                Err(Stop::Budget) => return Ok(Some(self.differences(view, made))),
                Err(Stop::Failed(error)) => return Err(error),
            }
            let found = self.differences(view, made);
            let Some(factor) = found.more_for(allowed).filter(|_| found.error() > allowed) else {
                return Ok(Some(found));
            };
            let (now, cost) = match &made.model {
                Some(_) => (self.points.len() as f64, 1.0),
                None => {
                    let pairs = self.pairs.len() as f64;
                    (pairs, self.of_lines as f64 / pairs)
                }
            };
            // The next power of two: the places are most even there.
            let next = (factor.max(1.1) * now).log2().ceil().exp2();
            if self.evaluations as f64 + cost * (next - now) > most {
                return Ok(Some(found));
            }
            wanted = crate::cell::whole(next);
        }
    }

    /// Samples lines up to a number of pairs.
    async fn sample(
        &mut self,
        view: View<'_>,
        functional: &Functional<'_>,
        made: &MethodOutput,
        wanted: usize,
        tolerance: f64,
    ) -> Result<(), Stop> {
        let distribution = self
            .distribution
            .get_or_insert_with(|| Distribution::new(functional, made.error.as_ref()));
        let new = self.pairs.len()..wanted.max(self.pairs.len());
        let pairs: Vec<PlacePair> = new.map(|i| distribution.pair(functional, i)).collect();
        let lines: Vec<LineOfSight> = pairs
            .iter()
            .flat_map(|pair| [1.0, -1.0].map(|side| line_of_sight(view, pair, side)))
            .collect();
        let before = view.meter.evaluations();
        let found = integrals(view, &lines, tolerance).await;
        self.evaluations += view.meter.evaluations() - before;
        self.of_lines += view.meter.evaluations() - before;
        let found = found?;
        self.pairs.extend(pairs.into_iter().zip(found.chunks_exact(2)).map(|(places, both)| {
            Pair {
                places,
                value: 0.5 * (both[0][0] + both[1][0]),
                error: 0.5 * (both[0][1] + both[1][1]),
            }
        }));
        Ok(())
    }

    /// Samples points up to a number of them.
    async fn sample_points(
        &mut self,
        view: View<'_>,
        functional: &Functional<'_>,
        made: &MethodOutput,
        wanted: usize,
    ) -> Result<(), Stop> {
        let distribution = self
            .distribution
            .get_or_insert_with(|| Distribution::new(functional, made.error.as_ref()));
        let before = view.meter.evaluations();
        let pair = |i: usize| distribution.pair(functional, i);
        let sampled = self.points.sample(view, made.stretch, &pair, wanted).await;
        self.evaluations += view.meter.evaluations() - before;
        sampled
    }

    /// The number of lines or points that an image is compared with.
    fn samples(&self, made: &MethodOutput) -> usize {
        if made.model.is_some() { self.points.len() } else { 2 * self.pairs.len() }
    }

    fn differences(&self, view: View<'_>, made: &MethodOutput) -> Differences {
        if let Some(model) = &made.model {
            return Differences::of(&self.points.differences(&**model), 0.0);
        }
        let number = self.pairs.len() as f64;
        let difference = |Pair { places, value, .. }: &Pair| {
            let tile = &view.tiles[places.tile(view.tiles)];
            places.weight * (value - places.expected(&made.cube, tile))
        };
        let all: Vec<f64> = self.pairs.iter().map(difference).collect();
        let errors = self.pairs.iter().map(|pair| pair.places.weight.abs() * pair.error);
        Differences::of(&all, errors.sum::<f64>() / number)
    }
}

/// The line of sight at one of two places, its integral in the unit of the voxel.
fn line_of_sight(view: View<'_>, pair: &PlacePair, side: f64) -> LineOfSight {
    let number = pair.tile(view.tiles);
    let tile = &view.tiles[number];
    let [height, width] = tile.shape;
    let [u, v, e] = pair.offset;
    let (row, column) = (pair.voxel.pixel / width % height, pair.voxel.pixel % width);
    let x = (column as f64 + 0.5 + side * u) / width as f64;
    let y = (row as f64 + 0.5 + side * v) / height as f64;
    let area = 1.0 / (height as f64 * width as f64);
    let solid_angle = view.solid_angles.pixels()[pair.voxel.pixel];
    let scale = tile.projection.solid_angle_density([x, y]) * area / solid_angle;
    let (energy, scale) = match view.axis {
        None => (None, scale),
        Some(axis) => {
            let bins = axis.bins() as f64;
            let at = (pair.voxel.band as f64 + 0.5 + side * e) / bins;
            let mean = axis.width(pair.voxel.band) * bins;
            (Some(axis.energy(at)), scale * axis.energy_per_canonical(at) / mean)
        }
    };
    LineOfSight { tile: number, xy: [x, y], energy, scale }
}
