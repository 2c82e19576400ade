//! The final exam: lines of sight that took no part in an image tree, against what the tree says.
//!
//! An error estimate is made from the nodes themselves, and a structure between them is in none of it.
//! So a tree that is good enough by its own estimate is compared with other lines, integrated in full
//! from depths of their own: scattered ones, those where the estimate is largest, those through the
//! scattered samples that agree least with the lines around them, and, from the worst of all, some
//! nearby. Where one differs, the tree is refined and the exam is repeated with new lines; the former
//! ones stay and are compared again.

use super::developed::Developed;
use super::dyadic::{DEEPEST_LEVEL, STEPS, spacing, unit};
use super::engine::{Engine, within_budget};
use super::image_tree::{ImageTree, Node, Place};
use super::lattice;
use super::remaining::around;
use super::round::Scan;
use super::sheet::Sheet;
use super::sights::{Sights, Stop, View, Wanted, Way, base_depths};
use super::whole;
use crate::cell;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::parallel::prelude::*;
use rustc_hash::FxHashMap;

/// Scattered lines of one exam, at the least, shared among the sheets of a view…
const LEAST_LINES: usize = 12;
/// …and, with those of exams before, as many as this share of all evaluations so far pays for, if each costs
/// this many times as much as those that are integrated in full.
const SHARE_OF_EVALUATIONS: f64 = 0.1;
const COST_OF_LINE: f64 = 2.0;
/// Lines where the estimated error is largest, as a share of the scattered ones.
const WORST_SHARE: f64 = 0.5;
/// These are at least this far from each other, as a share of the image's edge.
const WORST_APART: f64 = 0.08;
/// Lines beside edges, where the image is continued from one side, as a share of the scattered ones.
const EDGE_SHARE: f64 = 0.5;
/// Places in a pixel that an edge crosses, of which the first that is in view is taken.
const PLACES_IN_PIXEL: usize = 16;
/// One ascent to larger differences for so many scattered lines…
const LINES_PER_ASCENT: usize = 8;
/// …in so many steps.
const STEPS_OF_ASCENT: usize = 3;
/// After an exam that failed both numbers are doubled, up to this many times as many.
const MOST_LINES: usize = 4;
/// An ascent begins at a difference of more than this share of the error allowed.
const ASCENT_FROM: f64 = 0.2;
/// A line fails if what it differs by is more than this share of the error allowed in a pixel.
const FAILED: f64 = 0.55;
/// …and of the error estimated there, of which a line may have more than the mean over its pixel; but no
/// line may differ by more than the error allowed.
const OVER_ESTIMATE: f64 = 1.5;
/// Once a line is integrated as a node would be, it is sampled at all depths of a lattice finer than
/// that of nodes by so many levels…
const FINER_DEPTHS: u8 = 1;
/// …and one in so many scattered lines by this many more levels: what all others step over, it sees.
const DENSE_LINES: usize = 3;
const DENSER: u8 = 2;
/// If that changes the integral by more than this share of the error allowed in a pixel, all lines of the
/// sheet are integrated more carefully (if two lines have to be changed, zodiacal light at 1 % is wrong by
/// 1.02 %):…
const STEPPED_OVER: f64 = 0.4;
/// …first to a tolerance stricter by this, where they have samples that lead on; that costs less than depths
/// everywhere, which made a tolerance of 5 % up to 2.3 times as expensive as 2 %…
const STRICTER: f64 = 0.25;
/// …then on a lattice of depths finer by so many levels at once, since the rules of all other nodes have to
/// be learned anew each time…
const FINER_AT_ONCE: u8 = 2;
/// …and finer than that of the base by so many levels at the most.
const MOST_FINER: u8 = 4;
/// Samples of a line that failed are given to nodes nearby if their significance is beyond this share of
/// the tolerance of a line.
const SHARED_SIGNIFICANCE: f64 = 0.25;
/// Lines are put on a lattice finer than the finest nodes by so many levels, or on this one: values
/// between nodes are predicted level by level.
const LEVELS_BELOW_NODES: u8 = 3;
const COARSEST_LATTICE: u8 = 10;
/// Lines that are compared by one thread at a time, at the least: those nearby need the same predictions.
const LINES_PER_TASK: usize = 64;
/// The number of the first scattered line in the lattice of scattered points: far beyond the samples.
pub(crate) const FIRST_LINE: usize = 1 << 24;

