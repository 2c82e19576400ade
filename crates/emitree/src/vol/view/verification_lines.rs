//! The lines of sight with which the image tree of a sheet is verified.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::vol::dyadic::{DEEPEST_LEVEL, Place, STEPS, around, from_unit, spacing, unit};
use crate::vol::image::tree::Node;
use crate::vol::lattice;
use crate::vol::line::node_lines::{LineSource, Wanted, base_depths};
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::sheet::Sheet;
use crate::vol::view::verification::Lines;
use rustc_hash::FxHashMap;
use std::borrow::Cow;

/// The smallest number of lines that one thread compares: lines near each other need the same
/// predictions.
const LINES_PER_TASK: usize = 64;
/// The number of the first scattered line in the sequence of scattered points, far beyond those of
/// the samples.
pub(crate) const FIRST_LINE: usize = 1 << 24;

impl Sheet<'_> {
    /// Scattered lines that no verification has had before.
    pub(crate) fn scattered_lines(&mut self, count: usize) -> Lines {
        let base = self.scan.depth_level;
        let first = self.verification.scattered;
        self.verification.scattered += count;
        let place = |k: usize| {
            let [x, y, _] = lattice::point(FIRST_LINE + k);
            let finer = if k.is_multiple_of(TUNING.verification.dense_line_stride) {
                TUNING.verification.dense_extra_levels
            } else {
                0
            };
            (
                [x, y].map(from_unit),
                base_depths(base + TUNING.verification.extra_depth_levels + finer),
            )
        };
        (first..first + count).map(place).collect()
    }

    /// Lines through the centres of the pixels with the largest estimated `errors`, at a distance
    /// from each other.
    pub(crate) fn worst_lines(&self, errors: &[Cow<'_, Image>], count: usize) -> Lines {
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
                (0..2).all(|axis| {
                    (other[axis] - middle[axis]).abs() < TUNING.verification.worst_line_distance
                })
            };
            if !worst.iter().any(near) {
                worst.push(middle);
            }
        }
        let depths = base_depths(self.scan.depth_level + TUNING.verification.extra_depth_levels);
        worst.into_iter().map(|middle| (middle.map(from_unit), depths.clone())).collect()
    }

    /// Lines around a line of the verification, at half the distance of the nodes there.
    pub(crate) fn beside(&self, line: usize) -> Lines {
        let place = self.verification.places.nodes()[line].place;
        let distance = spacing(self.level_around(place) + 1);
        let depths = base_depths(self.scan.depth_level + TUNING.verification.extra_depth_levels);
        around(place, distance, 1)
            .filter(|(x, y, _)| *x == 0 || *y == 0)
            .map(|(_, _, place)| (place, depths.clone()))
            .collect()
    }

    /// The finest level on which all four nodes of the cell around a place exist.
    pub(crate) fn level_around(&self, place: Place) -> u8 {
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

    /// Integrates lines at new places to `tolerance`, from the given depths and those of the nodes
    /// nearby.
    pub(crate) async fn verify_lines(&mut self, places: Lines, tolerance: f64) -> Result<(), Stop> {
        let Self { scan, verification, .. } = self;
        let Scan { view, tree, node_lines, depth_level, .. } = &*scan;
        let first = verification.places.len();
        let mut own = Vec::new();
        let level = (tree.finest_level() + TUNING.verification.levels_below_nodes)
            .max(TUNING.verification.coarsest_line_level);
        for (place, depths) in places {
            let place = place.map(|along| nearest_of_level(along, level));
            let is_new = tree.find(place).is_none() && verification.places.find(place).is_none();
            if is_new {
                verification.places.add(place);
                own.push(depths);
            }
        }
        let new: Vec<Place> =
            verification.places.nodes()[first..].iter().map(|node| node.place).collect();
        verification.node_lines.grow(verification.places.len());
        for (weight, place) in verification.node_lines.error_weights[first..].iter_mut().zip(&new) {
            *weight = scan.weight_around(*place, level);
        }
        let tolerances: Vec<f64> = (first..verification.places.len())
            .map(|i| verification.node_lines.tolerance_of(i, tolerance))
            .collect();
        let starts = node_lines.starts(tree, &new, tree.len(), &tolerances, *depth_level);
        let [mut usual, mut finer]: [Wanted; 2] = [Vec::new(), Vec::new()];
        for (i, (own, (depths, brackets))) in (first..).zip(own.into_iter().zip(starts)) {
            verification.node_lines.sources[i] = LineSource::Full;
            verification.node_lines.expect(i, brackets);
            usual.push((i, depths));
            finer.push((i, own));
        }
        let sampled = verification.integrate(view, [usual, finer], tolerance, *depth_level).await;
        if sampled.is_err() {
            verification.places.truncate(first);
            verification.node_lines.truncate(first);
            verification.changes.truncate(first);
        }
        sampled
    }

    /// Whether the finer depths have changed a pixel by more than `most`, in the unit of the image
    /// and times its weight, on a line of this verification, one from number `first` on.
    pub(crate) fn is_changed_by_depths(&self, first: usize, most: f64) -> bool {
        self.largest_change_by_depths(first) > most
    }

    /// The largest such change.
    pub(crate) fn largest_change_by_depths(&self, first: usize) -> f64 {
        let nodes = self.verification.places.nodes()[first..].iter();
        let change = |(node, change): (&Node, &f64)| {
            let density = self.scan.view.chart.density(node.place.map(unit));
            let [row, column] = self.pixel(node.place);
            density * change * self.weighted_scale[(row, column)]
        };
        nodes.zip(&self.verification.changes[first..]).map(change).fold(0.0, f64::max)
    }

    /// The differences of the lines from number `first` on from the tree, as weighted errors of a
    /// pixel in the unit of the image; `earlier` and `of_earlier` as in [`set_values`](Self::set_values).
    pub(crate) fn differences(
        &self,
        first: usize,
        earlier: &[&Self],
        of_earlier: &[f64],
    ) -> Vec<f64> {
        let [height, width] = [self.scale.height(), self.scale.width()];
        let nodes = self.verification.places.nodes();
        let difference = |ghosts: &mut (Ghosts, Vec<Ghosts>), i: usize| {
            let place = nodes[i].place;
            let (own, of_others) = ghosts;
            let integral = self.verification.node_lines.lines[i].integral;
            let value = self.value_of(place, integral, earlier, of_earlier, of_others);
            let size = (value - self.scan.tree.value(place, own)).abs();
            // A difference on a cell below the size of a pixel changes the pixel by its share.
            let distance = unit(spacing(self.level_around(place)));
            let share = (distance * width as f64).min(1.0) * (distance * height as f64).min(1.0);
            let [row, column] = self.pixel(place);
            size * share * self.weighted_scale[(row, column)]
        };
        let ghosts = || (Ghosts::default(), vec![Ghosts::default(); earlier.len()]);
        let lines = (first..nodes.len()).into_par_iter().with_min_len(LINES_PER_TASK);
        lines.map_init(ghosts, difference).collect()
    }
}

type Ghosts = FxHashMap<u64, f64>;

impl Scan<'_> {
    /// Integrates the nodes within one spacing of `level` in full, with the given depths in
    /// addition, each to `tolerance`.
    pub(crate) async fn sample_around(
        &mut self,
        place: Place,
        level: u8,
        depths: &[u32],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let is_near = |at: Place| (0..2).all(|k| at[k].abs_diff(place[k]) <= spacing(level));
        let nodes = self.tree.nodes().iter().enumerate();
        let near = nodes.filter(|(_, node)| is_near(node.place));
        let near: Vec<usize> = near.map(|(i, _)| i).collect();
        let snapshot = self.node_lines.snapshot();
        let integrated = self.integrate_in_full(&near, depths, tolerance).await;
        if integrated.is_err() {
            self.node_lines.restore(&snapshot);
        }
        integrated
    }
}

/// The place of the lattice of `level` nearest to another place.
fn nearest_of_level(along: u32, level: u8) -> u32 {
    let step = spacing(level.min(DEEPEST_LEVEL));
    (along + step / 2) / step * step
}
