//! Requested lines of sight, through the surfaces and the pieces beside them.
//!
//! Where a line has an error beyond the tolerance, as beside a limb, G is sampled in those parts of it in which its region
//! is not certain: a few samples instead of those of a line without a model.

use crate::line_values::LineValues;
use crate::parallel::prelude::*;
use crate::vol::sampling::Stop;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::displaced::{Uncertain, error_of};
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::rays::{LineIntegral, Ray, Segment};
use crate::vol::surfaces::search::{Failure, Search};

/// The intervals in which an uncertain part of a line is sampled at first.
const INTERVALS: usize = 4;
/// The most times that these are halved.
const HALVINGS: usize = 16;
/// The share of the error allowed that all else may have on a line some of whose parts are sampled, and that is
/// aimed at with these.
const OF_OTHERS: f64 = 0.6;
const AIMED_AT: f64 = 0.8;
/// The error of a single line over that of its patches, up to what is aimed at: 99 % of the places of a surface are within
/// 2.4 times the error of their patch, and a line, unlike a pixel, is at one place of each.
const OF_ONE_PLACE: f64 = 3.0;

/// A line with its place in the chart.
struct Line {
    /// Its number among those of the request.
    number: usize,
    xy: [f64; 2],
    /// The depths between which it is seen.
    ends: [f64; 2],
}

/// A line of which some parts are sampled.
struct Sampled {
    line: Line,
    /// The integral and the error of all else.
    beside: LineIntegral,
    /// For each part depths, ascending, and G there.
    parts: Vec<Vec<[f64; 2]>>,
}

impl Search<'_> {
    /// The radiances along lines at places of the image plane, with errors.
    pub(super) async fn lines(
        &mut self,
        model: &Model,
        places: &[[f64; 2]],
    ) -> Result<LineValues, Failure> {
        let mut found = LineValues::unknown(places.len());
        let target = self.aim.target;
        let aim = &self.aim;
        let of_place = |(number, xy): (usize, &[f64; 2])| {
            let line = line(model, aim, number, *xy)?;
            let uncertain = model.uncertain(line.xy, line.ends);
            let integral = model.along(&line, aim, &uncertain);
            let is_good = integral.error <= target;
            let most = OF_OTHERS * target;
            let sampled = (!is_good).then(|| model.sampled(&line, aim, uncertain, most)).flatten();
            Some((line, integral, sampled))
        };
        let of_places: Vec<_> = places.par_iter().enumerate().map(of_place).collect();
        let mut lines = Vec::new();
        for (line, integral, sampled) in of_places.into_iter().flatten() {
            let of_places = (OF_ONE_PLACE * integral.error).min(AIMED_AT * target);
            found.set(line.number, [integral.value, integral.error.max(of_places)]);
            lines.extend(sampled.map(|of| Sampled { line, ..of }));
        }
        match self.sample_lines(&mut lines).await {
            Ok(()) => {}
            // The lines stay as they are, and so does the image.
            Err(Failure::TooComplex | Failure::Stopped(Stop::Budget)) => return Ok(found),
            Err(stopped) => return Err(stopped),
        }
        let edge = self.grid.edges[2];
        for of in &lines {
            let LineIntegral { value, error } = of.integral(edge);
            if error < found.errors[of.line.number] {
                found.set(of.line.number, [value, error]);
            }
        }
        Ok(found)
    }

    /// Samples the parts of lines until their errors are within the tolerance.
    async fn sample_lines(&mut self, lines: &mut [Sampled]) -> Result<(), Failure> {
        let edge = self.grid.edges[2];
        // At first all depths are new.
        let mut new: Vec<(usize, usize, usize)> = Vec::new();
        for (line, of) in lines.iter().enumerate() {
            for (part, depths) in of.parts.iter().enumerate() {
                new.extend((0..depths.len()).map(|depth| (line, part, depth)));
            }
        }
        for halvings in 0..=HALVINGS {
            if new.is_empty() {
                break;
            }
            let at = |&(line, part, depth): &(usize, usize, usize)| {
                let of: &Sampled = &lines[line];
                [of.line.xy[0], of.line.xy[1], of.parts[part][depth][0]]
            };
            let points: Vec<[f64; 3]> = new.iter().map(at).collect();
            let rates = self.rates(&points).await?;
            for ((line, part, depth), rate) in new.drain(..).zip(rates) {
                lines[line].parts[part][depth][1] = rate;
            }
            if halvings < HALVINGS {
                let target = AIMED_AT * self.aim.target;
                for (line, of) in lines.iter_mut().enumerate() {
                    let halved = of.halved(edge, target).into_iter();
                    new.extend(halved.map(|(part, depth)| (line, part, depth)));
                }
            }
        }
        Ok(())
    }
}