/// Places of lines, and the depths that each begins with.
pub(crate) type Lines = Vec<(Place, Vec<u32>)>;

/// Lines of a sheet that are no nodes of its tree.
#[derive(Debug, Default)]
pub(crate) struct Exam {
    /// Their places; there are no values.
    places: ImageTree,
    sights: Sights,
    /// What the finer depths have changed in the integral of each line.
    changes: Vec<f64>,
    /// Scattered places that have been used, and those beside edges.
    scattered: usize,
    at_edges: usize,
}

/// How an exam ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// No line differs by more than is allowed.
    Passed,
    /// New nodes are wanted.
    Failed,
    /// A line differs between nodes of the finest level.
    TooFine,
    /// The budget did not allow it.
    Unaffordable,
}

/// A line of an exam that differs from the tree.
#[derive(Clone, Copy, Debug)]
struct Difference {
    sheet: usize,
    /// The number of the line in the exam of its sheet.
    line: usize,
    /// The difference in the image, over the error allowed there.
    size: f64,
}

impl Engine<'_> {
    /// Compares the image with lines that it was not made from, and asks for nodes where they differ;
    /// `target` is the error allowed, in the unit of the image.
    pub(crate) async fn examine(
        &mut self,
        developed: &Developed,
        target: f64,
    ) -> Result<Verdict, MethodError> {
        let suspicious = match self.examine_samples(target).await {
            Err(Stop::Budget) => return Ok(Verdict::Unaffordable),
            Err(Stop::Failed(error)) => return Err(error),
            Ok(suspicious) => suspicious,
        };
        let mut places: Vec<Lines> = Vec::with_capacity(self.sheets.len());
        let made = self.meter.evaluations() - self.made_before;
        let affordable = SHARE_OF_EVALUATIONS * made as f64;
        let affordable = affordable / (COST_OF_LINE * self.cost_of_full_line());
        let examined: usize = self.sheets.iter().map(|sheet| sheet.exam.places.len()).sum();
        let times = self.lines_of_exam;
        let lines = (whole(affordable) * times).saturating_sub(examined).max(LEAST_LINES * times);
        let ascents = lines.div_ceil(LINES_PER_ASCENT);
        // Each place is in view on some of the layers of its tile.
        let energies = self.sheets.len() / self.layers.len();
        let lines = lines.div_ceil(energies * self.tiles.len());
        for (i, sheet) in self.sheets.iter_mut().enumerate() {
            let mut of_sheet = sheet.scattered_lines(lines);
            let worst = whole((WORST_SHARE * lines as f64).ceil());
            of_sheet.extend(sheet.worst_lines(developed.errors(sheet.tile), worst));
            of_sheet.extend(sheet.edge_lines(whole((EDGE_SHARE * lines as f64).ceil())));
            of_sheet.extend(suspicious[i].iter().cloned());
            places.push(of_sheet);
        }
        let tolerances = self.line_tolerances(target);
        let mut differences = Vec::new();
        let mut sizes = vec![Vec::new(); self.sheets.len()];
        let first: Vec<usize> = self.sheets.iter().map(|sheet| sheet.exam.places.len()).collect();
        for step in 0..=STEPS_OF_ASCENT {
            for i in 0..self.sheets.len() {
                let tolerance = tolerances[i / self.layers.len()] / self.sheets[i].layers as f64;
                let of_sheet = core::mem::take(&mut places[i]);
                if !within_budget(self.sheets[i].examine_lines(of_sheet, tolerance).await)? {
                    return Ok(Verdict::Unaffordable);
                }
            }
            differences = self.differences(target, &mut sizes);
            if step < STEPS_OF_ASCENT {
                let rising = differences.iter().filter(|of| of.size > ASCENT_FROM).take(ascents);
                for of in rising {
                    places[of.sheet].extend(self.sheets[of.sheet].beside(of.line));
                }
            }
        }
        let verdict = self.refine_lines(&first, developed, target).await?;
        if verdict != Verdict::Passed {
            return Ok(verdict);
        }
        differences.retain(|of| self.has_failed(of, developed, target));
        match self.refine_around(&differences, &tolerances).await? {
            Verdict::Passed if !self.coverage.is_sufficient() => Ok(Verdict::Unaffordable),
            verdict => {
                self.lines_of_exam = (2 * self.lines_of_exam).min(MOST_LINES);
                Ok(verdict)
            }
        }
    }

    /// Whether a line differs by more than the tree may say.
    fn has_failed(&self, of: &Difference, developed: &Developed, target: f64) -> bool {
        let sheet = &self.sheets[of.sheet];
        let [row, column] = sheet.pixel(sheet.exam.places.nodes()[of.line].place);
        let errors = developed.errors(sheet.tile);
        let estimate = errors.iter().map(|error| error[(row, column)]).fold(0.0, f64::max);
        of.size > FAILED && of.size > (OVER_ESTIMATE * estimate / target).min(1.0)
    }

    /// Evaluations of a line that is integrated in full, on average.
    fn cost_of_full_line(&self) -> f64 {
        let of_sheet = |sheet: &Sheet<'_>| {
            let sights = &sheet.scan.sights;
            let full = (0..sights.lines.len()).filter(|&i| sights.is_full(i));
            full.fold([0, 0], |[lines, samples], i| {
                [lines + 1, samples + sights.lines[i].samples.len()]
            })
        };
        let [lines, samples] = self
            .sheets
            .iter()
            .map(of_sheet)
            .fold([0, 0], |sum, of_sheet| core::array::from_fn(|k| sum[k] + of_sheet[k]));
        samples.max(1) as f64 / lines.max(1) as f64
    }

    /// Integrates the lines of those sheets more carefully of which a line of this exam, the lines from `first`
    /// on, has shown that the depths of nodes step over something. That has failed if there was one.
    async fn refine_lines(
        &mut self,
        first: &[usize],
        developed: &Developed,
        target: f64,
    ) -> Result<Verdict, MethodError> {
        let steps_over = |&i: &usize| {
            let (sheet, weight) = (&self.sheets[i], self.largest_weight(i));
            let Scan { base_level, depth_level, .. } = sheet.scan;
            // A line that grazes a surface on which g jumps steps over what only it meets.
            !sheet.scan.sights.tracks_jumps
                && depth_level < base_level + MOST_FINER
                && sheet.is_changed_by_depths(first[i], STEPPED_OVER * target / weight)
        };
        let sheets: Vec<usize> = (0..self.sheets.len()).filter(steps_over).collect();
        if sheets.is_empty() {
            return Ok(Verdict::Passed);
        }
        let is_first = !core::mem::replace(&mut self.is_strict, true);
        if is_first {
            self.line_share *= STRICTER;
        }
        let tolerances = self.line_tolerances(target);
        for i in sheets {
            let Sheet { scan, layers, .. } = &mut self.sheets[i];
            let tolerance = tolerances[i / self.layers.len()] / *layers as f64;
            let guarded = developed.guarded(i);
            let standing = scan.sights.standing();
            let refined = match is_first {
                true => scan.scan(scan.tree.len(), guarded, tolerance).await,
                false => scan.refine_depths(FINER_AT_ONCE, guarded, tolerance).await,
            };
            if !within_budget(refined)? {
                self.sheets[i].scan.sights.restore(&standing);
                return Ok(Verdict::Unaffordable);
            }
        }
        self.set_values(0);
        Ok(Verdict::Failed)
    }

    /// The largest weight of a sheet in an energy bin.
    fn largest_weight(&self, sheet: usize) -> f64 {
        let weights = &self.energies.learned[sheet / self.layers.len()].weights;
        weights.iter().fold(0.0, |most: f64, weight| most.max(weight.abs()))
    }

    /// What all lines of exams differ by, the largest first; `sizes` has, for each sheet, what the first of
    /// them change in a pixel, and gets those of the others.
    fn differences(&self, target: f64, sizes: &mut [Vec<f64>]) -> Vec<Difference> {
        let layers = self.layers.len();
        let mut differences = Vec::new();
        for (i, sheet) in self.sheets.iter().enumerate() {
            let earlier: Vec<&Sheet<'_>> =
                self.sheets[..i].iter().skip(i % layers).step_by(layers).collect();
            let learned = &self.energies.learned[i / layers];
            let weight = self.largest_weight(i);
            let known = sizes[i].len();
            sizes[i].extend(sheet.differences(known, &earlier, &learned.of_earlier));
            let of_line = |(line, &size): (usize, &f64)| Difference {
                sheet: i,
                line,
                size: size * weight / target,
            };
            differences.extend(sizes[i].iter().enumerate().map(of_line));
        }
        let order = |of: &Difference| (of.sheet, of.line);
        differences.sort_by(|a, b| b.size.total_cmp(&a.size).then(order(a).cmp(&order(b))));
        differences
    }

    /// Asks for nodes around lines that failed, and has the nodes nearby sampled where those were.
    async fn refine_around(
        &mut self,
        failed: &[Difference],
        tolerances: &[f64],
    ) -> Result<Verdict, MethodError> {
        let layers = self.layers.len();
        let mut verdict = Verdict::Passed;
        for of in failed {
            let sheet = &mut self.sheets[of.sheet];
            let tolerance = tolerances[of.sheet / layers] / sheet.layers as f64;
            let place = sheet.exam.places.nodes()[of.line].place;
            let level = sheet.level_around(place);
            if level >= self.finest_level {
                return Ok(Verdict::TooFine);
            }
            verdict = Verdict::Failed;
            let depths = sheet.exam.significant_depths(of.line, tolerance);
            if !within_budget(sheet.scan.sample_around(place, level, &depths, tolerance).await)? {
                return Ok(Verdict::Unaffordable);
            }
            sheet.scan.seeds.look_around(place, level + 1, &depths);
        }
        if verdict == Verdict::Failed {
            self.set_values(0);
        }
        Ok(verdict)
    }
}

