//! The search for an interpolant: new crosses at the largest residuals, until the residuals are
//! small everywhere.

use crate::image::Image;
use crate::vol::ascent::{self, Ascents};
use crate::vol::lattice::{self, smallest_detected};
use crate::vol::lowrank::fibers::largest;
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::lowrank::jump::Steep;
use crate::vol::lowrank::probes::CellResiduals;
use crate::vol::lowrank::weighted_view::WeightedView;
use crate::vol::sampling::{Stop, are_one};
use crate::vol::tuning::TUNING;
use crate::vol::view::raster::cell_at;
use crate::vol::view::scattered::{PartSamples, WIDTH_OF_GAUSSIAN};
use nalgebra::DVector;

/// G at scattered points.
#[derive(Clone, Debug, Default)]
pub(super) struct Probes {
    /// The number of points of the lattice, in view or not.
    number: usize,
    points: Vec<[f64; 3]>,
    rates: Vec<f64>,
    /// The values of the present interpolant at the first points.
    values: Vec<f64>,
}

/// A point with its |residual|, times a weight.
pub(super) type Worst = ([f64; 3], f64);

fn worse(worst: Worst, (point, residual): Worst) -> Worst {
    if residual.abs() > worst.1 { (point, residual.abs()) } else { worst }
}

/// The state of the search: the interpolant so far and its probes.
pub(super) struct Search<'a> {
    pub(super) view: WeightedView<'a>,
    pub(super) interpolant: Interpolant,
    /// The weights of errors on the raster of the part; `None` if all are 1.
    pub(super) weights: Option<Image>,
    probes: Probes,
    /// The largest residual on the fibers, once it has been computed for the present interpolant.
    of_fibers: Option<Worst>,
    finest_level: u8,
    /// What the finest level may leave unresolved, in units of what others may.
    left_at_finest_level: f64,
    /// Whether the search has ended since G jumps.
    pub(super) has_jump: bool,
    /// Whether the fibers along the depth were too coarse at their finest level.
    pub(super) has_coarse_depths: bool,
}

/// What a refinement of axes has led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refined {
    /// All fibers are resolved, or as well as they can be; whether some axis was refined.
    Resolved { is_finer: bool },
    /// Some fibers are not resolved at the finest level.
    TooCoarse { is_finer: bool },
}

/// The residuals of an interpolant, times the weights of errors there.
pub(super) struct Assessment {
    pub(super) cell_residuals: CellResiduals,
    /// The same without weights, if these are not all 1.
    pub(super) unweighted: Option<CellResiduals>,
    /// The largest weighted |residual|.
    largest: f64,
    /// The next pivot, with the |residual| in the weights of pivots.
    worst: Worst,
}

impl Assessment {
    /// The same with errors times a factor.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.cell_residuals = self.cell_residuals.scaled(factor);
        self.unweighted = self.unweighted.map(|of| of.scaled(factor));
        self
    }

    /// Whether the largest residual, as the peak of the smallest feature that this number of
    /// samples detects, would change a pixel by a relevant share of the error allowed; `of_rate` is
    /// the error of a pixel for a rate of 1 along a unit of depth, in units of the error allowed.
    pub(super) fn is_significant_feature(&self, of_rate: f64, samples: usize) -> bool {
        let size = smallest_detected(samples, TUNING.verification.detection_share);
        self.largest * of_rate * WIDTH_OF_GAUSSIAN * size > TUNING.verification.sample_line_from
    }
}

/// Reasons for which a search ends without an image.
pub(super) enum End {
    /// G has too much structure for an interpolant.
    NotSeparable,
    Stopped(Stop),
}

impl From<Stop> for End {
    fn from(stop: Stop) -> Self {
        Self::Stopped(stop)
    }
}

