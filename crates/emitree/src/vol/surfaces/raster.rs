//! Means over pixels of the integrals along their lines of sight, and of the errors.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::octree::{Label, Octree};
use crate::vol::surfaces::pieces::Pieces;
use crate::vol::surfaces::rays::{LineIntegral, Ray};
use crate::vol::tuning::TUNING;

/// The places of two Gauss nodes, for the first lines of each pixel.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
/// The numbers of lines of pixels beside limbs: Fibonacci numbers, for lattices with lines at as many
/// distances from a limb.
const LINES: [usize; 4] = [34, 89, 233, 610];
/// The same for tolerances below [`FINE_BELOW`], where the corner of a pixel matters.
const FINE_BELOW: f64 = 5e-3;
const FINE_LINES: [usize; 4] = [144, 377, 610, 987];
/// More lines are used until the mean changes by less than this share of the error allowed.
const CHANGE: f64 = 0.05;
/// A pixel whose lines differ from each other by more than this share of the error allowed has more
/// lines.
const SPREAD: f64 = 0.02;

/// Image and error.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Maps {
    pub(super) image: Image,
    pub(super) error: Image,
}

/// The surfaces with the pieces beside them.
pub(super) struct Model {
    pub(super) tree: Octree,
    /// For each label its pieces.
    pub(super) pieces: Vec<Option<Pieces>>,
}

impl Model {
    /// The integral of the line at canonical (x, y).
    pub(super) fn line(&self, [x, y]: [f64; 2]) -> LineIntegral {
        let edges = self.tree.grid.edges;
        let xy = [x * edges[0], y * edges[1]];
        Ray::new(&self.tree, xy).integral(&self.pieces, xy, edges[2])
    }

    /// G at a point of the grid.
    pub(super) fn value(&self, at: [f64; 3]) -> f64 {
        self.value_of(self.tree.leaf(at).region(at), at)
    }

    /// G of a region at a point of the grid, continued there if the point is outside of the region.
    pub(super) fn value_of(&self, region: Label, at: [f64; 3]) -> f64 {
        let pieces = self.pieces.get(usize::from(region)).and_then(Option::as_ref);
        pieces.map_or(0.0, |of| of.value(at))
    }

    /// The numbers of the leaves that contribute to the errors of the pixels with the largest ones:
    /// unresolved ones, and patches whose share of the error allowed is above `least`.
    pub(super) fn leaves_to_improve(&self, aim: &Aim<'_>, maps: &Maps, least: f64) -> Vec<usize> {
        let [height, width] = [aim.scale.height(), aim.scale.width()];
        let edges = self.tree.grid.edges;
        let mut found = Vec::new();
        let errors = maps.error.pixels().iter().enumerate();
        let from = TUNING.surfaces.improved_from * aim.target;
        for (pixel, _) in errors.filter(|(_, error)| **error > from) {
            for k in 0..9 {
                let [u, v] = fibonacci(k, 13);
                let place = [
                    ((pixel % width) as f64 + u) / width as f64,
                    ((pixel / width) as f64 + v) / height as f64,
                ];
                let xy = [place[0] * edges[0], place[1] * edges[1]];
                let ray = Ray::new(&self.tree, xy);
                let most = aim.of_line(place) * edges[2];
                let is_large = |error: f64| error > least * most;
                for [z, error, _] in &ray.crossings {
                    if is_large(*error) {
                        found.push(self.tree.find([xy[0], xy[1], *z]));
                    }
                }
                found.extend(ray.unresolved_leaves);
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The image with its error, in the unit of the image.
    pub(super) fn maps(&self, aim: &Aim<'_>, tolerance: f64) -> Maps {
        let lines = if tolerance < FINE_BELOW { FINE_LINES } else { LINES };
        let [height, width] = [aim.scale.height(), aim.scale.width()];
        let mean = |pixel: usize, places: &mut dyn Iterator<Item = [f64; 2]>| {
            let (row, column) = (pixel / width, pixel % width);
            let (mut sum, mut count) = (LineIntegral::default(), 0.0);
            let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
            for [u, v] in places {
                let place = [(column as f64 + u) / width as f64, (row as f64 + v) / height as f64];
                let line = self.line(place);
                sum.value += line.value;
                sum.error += line.error;
                ends = [ends[0].min(line.value), ends[1].max(line.value)];
                count += 1.0;
            }
            (LineIntegral { value: sum.value / count, error: sum.error / count }, ends[1] - ends[0])
        };
        // Lines at the corners of pixels, which neighbours share: an edge of the image may be parallel to the
        // border of a pixel, between this border and all other lines.
        let corners: Vec<usize> = (0..(height + 1) * (width + 1)).collect();
        let corner = |&number: &usize| {
            let (row, column) = (number / (width + 1), number % (width + 1));
            self.line([column as f64 / width as f64, row as f64 / height as f64]).value
        };
        let corners: Vec<f64> = corners.par_iter().map(corner).collect();
        let of_corners = |pixel: usize| {
            let first = pixel / width * (width + 1) + pixel % width;
            let below = first + width + 1;
            0.25 * (corners[first] + corners[first + 1] + corners[below] + corners[below + 1])
        };
        let pixels: Vec<usize> = (0..height * width).collect();
        let first = pixels.par_iter().map(|&pixel| {
            if aim.scale.pixels()[pixel] == 0.0 {
                return (LineIntegral::default(), false);
            }
            let mut gauss = (0..4).map(|k| [GAUSS[k % 2], GAUSS[k / 2]]);
            let mut other = (0..5).map(|k| fibonacci(k, 5));
            let (line, _) = mean(pixel, &mut gauss);
            let (check, _) = mean(pixel, &mut other);
            let allowed = SPREAD * aim.target / aim.scale.pixels()[pixel];
            let (middle, _) = mean(pixel, &mut [[0.5; 2]].into_iter());
            // Simpson's rule.
            let outer = 2.0 / 3.0 * middle.value + 1.0 / 3.0 * of_corners(pixel);
            let differs = |value: f64| (line.value - value).abs() > allowed;
            (line, differs(check.value) || differs(outer))
        });
        let first: Vec<(LineIntegral, bool)> = first.collect();
        let is_rough = |pixel: usize| {
            let (row, column) = (pixel / width, pixel % width);
            let rows = row.saturating_sub(1)..(row + 2).min(height);
            rows.into_iter().any(|row| {
                let columns = column.saturating_sub(1)..(column + 2).min(width);
                columns.into_iter().any(|column| first[row * width + column].1)
            })
        };
        let all = pixels.par_iter().map(|&pixel| {
            if !is_rough(pixel) || aim.scale.pixels()[pixel] == 0.0 {
                return first[pixel].0;
            }
            let of = |count: usize| mean(pixel, &mut (0..count).map(|k| fibonacci(k, count))).0;
            let allowed = CHANGE * aim.target / aim.scale.pixels()[pixel];
            let mut before = of(lines[0]);
            for count in &lines[1..] {
                let line = of(*count);
                let change = (line.value - before.value).abs();
                before = LineIntegral { error: line.error + 0.5 * change, ..line };
                if change <= allowed {
                    break;
                }
            }
            before
        });
        let all: Vec<LineIntegral> = all.collect();
        let (mut image, mut error) = (Image::zeros(height, width), Image::zeros(height, width));
        let targets = image.pixels_mut().iter_mut().zip(error.pixels_mut());
        for ((line, scale), (image, error)) in all.iter().zip(aim.scale.pixels()).zip(targets) {
            *image = line.value * scale;
            *error = line.error * scale;
        }
        Maps { image, error }
    }
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