impl Sheet<'_> {
    /// Scattered places that no exam has had, of those where the sheet is in view.
    fn scattered_lines(&mut self, count: usize) -> Lines {
        let base = self.scan.depth_level;
        let first = self.exam.scattered;
        self.exam.scattered += count;
        let place = |k: usize| {
            let [x, y, _] = lattice::point(FIRST_LINE + k);
            let finer = if k.is_multiple_of(DENSE_LINES) { DENSER } else { 0 };
            ([x, y].map(dyadic), base_depths(base + FINER_DEPTHS + finer))
        };
        (first..first + count).map(place).collect()
    }

    /// The middles of the pixels with the largest of the estimated `errors`, far from each other.
    fn worst_lines(&self, errors: Vec<&Image>, count: usize) -> Lines {
        let [height, width] = [self.scale.height(), self.scale.width()];
        let largest =
            |pixel: usize| errors.iter().map(|error| error.pixels()[pixel]).fold(0.0, f64::max);
        let in_view = (0..height * width).filter(|&pixel| self.scale.pixels()[pixel] != 0.0);
        let mut pixels: Vec<(f64, usize)> = in_view.map(|pixel| (largest(pixel), pixel)).collect();
        pixels.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut worst: Vec<[f64; 2]> = Vec::new();
        for (_, pixel) in pixels {
            if worst.len() == count {
                break;
            }
            let middle = [(pixel % width, width), (pixel / width, height)]
                .map(|(at, pixels)| (at as f64 + 0.5) / pixels as f64);
            let near = |other: &[f64; 2]| {
                (0..2).all(|axis| (other[axis] - middle[axis]).abs() < WORST_APART)
            };
            if !worst.iter().any(near) {
                worst.push(middle);
            }
        }
        let depths = base_depths(self.scan.depth_level + FINER_DEPTHS);
        worst.into_iter().map(|middle| (middle.map(dyadic), depths.clone())).collect()
    }

    /// Lines in some of the pixels that an edge crosses, others in each exam.
    fn edge_lines(&mut self, count: usize) -> Lines {
        let Some(shares) = &self.shares else { return Vec::new() };
        let [height, width] = [self.scale.height(), self.scale.width()];
        let crossed: Vec<usize> =
            (0..height * width).filter(|&pixel| shares.is_crossed[pixel]).collect();
        let first = self.exam.at_edges;
        self.exam.at_edges += count;
        let depths = base_depths(self.scan.depth_level + FINER_DEPTHS);
        let in_pixel = |k: usize| {
            let [number, ..] = lattice::point(FIRST_LINE + k);
            let pixel = *crossed.get(whole(number * crossed.len() as f64))?;
            let places = (0..PLACES_IN_PIXEL).map(|part| {
                let [_, x, y] = lattice::point(FIRST_LINE + PLACES_IN_PIXEL * k + part);
                let [column, row] = [pixel % width, pixel / width];
                [(column as f64 + x) / width as f64, (row as f64 + y) / height as f64]
            });
            let place = places.into_iter().find(|place| self.scan.view.layer.is_open(*place))?;
            Some((place.map(dyadic), depths.clone()))
        };
        (first..first + count).filter_map(in_pixel).collect()
    }

    /// The places around a line of the exam at half the distance of the nodes there.
    fn beside(&self, line: usize) -> Lines {
        let place = self.exam.places.nodes()[line].place;
        let distance = spacing(self.level_around(place) + 1);
        let depths = base_depths(self.scan.depth_level + FINER_DEPTHS);
        around(place, distance, 1)
            .filter(|(x, y, _)| *x == 0 || *y == 0)
            .map(|(_, _, place)| (place, depths.clone()))
            .collect()
    }

    /// The finest level of which all nodes of the cell around a place are there.
    fn level_around(&self, place: Place) -> u8 {
        let has_cell = |level: &u8| {
            let corner = place.map(|along| {
                let step = spacing(*level);
                (along / step).min(STEPS / step - 1) * step
            });
            let ends = |axis: usize| [corner[axis], corner[axis] + spacing(*level)];
            let is_there = |x: u32| ends(1).iter().all(|&y| self.scan.tree.find([x, y]).is_some());
            ends(0).into_iter().all(is_there)
        };
        let base = self.scan.base_level;
        let finer = (base + 1..=self.scan.tree.finest_level()).take_while(has_cell);
        finer.last().unwrap_or(base)
    }

    /// Integrates lines at places that are new, from the given depths and those of the lines nearby, each
    /// to `tolerance`.
    async fn examine_lines(&mut self, places: Lines, tolerance: f64) -> Result<(), Stop> {
        let Self { scan: Scan { view, tree, sights, depth_level, closes, .. }, exam, .. } = self;
        let first = exam.places.len();
        let mut own = Vec::new();
        let level = (tree.finest_level() + LEVELS_BELOW_NODES).max(COARSEST_LATTICE);
        for (place, depths) in places {
            let place = place.map(|along| nearest_of_level(along, level));
            let is_new = tree.find(place).is_none() && exam.places.find(place).is_none();
            if is_new && (!*closes || view.layer.is_open(place.map(unit))) {
                exam.places.add(place);
                own.push(depths);
            }
        }
        let new: Vec<Place> = exam.places.nodes()[first..].iter().map(|node| node.place).collect();
        exam.sights.grow(exam.places.len());
        let starts = sights.starts(tree, &new, tree.len(), tolerance, *depth_level);
        let [mut usual, mut finer]: [Wanted; 2] = [Vec::new(), Vec::new()];
        for (i, (own, (depths, brackets))) in (first..).zip(own.into_iter().zip(starts)) {
            exam.sights.ways[i] = Way::Full;
            exam.sights.expect(i, brackets);
            usual.push((i, depths));
            finer.push((i, own));
        }
        let looked = exam.integrate(view, [usual, finer], tolerance, *depth_level).await;
        if looked.is_err() {
            exam.places.truncate(first);
            exam.sights.truncate(first);
            exam.changes.truncate(first);
        }
        looked
    }

    /// Whether a line of this exam, which are those from `first` on, changes a pixel by more than `most` by its
    /// finer depths, in the unit of the image.
    fn is_changed_by_depths(&self, first: usize, most: f64) -> bool {
        let mut nodes = self.exam.places.nodes()[first..].iter().zip(&self.exam.changes[first..]);
        let has_changed = |(node, change): (&Node, &f64)| {
            let density = self.scan.view.layer.solid_angle_density(node.place.map(unit));
            let [row, column] = self.pixel(node.place);
            density * change * self.scale[(row, column)] > most
        };
        nodes.any(has_changed)
    }

    /// What each line of the exams from `first` on differs by from the tree, as an error of a pixel, in the unit of the
    /// image; `earlier` and `of_earlier` as in [`set_values`](Self::set_values).
    fn differences(&self, first: usize, earlier: &[&Self], of_earlier: &[f64]) -> Vec<f64> {
        let [height, width] = [self.scale.height(), self.scale.width()];
        let nodes = self.exam.places.nodes();
        let difference = |ghosts: &mut (Ghosts, Vec<Ghosts>), i: usize| {
            let place = nodes[i].place;
            let (own, of_others) = ghosts;
            let integral = self.exam.sights.lines[i].integral;
            let value = self.value_of(place, integral, earlier, of_earlier, of_others);
            let size = (value - self.scan.tree.value(place, own)).abs();
            // What is smaller than a pixel is a part of it.
            let distance = unit(spacing(self.level_around(place)));
            let share = (distance * width as f64).min(1.0) * (distance * height as f64).min(1.0);
            let [row, column] = self.pixel(place);
            size * share * self.scale[(row, column)]
        };
        let ghosts = || (Ghosts::default(), vec![Ghosts::default(); earlier.len()]);
        let lines = (first..nodes.len()).into_par_iter().with_min_len(LINES_PER_TASK);
        lines.map_init(ghosts, difference).collect()
    }
}