impl<'a> Search<'a> {
    /// A search to a tolerance of the largest pixel; `None` if each pixel has a tolerance of its own. `is_further` says
    /// whether G at another energy has products.
    pub(super) fn new(view: WeightedView<'a>, tolerance: Option<f64>, is_further: bool) -> Self {
        let finest_level = match tolerance {
            Some(from) if from >= TUNING.lowrank.moderate_tolerance => {
                TUNING.lowrank.finest_fiber_level_if_moderate
            }
            // In dark pixels, fibers may have to be as fine as for small tolerances.
            _ => TUNING.lowrank.finest_fiber_level,
        };
        let left_at_finest_level = if tolerance.is_some() && !is_further {
            1.0
        } else {
            TUNING.lowrank.left_at_finest_level
        };
        let interpolant = Interpolant::new(TUNING.lowrank.first_fiber_level, None);
        Self {
            view,
            interpolant,
            weights: None,
            probes: Probes::default(),
            of_fibers: None,
            finest_level,
            left_at_finest_level,
            has_jump: false,
            has_coarse_depths: false,
        }
    }

    /// Discards what has been computed with other weights.
    pub(super) fn forget_weighted(&mut self) {
        self.of_fibers = None;
    }

    /// The weight of a residual in the choice of pivots: between that of the error and none, since fibers
    /// through dark places alone show little of the functions of bright ones.
    fn pivot_weight(&self, point: [f64; 3]) -> f64 {
        self.weight(point).powf(TUNING.lowrank.pivot_weight)
    }

    /// The weight of an error at a point.
    pub(super) fn weight(&self, point @ [u, v, _]: [f64; 3]) -> f64 {
        let weight = self.weights.as_ref().map_or(1.0, |weights| {
            weights.pixels()[cell_at([u, v], [weights.height(), weights.width()])]
        });
        weight / self.scale(point)
    }

    /// What G is multiplied with at a point.
    fn scale(&self, [u, v, _]: [f64; 3]) -> f64 {
        self.view.scaling.as_ref().map_or(1.0, |scaling| scaling.at([u, v]))
    }

    /// The assessment of residuals at points; `of_others` is the worst of other points, in the weights of
    /// pivots.
    fn assessment(&self, points: &[[f64; 3]], residual: &[f64], of_others: Worst) -> Assessment {
        let weighted: Vec<f64> =
            points.iter().zip(residual).map(|(point, of)| of * self.weight(*point)).collect();
        let unscaled = || -> Vec<f64> {
            points.iter().zip(residual).map(|(point, of)| of / self.scale(*point)).collect()
        };
        let unweighted = self.weights.as_ref().map(|_| CellResiduals::new(points, &unscaled()));
        let pivoted: Vec<f64> =
            points.iter().zip(residual).map(|(point, of)| of * self.pivot_weight(*point)).collect();
        let worst = points.iter().copied().zip(pivoted);
        let worst = worst.chain([of_others]).fold(([0.0; 3], 0.0), worse);
        let (at, residual) = of_others;
        let of_pivot = self.pivot_weight(at);
        let first = if of_pivot > 0.0 { residual / of_pivot * self.weight(at) } else { 0.0 };
        let largest = weighted.iter().fold(first, |most: f64, of| most.max(of.abs()));
        let cell_residuals = CellResiduals::new(points, &weighted);
        Assessment { cell_residuals, unweighted, largest, worst }
    }

    /// The scattered points with the largest residuals, in descending order, from which ascents
    /// begin.
    fn followed(&self) -> Vec<Worst> {
        let mut all = self.residuals();
        all.truncate(ascent::number(self.probes.number));
        all
    }

    /// The scattered points with their residuals, in descending order.
    pub(super) fn residuals(&self) -> Vec<Worst> {
        let Probes { points, rates, values, .. } = &self.probes;
        let of = |i: usize| (points[i], (rates[i] - values[i]).abs() * self.weight(points[i]));
        let mut all: Vec<Worst> = (0..values.len()).map(of).collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all
    }