/// The line at a place of the image plane; `None` if there is none.
fn line(model: &Model, aim: &Aim<'_>, number: usize, xy: [f64; 2]) -> Option<Line> {
    let is_place = xy.iter().all(|along| (0.0..=1.0).contains(along));
    let place = match aim.sky {
        Some(sky) => sky.place_on_only(xy),
        None => Some(xy),
    };
    let place = place.filter(|_| is_place)?;
    let grid = &model.tree.grid;
    let xy = [0, 1].map(|k| place[k] * grid.edges[k]);
    Some(Line { number, xy, ends: aim.ends_of_line(grid, xy) })
}

impl Model {
    /// The integral along a line, with the error of what is uncertain of it.
    fn along(&self, line: &Line, aim: &Aim<'_>, uncertain: &[Uncertain]) -> LineIntegral {
        self.integral(line.xy, self.segments(line, aim).into_iter(), error_of(uncertain))
    }

    fn segments(&self, line: &Line, aim: &Aim<'_>) -> Vec<Segment> {
        let mut ray = Ray::default();
        self.follow(&mut ray, aim, None, line.xy);
        ray.segments
    }

    /// A line of which those uncertain parts that have the largest errors are to be sampled, so that all else has an
    /// error of at most `most`, in the unit of the image plane; `None` if that is not possible.
    fn sampled(
        &self,
        line: &Line,
        aim: &Aim<'_>,
        mut uncertain: Vec<Uncertain>,
        most: f64,
    ) -> Option<Sampled> {
        let edge = self.tree.grid.edges[2];
        let of_pieces = self.along(line, aim, &[]).error;
        uncertain.sort_by(|a, b| b.error.total_cmp(&a.error));
        let left = |count: &usize| of_pieces + error_of(&uncertain[*count..]) / edge;
        let count = (1..=uncertain.len()).find(|count| left(count) <= most)?;
        let of_others = error_of(&uncertain[count..]);
        uncertain.truncate(count);
        uncertain.sort_by(|a, b| a.ends[0].total_cmp(&b.ends[0]));
        // Rounding leaves no point behind a surface.
        let [first, last] = [line.ends[0] + 1e-9 * edge, line.ends[1] - 1e-9 * edge];
        let parts = uncertain.iter().map(|of| [of.ends[0].max(first), of.ends[1].min(last)]);
        let parts: Vec<[f64; 2]> = parts.filter(|[low, high]| low < high).collect();
        let mut beside = Vec::new();
        for Segment { label, ends: [mut low, end] } in self.segments(line, aim) {
            for [from, to] in &parts {
                if *from > low && low < end {
                    beside.push(Segment { label, ends: [low, from.min(end)] });
                }
                low = low.max(*to);
            }
            if low < end {
                beside.push(Segment { label, ends: [low, end] });
            }
        }
        let beside = self.integral(line.xy, beside.into_iter(), of_others);
        let depths = |[low, high]: [f64; 2]| {
            let at = |k: usize| low + (high - low) * k as f64 / INTERVALS as f64;
            (0..=INTERVALS).map(|k| [at(k), 0.0]).collect()
        };
        let parts: Vec<Vec<[f64; 2]>> = parts.into_iter().map(depths).collect();
        (!parts.is_empty()).then_some(Sampled { line: Line { ..*line }, beside, parts })
    }
}

impl Sampled {
    /// The integral, with the errors of pieces and those of jumps between samples.
    fn integral(&self, edge: f64) -> LineIntegral {
        let mut sum = self.beside;
        for [low, high] in self.parts.iter().flat_map(|of| intervals(of)) {
            sum.value += 0.5 * (high[0] - low[0]) * (low[1] + high[1]) / edge;
            sum.error += error_between(low, high) / edge;
        }
        sum
    }

    /// Halves the intervals with the largest errors, if the line has an error beyond `target`, and returns the numbers
    /// of the parts and of the new depths in them.
    fn halved(&mut self, edge: f64, target: f64) -> Vec<(usize, usize)> {
        if self.integral(edge).error <= target {
            return Vec::new();
        }
        let jumps = self.parts.iter().flat_map(|of| intervals(of));
        let jumps = jumps.filter(|[low, high]| error_between(*low, *high) > 0.0).count();
        let least = (target - self.beside.error) * edge / jumps.max(1) as f64;
        let mut new = Vec::new();
        for (number, part) in self.parts.iter_mut().enumerate() {
            let mut finer = vec![part[0]];
            for [low, high] in intervals(part) {
                if error_between(low, high) > least {
                    new.push((number, finer.len()));
                    finer.push([0.5 * (low[0] + high[0]), 0.0]);
                }
                finer.push(high);
            }
            *part = finer;
        }
        new
    }
}

/// The intervals between samples.
fn intervals(part: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    part.windows(2).map(|pair| [pair[0], pair[1]])
}

/// The error of the mean of two samples, in the unit of the grid: a jump is anywhere between.
fn error_between(low: [f64; 2], high: [f64; 2]) -> f64 {
    0.5 * (high[0] - low[0]) * (high[1] - low[1]).abs()
}
