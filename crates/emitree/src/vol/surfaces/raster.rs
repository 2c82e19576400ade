//! Means over pixels of the integrals along their lines of sight, and of the errors.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::pixel::{KnownLines, Pixel, PixelLines};
use crate::vol::surfaces::rays::{LineIntegral, Ray};
use crate::vol::surfaces::sky::Sky;
use crate::vol::tuning::TUNING;
use crate::vol::view::pixel_rule::RuleNode;

/// The places of two Gauss nodes, for the first lines of each pixel.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
/// The number of further lines that they are compared with.
const CHECKS: usize = 5;
/// The numbers of lines of lattices: Fibonacci numbers, for lattices with lines at as many distances from a limb.
const LATTICES: [usize; 10] = [13, 21, 34, 55, 89, 144, 233, 377, 610, 987];
/// The first of them for tolerances below [`FINE_BELOW`], where the corner of a pixel matters, and the last one for others.
const FIRST_FINE: usize = 3;
const LAST_COARSE: usize = 8;
const FINE_BELOW: f64 = 5e-3;
/// The number of lattices after each other that have to agree with the one before: two lattices alone agree by chance
/// in some pixels of an image.
const AGREEMENTS: usize = 2;
/// The number of rules for a pixel at a limb, each with parts half as long as the one before.
const RULES_AT_LIMB: usize = 4;
/// Lattices agree if their means differ by less than this share of the error allowed.
const CHANGE: f64 = 0.05;
/// A pixel whose lines differ from each other by more than this share of the error allowed has more
/// lines.
const SPREAD: f64 = 0.02;
/// A pixel whose first lines have an error above this share of the error allowed has more lines in rough maps.
const SUSPECT: f64 = 0.5;
/// The lines of a pixel on which leaves to improve are searched for, for each improvement.
const LINES_TO_IMPROVE: [usize; 4] = [13, 34, 89, 233];

/// Image and error.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Maps {
    pub(super) image: Image,
    pub(super) error: Image,
}