type Ghosts = FxHashMap<u64, f64>;

impl Exam {
    /// Integrates lines from the depths that nodes would begin with, then with their own besides.
    async fn integrate(
        &mut self,
        view: &View<'_>,
        [usual, finer]: [Wanted; 2],
        tolerance: f64,
        depth_level: u8,
    ) -> Result<(), Stop> {
        self.sights.refine(view, &self.places, usual, tolerance, depth_level).await?;
        let before: Vec<f64> = finer.iter().map(|(i, _)| self.sights.lines[*i].integral).collect();
        let numbers: Vec<usize> = finer.iter().map(|(i, _)| *i).collect();
        self.sights.refine(view, &self.places, finer, tolerance, depth_level).await?;
        let changes = numbers.into_iter().zip(before);
        self.changes
            .extend(changes.map(|(i, before)| (self.sights.lines[i].integral - before).abs()));
        Ok(())
    }

    /// The depths at which a line has found something.
    fn significant_depths(&self, line: usize, tolerance: f64) -> Vec<u32> {
        let samples = self.sights.lines[line].samples.iter();
        let significant =
            samples.filter(|of| of.opened || of.significance > SHARED_SIGNIFICANCE * tolerance);
        significant.map(|sample| sample.depth).collect()
    }
}

impl Scan<'_> {
    /// Has the nodes within a spacing of `level` sampled at the given depths and integrated in full, each
    /// to `tolerance`.
    async fn sample_around(
        &mut self,
        place: Place,
        level: u8,
        depths: &[u32],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let is_near = |at: Place| (0..2).all(|k| at[k].abs_diff(place[k]) <= spacing(level));
        let nodes = self.tree.nodes().iter().enumerate();
        let near = nodes.filter(|(i, node)| is_near(node.place) && !self.sights.is_closed(*i));
        let near: Vec<usize> = near.map(|(i, _)| i).collect();
        let standing = self.sights.standing();
        let integrated = self.integrate_in_full(&near, depths, tolerance).await;
        if integrated.is_err() {
            self.sights.restore(&standing);
        }
        integrated
    }
}

/// The place of a lattice that is nearest to another.
fn nearest_of_level(along: u32, level: u8) -> u32 {
    let step = spacing(level.min(DEEPEST_LEVEL));
    (along + step / 2) / step * step
}

/// The place of a coordinate from 0 to 1.
pub(crate) fn dyadic(along: f64) -> u32 {
    cell::to_u32(whole(along * f64::from(STEPS))).min(STEPS)
}