    /// Whether a point is on a line of sight in view. Residuals elsewhere do not matter: pivots and
    /// probes are in view.
    pub(super) fn is_in_view(&self, [u, v, _]: [f64; 3]) -> bool {
        self.view.part.is_in_view([u, v])
    }

    /// Evaluates G at the triples of pivots at which it is not known.
    pub(super) async fn fill(&mut self) -> Result<(), Stop> {
        let rates = self.view.rates(&self.interpolant.missing()).await?;
        self.interpolant.fill(&rates);
        Ok(())
    }

    /// The smallest residual from which an ascent begins.
    pub(super) fn last_followed(&self) -> f64 {
        self.followed().last().map_or(0.0, |of| of.1)
    }

    /// Searches for larger residuals by ascents. Returns the residuals including the points found.
    pub(super) async fn ascend(&mut self, assessment: &Assessment) -> Result<Assessment, Stop> {
        let mut ascents = Ascents::new(self.followed(), self.probes());
        while let Some(points) = ascents.next() {
            let rates = self.view.rates(&points).await?;
            let values = self.interpolant.values(&points);
            let residual = |((rate, value), point): ((&f64, &f64), &[f64; 3])| {
                let weight = if self.is_in_view(*point) { self.weight(*point) } else { 0.0 };
                (rate - value).abs() * weight
            };
            let all = rates.iter().zip(&values).zip(&points);
            ascents.update(all.map(residual).collect(), |residual| *residual);
        }
        let found = ascents.best();
        let Probes { points, rates, values, .. } = &self.probes;
        let residual = rates.iter().zip(values).map(|(rate, value)| rate - value);
        let (mut points, mut residual): (Vec<[f64; 3]>, Vec<f64>) =
            (points.clone(), residual.collect());
        for (point, weighted) in found {
            let weight = self.weight(point);
            points.push(point);
            residual.push(if weight > 0.0 { weighted / weight } else { 0.0 });
        }
        Ok(self.assessment(&points, &residual, assessment.worst))
    }

    /// The mean |rate| of the probes.
    pub(super) fn mean_rate(&self) -> f64 {
        let rates = self.probed().map(|(_, rate)| rate.abs());
        rates.sum::<f64>() / self.probes.rates.len().max(1) as f64
    }

    /// Whether g is the same at all scattered points.
    pub(super) fn has_one_rate(&self) -> bool {
        let Probes { points, rates, .. } = &self.probes;
        let paths = points.iter().map(|point| self.view.site(*point).point.path_per_depth);
        let both = paths.zip(rates).filter(|(path, _)| *path > 0.0);
        are_one(both.map(|(path, rate)| rate / path))
    }

    /// The scattered points in view with their rates.
    pub(super) fn probed(&self) -> impl Iterator<Item = ([f64; 3], f64)> {
        let Probes { points, rates, .. } = &self.probes;
        points.iter().zip(rates).map(|(point, rate)| (*point, rate / self.scale(*point)))
    }

    /// The number of scattered points.
    pub(super) fn probes(&self) -> usize {
        self.probes.number
    }

    /// The scattered points with their rates, for another search on the same chart.
    pub(super) fn own_probes(&self) -> Probes {
        self.probes.clone()
    }

    /// Takes the scattered points of another search on the same chart.
    pub(super) fn take_probes(&mut self, probes: Probes) {
        self.probes = Probes { values: Vec::new(), ..probes };
    }

    /// The scattered samples, for the methods that follow.
    pub(super) fn samples(&self) -> PartSamples {
        let Probes { number, points, .. } = &self.probes;
        let rates: Vec<f64> = self.probed().map(|(_, rate)| rate).collect();
        PartSamples::of_probes(*number, points, &rates, |xy| self.view.part.chart.density(xy))
    }