impl Model {
    /// The numbers of the leaves that contribute to the errors of the pixels with the largest ones:
    /// unresolved ones, and patches whose share of the error allowed is above `least`. They are searched for
    /// on more lines of a pixel each time, as leaves are smaller.
    pub(super) fn leaves_to_improve(
        &self,
        aim: &Aim<'_>,
        maps: &Maps,
        least: f64,
        number: usize,
    ) -> Vec<usize> {
        let mut found = Vec::new();
        let errors = maps.error.pixels().iter().enumerate();
        let from = TUNING.surfaces.improved_from * aim.target;
        let mut ray = Ray::default();
        for (pixel, _) in errors.filter(|(_, error)| **error > from) {
            let beam = self.beam(aim, pixel);
            let lines = LINES_TO_IMPROVE[number.min(LINES_TO_IMPROVE.len() - 1)];
            for k in 0..lines {
                let place = fibonacci(k, lines);
                let (xy, _) = self.line(aim, pixel, place);
                self.follow(&mut ray, aim, beam.as_ref(), xy);
                let (place, _) = aim.line(pixel, place);
                let most = aim.of_line(place) * self.tree.grid.edges[2];
                let is_large = |error: f64| error > least * most;
                for [z, error, _] in &ray.crossings {
                    if is_large(*error) {
                        found.push(self.tree.find([xy[0], xy[1], *z]));
                    }
                }
                found.extend(&ray.unresolved_leaves);
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The image with its error, in the unit of the image, from the first lines of each pixel alone, except where the
    /// error of these is large: errors that are too large to be accepted show in a fraction of the time.
    pub(super) fn rough_maps(&self, aim: &Aim<'_>, tolerance: f64, known: &mut KnownLines) -> Maps {
        let first = self.first_lines(aim, tolerance, known);
        let all = known.lattices.par_iter_mut().zip(&first).enumerate();
        let all = all.map(|(pixel, (known, first))| {
            let mean = first.mean();
            let is_large = mean.error * aim.scale.pixels()[pixel] > SUSPECT * aim.target;
            if is_large { self.settled(aim, tolerance, (pixel, known), None) } else { mean }
        });
        Maps::new(&all.collect::<Vec<_>>(), aim)
    }

    /// The image with its error, in the unit of the image.
    pub(super) fn maps(&self, aim: &Aim<'_>, tolerance: f64, known: &mut KnownLines) -> Maps {
        let first = self.first_lines(aim, tolerance, known);
        let corners = self.corners(aim);
        let [height, width] = [aim.scale.height(), aim.scale.width()];
        let differ = |(pixel, first): (usize, &FirstLines)| {
            let is_at_limb = aim.visible.as_ref().is_some_and(|of| of.is_at_limb(pixel));
            let allowed = SPREAD * aim.target / aim.scale.pixels()[pixel];
            is_at_limb || first.differ(corners[pixel], allowed)
        };
        let differ: Vec<bool> = first.iter().enumerate().map(differ).collect();
        let is_rough = |pixel: usize| {
            let (row, column) = (pixel / width, pixel % width);
            let rows = row.saturating_sub(1)..(row + 2).min(height);
            rows.into_iter().any(|row| {
                let columns = column.saturating_sub(1)..(column + 2).min(width);
                columns.into_iter().any(|column| differ[row * width + column])
            })
        };
        let all = known.lattices.par_iter_mut().enumerate().map(|(pixel, known)| {
            let gauss = first[pixel].gauss;
            if !is_rough(pixel) || aim.scale.pixels()[pixel] == 0.0 {
                return gauss;
            }
            let before = (!differ[pixel]).then_some(gauss);
            self.settled(aim, tolerance, (pixel, known), before)
        });
        Maps::new(&all.collect::<Vec<_>>(), aim)
    }

    /// The means over the first lines of all pixels.
    fn first_lines(
        &self,
        aim: &Aim<'_>,
        tolerance: f64,
        known: &mut KnownLines,
    ) -> Vec<FirstLines> {
        let lines_of_most = lattices(tolerance).iter().take(AGREEMENTS + 1).sum();
        known.keep_unchanged(&self.tree, aim, lines_of_most);
        let first = known.first.par_iter_mut().enumerate().map(|(pixel, lines)| {
            match aim.scale.pixels()[pixel] == 0.0 {
                true => FirstLines::default(),
                false => FirstLines::new(&mut Pixel::new(self, aim, pixel, lines)),
            }
        });
        first.collect()
    }

    /// The mean over a pixel by more and more lines, until it agrees with those by fewer; `before` is the first of these.
    fn settled(
        &self,
        aim: &Aim<'_>,
        tolerance: f64,
        (pixel, known): (usize, &mut PixelLines),
        before: Option<LineIntegral>,
    ) -> LineIntegral {
        let mut lines = Pixel::new(self, aim, pixel, known);
        let allowed = CHANGE * aim.target / aim.scale.pixels()[pixel];
        let at_limb = aim.visible.as_ref().filter(|of| of.is_at_limb(pixel));
        let needed = if at_limb.is_some() { 1 } else { AGREEMENTS };
        let nodes = |step: usize| match at_limb {
            Some(of) => (step < RULES_AT_LIMB).then(|| of.nodes_at_limb(pixel, step)),
            None => lattices(tolerance).get(step).map(|count| lattice_nodes(*count)),
        };
        let mut settled = Settled { last: before, agreements: 0 };
        for nodes in (0..).map_while(nodes) {
            settled.add(lines.mean(&nodes), allowed);
            if settled.agreements >= needed {
                break;
            }
        }
        settled.last.unwrap_or_default()
    }

    /// The means over the lines at the four corners of each pixel, which neighbours share: an edge of the image may be
    /// parallel to the border of a pixel, between this border and all other lines.
    fn corners(&self, aim: &Aim<'_>) -> Vec<f64> {
        let [height, width] = [aim.scale.height(), aim.scale.width()];
        let tiles = aim.sky.map_or(1, Sky::tiles);
        let rows = height / tiles;
        let numbers: Vec<usize> = (0..tiles * (rows + 1) * (width + 1)).collect();
        let corner = |&number: &usize| {
            let (row, column) = (number / (width + 1), number % (width + 1));
            let (tile, row) = (row / (rows + 1), row % (rows + 1));
            // As a place of a pixel beside it.
            let beside = [column.min(width - 1), row.min(rows - 1)];
            let pixel = (tile * rows + beside[1]) * width + beside[0];
            let place = [column - beside[0], row - beside[1]].map(|at| at as f64);
            let (xy, _) = self.line(aim, pixel, place);
            let ray = Ray::new(&self.tree, xy, aim.end_of_line(&self.tree.grid, xy));
            self.integral(xy, ray.segments.iter().copied(), ray.error_of_surfaces()).value
        };
        let corners: Vec<f64> = numbers.par_iter().map(corner).collect();
        let of_pixel = |pixel: usize| {
            let row = pixel / width;
            let first = (row + row / rows) * (width + 1) + pixel % width;
            let below = first + width + 1;
            0.25 * (corners[first] + corners[first + 1] + corners[below] + corners[below + 1])
        };
        (0..height * width).map(of_pixel).collect()
    }
}

impl Maps {
    /// Those of the means over all pixels.
    fn new(all: &[LineIntegral], aim: &Aim<'_>) -> Self {
        let scaled = |of: fn(&LineIntegral) -> f64| {
            let pixels = all.iter().zip(aim.scale.pixels()).map(|(line, scale)| of(line) * scale);
            Image::from_pixels(aim.scale.height(), aim.scale.width(), pixels.collect())
        };
        Self { image: scaled(|of| of.value), error: scaled(|of| of.error) }
    }
}

/// The means over the first lines of a pixel: at four Gauss nodes, a lattice beside them, and the middle.
#[derive(Clone, Copy, Default)]
struct FirstLines {
    gauss: LineIntegral,
    check: LineIntegral,
    middle: LineIntegral,
}

impl FirstLines {
    fn new(pixel: &mut Pixel<'_>) -> Self {
        let gauss: [RuleNode; 4] = core::array::from_fn(|k| ([GAUSS[k % 2], GAUSS[k / 2]], 0.25));
        let (gauss, check) = (pixel.mean(&gauss), pixel.mean(&lattice_nodes(CHECKS)));
        Self { gauss, check, middle: pixel.mean(&[([0.5; 2], 1.0)]) }
    }

    /// The mean over all of them.
    fn mean(&self) -> LineIntegral {
        let mut sum = LineIntegral::default();
        for (of, lines) in [(&self.gauss, 4), (&self.check, CHECKS), (&self.middle, 1)] {
            let share = lines as f64 / (5 + CHECKS) as f64;
            sum.value += share * of.value;
            sum.error += share * of.error;
        }
        sum
    }

    /// Whether they, with the mean over the corners of the pixel, differ by more than is allowed.
    fn differ(&self, corners: f64, allowed: f64) -> bool {
        // Simpson's rule.
        let outer = 2.0 / 3.0 * self.middle.value + 1.0 / 3.0 * corners;
        let differs = |value: f64| (self.gauss.value - value).abs() > allowed;
        differs(self.check.value) || differs(outer)
    }
}

/// Means of a pixel over more and more lines.
struct Settled {
    last: Option<LineIntegral>,
    /// The number of the last ones that agreed with those before them.
    agreements: usize,
}

impl Settled {
    fn add(&mut self, line: LineIntegral, allowed: f64) {
        let change = self.last.map(|before| (line.value - before.value).abs());
        self.agreements =
            if change.is_some_and(|change| change <= allowed) { self.agreements + 1 } else { 0 };
        self.last = Some(LineIntegral { error: line.error + 0.5 * change.unwrap_or(0.0), ..line });
    }
}

/// The numbers of lines of pixels that are not smooth, which are used until the means agree.
fn lattices(tolerance: f64) -> &'static [usize] {
    if tolerance < FINE_BELOW { &LATTICES[FIRST_FINE..] } else { &LATTICES[..=LAST_COARSE] }
}

/// The points of the Fibonacci lattice of `count` points, with equal weights.
fn lattice_nodes(count: usize) -> Vec<RuleNode> {
    (0..count).map(|k| (fibonacci(k, count), 1.0 / count as f64)).collect()
}

/// Point `k` of the Fibonacci lattice of `count` points, in the middle of its shares.
fn fibonacci(k: usize, count: usize) -> [f64; 2] {
    // The Fibonacci number before `count`.
    let (mut before, mut number) = (1, 1);
    while number < count {
        (before, number) = (number, before + number);
    }
    let u = (k as f64 + 0.5) / count as f64;
    let v = ((k * before % count) as f64 + 0.5) / count as f64;
    [u, v]
}

#[cfg(test)]
mod tests;
