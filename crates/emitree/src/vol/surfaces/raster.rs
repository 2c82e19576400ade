//! Means over pixels of the integrals along their lines of sight, and of the errors.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::pixel::{KnownLines, Pixel};
use crate::vol::surfaces::rays::{LineIntegral, Ray};
use crate::vol::surfaces::sky::Sky;
use crate::vol::tuning::TUNING;
use crate::vol::view::pixel_lattices::{fibonacci, gauss_nodes, lattice_nodes};

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

    /// The image with its error, in the unit of the image.
    pub(super) fn maps(&self, aim: &Aim<'_>, tolerance: f64, known: &mut KnownLines) -> Maps {
        let lines = if tolerance < FINE_BELOW { FINE_LINES } else { LINES };
        known.keep_unchanged(&self.tree, aim, lines[0] + lines[1]);
        let [height, width] = [aim.scale.height(), aim.scale.width()];
        // Lines at the corners of pixels, which neighbours share: an edge of the image may be parallel to the
        // border of a pixel, between this border and all other lines.
        let tiles = aim.sky.map_or(1, Sky::tiles);
        let rows = height / tiles;
        let corners: Vec<usize> = (0..tiles * (rows + 1) * (width + 1)).collect();
        let corner = |&number: &usize| {
            let (row, column) = (number / (width + 1), number % (width + 1));
            let (tile, row) = (row / (rows + 1), row % (rows + 1));
            // As a place of a pixel beside it.
            let beside = [column.min(width - 1), row.min(rows - 1)];
            let pixel = (tile * rows + beside[1]) * width + beside[0];
            let place = [column - beside[0], row - beside[1]].map(|at| at as f64);
            let (xy, _) = self.line(aim, pixel, place);
            let ray = Ray::new(&self.tree, xy, aim.ends_of_line(&self.tree.grid, xy));
            self.integral(xy, ray.segments.iter().copied(), ray.error_of_surfaces()).value
        };
        let corners: Vec<f64> = corners.par_iter().map(corner).collect();
        let of_corners = |pixel: usize| {
            let row = pixel / width;
            let first = (row + row / rows) * (width + 1) + pixel % width;
            let below = first + width + 1;
            0.25 * (corners[first] + corners[first + 1] + corners[below] + corners[below + 1])
        };
        let first = known.first.par_iter_mut().enumerate().map(|(pixel, lines)| {
            if aim.scale.pixels()[pixel] == 0.0 {
                return (LineIntegral::default(), false);
            }
            let mut of = Pixel::new(self, aim, pixel, lines);
            let (line, check) = (of.mean(&gauss_nodes()), of.mean(&lattice_nodes(5)));
            let middle = of.mean(&[([0.5; 2], 1.0)]);
            let allowed = SPREAD * aim.target / aim.scale.pixels()[pixel];
            // Simpson's rule.
            let outer = 2.0 / 3.0 * middle.value + 1.0 / 3.0 * of_corners(pixel);
            let differs = |value: f64| (line.value - value).abs() > allowed;
            let is_at_limb = aim.visible.as_ref().is_some_and(|of| of.is_at_limb(pixel));
            (line, is_at_limb || differs(check.value) || differs(outer))
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
        let all = known.lattices.par_iter_mut().enumerate().map(|(pixel, known)| {
            if !is_rough(pixel) || aim.scale.pixels()[pixel] == 0.0 {
                return first[pixel].0;
            }
            let mut pixel_lines = Pixel::new(self, aim, pixel, known);
            let at_limb = aim.visible.as_ref().filter(|of| of.is_at_limb(pixel));
            let mut of = |step: usize| match at_limb {
                Some(visible) => pixel_lines.mean(&visible.nodes_at_limb(pixel, step)),
                None => pixel_lines.mean(&lattice_nodes(lines[step])),
            };
            let allowed = CHANGE * aim.target / aim.scale.pixels()[pixel];
            let mut before = of(0);
            for step in 1..lines.len() {
                let line = of(step);
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

#[cfg(test)]
mod tests;