    /// Takes the first scattered points, or about twice as many as before, up to `most`.
    pub(super) async fn probe(&mut self, most: usize) -> Result<(), Stop> {
        let first = self.probes();
        // Not in two steps, the second of which would add few.
        let number = if 2 * most <= 5 * first { most } else { 2 * first };
        let number = number.max(first + 1).max(TUNING.lowrank.first_probes);
        let points = (first..number).map(lattice::point);
        let points: Vec<[f64; 3]> = points.filter(|point| self.is_in_view(*point)).collect();
        self.probes.number = number;
        self.probes.rates.extend(self.view.rates(&points).await?);
        self.probes.points.extend(points);
        Ok(())
    }

    /// The residuals of the present interpolant at all probes and on all fibers.
    pub(super) fn assess(&mut self) -> Assessment {
        let Probes { points, rates, values, .. } = &mut self.probes;
        values.extend(self.interpolant.values(&points[values.len()..]));
        let residual: Vec<f64> =
            rates.iter().zip(values).map(|(rate, value)| rate - *value).collect();
        let of_fibers = self.of_fibers.unwrap_or_else(|| {
            (0..3).flat_map(|axis| self.worst_of_fibers(axis)).fold(([0.0; 3], 0.0), worse)
        });
        self.of_fibers = Some(of_fibers);
        self.assessment(&self.probes.points, &residual, of_fibers)
    }

    /// The largest residual on each fiber along an axis, with its point.
    fn worst_of_fibers(&self, axis: usize) -> Vec<Worst> {
        let fibers = &self.interpolant.axes[axis];
        let worst = |((&at, rates), values): ((&[f64; 2], &Vec<f64>), DVector<f64>)| {
            let place = |i: usize| point(axis, at, fibers.places()[i]);
            let both = rates.iter().zip(values.iter()).enumerate();
            let weighted = |(i, (rate, value))| (rate - value) * self.pivot_weight(place(i));
            let residual: Vec<f64> = both.map(weighted).collect();
            let is_in_view = |i: usize| self.is_in_view(place(i));
            let place = largest(&residual, is_in_view);
            place.map_or(([0.0; 3], 0.0), |place| {
                (point(axis, at, fibers.places()[place]), residual[place])
            })
        };
        let values = self.interpolant.along(axis, &fibers.at);
        fibers.at.iter().zip(&fibers.rates).zip(values).map(worst).collect()
    }

    /// Adds the fibers through the point of the largest residual, as far as they are not in the
    /// span of others.
    pub(super) async fn grow(&mut self, assessment: &Assessment) -> Result<(), End> {
        let (mut worst, mut moved) = (assessment.worst, None);
        self.probes.values.clear();
        self.of_fibers = None;
        for _ in 0..=TUNING.lowrank.most_moves {
            let (point, weighted) = worst;
            let weight = self.pivot_weight(point);
            let most = if weight > 0.0 { weighted / weight } else { weighted };
            if self.grow_at(point, most, moved).await? {
                return Ok(());
            }
            let axes = self.interpolant.axes.iter_mut().enumerate();
            axes.filter(|(axis, _)| Some(*axis) != moved).for_each(|(_, of)| of.drop_last());
            let (found, axis) = self.worst_beside(point).await?;
            (worst, moved) = (found, Some(axis));
            if worst.1 <= TUNING.lowrank.least_moved_share * weighted {
                break;
            }
        }
        Err(End::NotSeparable)
    }

    /// The largest residual at the points that have two coordinates of a point and one of a pivot, and the axis of
    /// the pivot. If all fibers through the point are in the span of others, its residual is a combination of theirs.
    async fn worst_beside(&self, point: [f64; 3]) -> Result<(Worst, usize), Stop> {
        let of_axis = |axis: usize| {
            let pivots = self.interpolant.axes[axis].pivots();
            let points = along(axis, others(axis, point), &pivots);
            points.into_iter().map(move |point| (point, axis))
        };
        let mut all: Vec<([f64; 3], usize)> = (0..3).flat_map(of_axis).collect();
        let is_other = |other: &[f64; 3]| other.map(f64::to_bits) != point.map(f64::to_bits);
        all.retain(|(other, _)| is_other(other) && self.is_in_view(*other));
        let points: Vec<[f64; 3]> = all.iter().map(|(point, _)| *point).collect();
        let rates = self.view.rates(&points).await?;
        let residuals = rates.iter().zip(self.interpolant.values(&points));
        let found = residuals.zip(all).map(|((rate, value), (point, axis))| {
            ((point, ((rate - value) * self.pivot_weight(point)).abs()), axis)
        });
        let larger = |a: (Worst, usize), b: (Worst, usize)| if b.0.1 > a.0.1 { b } else { a };
        Ok(found.fold(((point, 0.0), 0), larger))
    }

    /// Adds the fibers through a point with the residual `most`, but that along one axis if it is known to add
    /// nothing. Returns whether there are new functions or places.
    async fn grow_at(
        &mut self,
        point: [f64; 3],
        most: f64,
        known: Option<usize>,
    ) -> Result<bool, End> {
        let is_first = self.interpolant.ranks() == [0; 3];
        self.add_fibers(point, known).await?;
        if is_first {
            self.check_for_jumps(most).await?;
        }
        let resolved = if is_first {
            TUNING.lowrank.first_fiber_resolution
        } else {
            TUNING.lowrank.fiber_resolution
        };
        let mut is_new = [0, 1, 2].map(|axis| Some(axis) != known);
        let mut allowed = most;
        for reduction in 0..TUNING.lowrank.most_reductions {
            let mut has_grown = match self.resolve(resolved * allowed).await? {
                Refined::Resolved { is_finer } => is_finer,
                // Finer fibers do not help where those through this point are in the span of others.
                Refined::TooCoarse { is_finer } if reduction > 0 => {
                    if !is_finer {
                        return Ok(false);
                    }
                    true
                }
                Refined::TooCoarse { .. } => return Err(End::NotSeparable),
            };
            let part = self.view.part;
            for (axis, is_new) in is_new.iter_mut().enumerate() {
                let is_in_view = |at: [f64; 2], along: f64| {
                    let [u, v, _] = self::point(axis, at, along);
                    part.is_in_view([u, v])
                };
                let fibers = &mut self.interpolant.axes[axis];
                if *is_new
                    && fibers.extend_basis(TUNING.lowrank.least_new_share * allowed, is_in_view)
                {
                    *is_new = false;
                    has_grown = true;
                }
            }
            if has_grown {
                let new = self.interpolant.axes.iter_mut().zip(is_new).filter(|(_, new)| *new);
                new.for_each(|(fibers, _)| fibers.drop_last());
                self.fill().await?;
                return Ok(true);
            }
            allowed *= TUNING.lowrank.threshold_reduction;
        }
        Ok(false)
    }

    /// Replaces the interpolant by one whose residuals are not known yet.
    pub(super) fn restart(&mut self, interpolant: Interpolant) {
        let unscaled: Vec<f64> = self.probed().map(|(_, rate)| rate).collect();
        self.view.scaling = interpolant.scaling;
        let points = self.probes.points.iter().zip(unscaled);
        let scaled: Vec<f64> = points.map(|(point, rate)| rate * self.scale(*point)).collect();
        self.probes.rates = scaled;
        self.interpolant = interpolant;
        self.probes.values.clear();
        self.of_fibers = None;
    }

    /// The fibers through a point, but that along one axis if it is known, in one batch.
    async fn add_fibers(&mut self, point: [f64; 3], known: Option<usize>) -> Result<(), Stop> {
        let axes = &mut self.interpolant.axes;
        let added: Vec<usize> = (0..3).filter(|axis| Some(*axis) != known).collect();
        let of_axis = |&axis: &usize| along(axis, others(axis, point), axes[axis].places());
        let wanted: Vec<Vec<[f64; 3]>> = added.iter().map(of_axis).collect();
        let rates = self.view.rates_of_groups(&wanted).await?;
        for (axis, rates) in added.into_iter().zip(rates) {
            axes[axis].add(others(axis, point), rates);
        }
        Ok(())
    }

    /// Ends the search if G jumps on one of the newest fibers.
    async fn check_for_jumps(&mut self, most: f64) -> Result<(), End> {
        let axes = &self.interpolant.axes;
        let newest = |axis: usize| axes[axis].at.last().copied().unwrap_or_default();
        let mut steep: Vec<(usize, Steep)> =
            (0..3).filter_map(|axis| Some((axis, Steep::of_newest(&axes[axis], most)?))).collect();
        for _ in 0..TUNING.lowrank.steep_steps {
            let wanted =
                steep.iter().map(|(axis, steep)| along(*axis, newest(*axis), &steep.inside()));
            let rates = self.view.rates_of_groups(&wanted.collect::<Vec<_>>()).await?;
            let steepest_part = steep.iter().zip(rates);
            steep = steepest_part
                .filter_map(|((axis, steep), rates)| Some((*axis, steep.steepest_part(&rates)?)))
                .collect();
            if steep.is_empty() {
                return Ok(());
            }
        }
        self.has_jump = true;
        Err(End::NotSeparable)
    }

    /// Refines the axes until all of their fibers are resolved to `allowed`, or some would have to be finer than
    /// the finest level.
    async fn resolve(&mut self, allowed: f64) -> Result<Refined, End> {
        let mut is_finer = false;
        loop {
            let axes = &self.interpolant.axes;
            let coarse: Vec<usize> = (0..3).filter(|&axis| axes[axis].tail() > allowed).collect();
            if coarse.is_empty() {
                return Ok(Refined::Resolved { is_finer });
            }
            let most = self.left_at_finest_level * allowed;
            let is_finest = |axis: usize| axes[axis].level >= self.finest_level;
            let is_last = |axis: usize| axes[axis].level + 1 == self.finest_level;
            let is_too_coarse = |&axis: &usize| {
                (is_finest(axis) && axes[axis].tail() > most)
                    || (is_last(axis) && axes[axis].next_tail() > most)
            };
            if coarse.iter().any(is_too_coarse) {
                self.has_coarse_depths = coarse.contains(&2) && is_too_coarse(&2);
                return Ok(Refined::TooCoarse { is_finer });
            }
            let stays = |axis: usize| {
                is_finest(axis) || (is_last(axis) && axes[axis].next_tail() > allowed)
            };
            let refined: Vec<usize> = coarse.into_iter().filter(|axis| !stays(*axis)).collect();
            if refined.is_empty() {
                return Ok(Refined::Resolved { is_finer });
            }
            let of_axis = |&axis: &usize| {
                let places = axes[axis].new_places();
                axes[axis].at.iter().map(move |&at| along(axis, at, &places))
            };
            let wanted: Vec<Vec<[f64; 3]>> = refined.iter().flat_map(of_axis).collect();
            let mut rates = self.view.rates_of_groups(&wanted).await?.into_iter();
            for axis in refined {
                let fibers = &mut self.interpolant.axes[axis];
                let own: Vec<Vec<f64>> = rates.by_ref().take(fibers.at.len()).collect();
                fibers.refine(&own);
            }
            is_finer = true;
        }
    }
}

/// The coordinates of a point on the other two axes.
fn others(axis: usize, [x, y, z]: [f64; 3]) -> [f64; 2] {
    [[y, z], [x, z], [x, y]][axis]
}

/// The points of a fiber at the given places.
pub(super) fn along(axis: usize, at: [f64; 2], places: &[f64]) -> Vec<[f64; 3]> {
    places.iter().map(|&place| point(axis, at, place)).collect()
}

/// The point at `along` on the fiber at the coordinates `a` and `b` of the other two axes.
fn point(axis: usize, [a, b]: [f64; 2], along: f64) -> [f64; 3] {
    [[along, a, b], [a, along, b], [a, b, along]][axis]
}
