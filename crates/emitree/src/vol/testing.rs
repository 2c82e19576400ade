//! Synthetic views, trees and lines for unit tests.

use crate::calls::Calls;
use crate::emission::FromSpectralFn;
use crate::erased::Erased;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::{Limits, Meter};
use crate::projection::{Chart, MappedPoint};
use crate::vol::dyadic::{Place, spacing, unit};
use crate::vol::image::tree::ImageTree;
use crate::vol::line::Line;
use crate::vol::line::node_lines::{LineSource, NodeLines};
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::View;
use crate::vol::seeds::SeedTargets;
use crate::vol::view::part::{Footing, Part};
use crate::vol::view::sheet::{Sheet, SheetId};
use crate::vol::view::verification::Verification;
use core::future::Future;
use core::pin::pin;
use std::sync::Arc;

/// A chart of the unit cube along z, of which a part is in view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pane {
    pub(crate) is_open: fn([f64; 2]) -> bool,
    pub(crate) density: fn([f64; 2]) -> f64,
    /// ds/dz.
    pub(crate) path: f64,
}

/// All of the cube in view, with lengths and areas of 1.
pub(crate) const PANE: Pane = Pane { is_open: |_| true, density: |_| 1.0, path: 1.0 };

/// The image plane of a pane as the only part of a view.
pub(crate) fn part_of(pane: Pane) -> Part<'static> {
    let footing = Footing::Pixels { first_row: 0, rim: None };
    let (footing, scale) = (Arc::new(footing), Arc::new(uniform([1, 1], 1.0)));
    Part {
        chart: Box::new(pane),
        footing,
        scale,
        share: 1.0,
        coarser: 0,
        pieces_of_line: 1,
        least_feature: 1.0,
    }
}

impl Chart for Pane {
    fn world_from_chart(&self, u: [f64; 3]) -> MappedPoint {
        let path_per_depth = if (self.is_open)([u[0], u[1]]) { self.path } else { 0.0 };
        MappedPoint { position: u, direction: [0.0, 0.0, -1.0], path_per_depth }
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        Some(position)
    }

    fn density(&self, xy: [f64; 2]) -> f64 {
        (self.density)(xy)
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        (0, uv)
    }
}

/// A meter that allows so many evaluations.
pub(crate) fn meter(max_evaluations: u64) -> Meter {
    let ([max_kept, batch_size], whole_batches, deadline) = ([u64::MAX; 2], false, None);
    let limits = Limits { max_evaluations, max_kept, batch_size, whole_batches, deadline };
    Meter::new([1, 1], limits, None, false)
}

/// The result of a task whose samples are those of `rate`, of a position and an energy.
pub(crate) fn answered<T>(
    meter: &Meter,
    rate: impl Fn([f64; 3], f64) -> f64 + Sync,
    task: impl Future<Output = T>,
) -> T {
    let emission = FromSpectralFn(|position, _, energy| rate(position, energy));
    let task = pin!(async { Ok::<T, MethodError>(task.await) });
    Calls::new(&Erased(&emission), meter, None).drive(task).unwrap()
}

pub(crate) fn view<'a>(meter: &'a Meter, chart: &'a dyn Chart) -> View<'a> {
    View { meter, chart, tiles: 1, energy: None }
}

/// All places of the lattice of `level`, column by column.
pub(crate) fn lattice(level: u8) -> Vec<Place> {
    let along = move || (0..=1_u32 << level).map(move |k| k * spacing(level));
    along().flat_map(|x| along().map(move |y| [x, y])).collect()
}

/// The place at column and row of the lattice of `level`.
pub(crate) fn at(level: u8, column: u32, row: u32) -> Place {
    [column, row].map(|k| k * spacing(level))
}

/// A tree with the values of a function.
pub(crate) fn tree_of(places: &[Place], value: impl Fn(f64, f64) -> f64) -> ImageTree {
    let mut tree = ImageTree::default();
    for &place in places {
        tree.add(place);
        tree.set(tree.len() - 1, value(unit(place[0]), unit(place[1])));
    }
    tree.update_details();
    tree
}

/// Adds a node whose detail is to be `detail`, or moves its value; the number of the node.
pub(crate) fn with_detail(tree: &mut ImageTree, place: Place, detail: f64) -> usize {
    let i = tree.find(place).unwrap_or_else(|| {
        tree.add(place);
        tree.len() - 1
    });
    tree.update_details();
    let node = tree.nodes()[i];
    tree.set(i, node.value - node.detail + detail);
    tree.update_details();
    i
}

/// A line sampled on the lattice of `level`, and integrated.
pub(crate) fn line_of(level: u8, rate: impl Fn(f64) -> f64) -> Line {
    let mut line = Line::default();
    let depths = (0..=1_u32 << level).map(|k| k * spacing(level));
    line.add(depths.map(|depth| (depth, rate(unit(depth)))));
    line.assess(f64::INFINITY, level);
    line
}

/// The full lines of all nodes of a tree, sampled on the lattice of `level`.
pub(crate) fn lines_of(tree: &ImageTree, level: u8, rate: impl Fn([f64; 3]) -> f64) -> NodeLines {
    let mut node_lines = NodeLines::default();
    node_lines.grow(tree.len());
    for (i, node) in tree.nodes().iter().enumerate() {
        let [x, y] = node.place.map(unit);
        node_lines.lines[i] = line_of(level, |z| rate([x, y, z]));
        node_lines.sources[i] = LineSource::Full;
    }
    node_lines
}

pub(crate) fn scan<'a>(meter: &'a Meter, chart: &'a dyn Chart, base_level: u8) -> Scan<'a> {
    Scan {
        view: view(meter, chart),
        base_level,
        depth_level: base_level,
        tree: ImageTree::default(),
        node_lines: NodeLines::default(),
        seeds: SeedTargets::default(),
        weights: None,
    }
}

/// The only sheet of a view, whose pixels have the radiances of the means.
pub(crate) fn sheet<'a>(
    meter: &'a Meter,
    chart: &'a dyn Chart,
    base_level: u8,
    [height, width]: [usize; 2],
) -> Sheet<'a> {
    let scale = Arc::new(uniform([height, width], 1.0));
    Sheet {
        id: SheetId { part: 0, energy: 0 },
        scan: scan(meter, chart, base_level),
        pieces_of_line: 1,
        footing: Arc::new(Footing::Pixels { first_row: 0, rim: None }),
        weighted_scale: scale.clone(),
        scale,
        verification: Verification::default(),
    }
}

pub(crate) fn uniform([height, width]: [usize; 2], value: f64) -> Image {
    Image::from_pixels(height, width, vec![value; height * width])
}

/// Gives a sheet the full lines and the values of `rate` at some places.
pub(crate) fn fill(sheet: &mut Sheet<'_>, places: &[Place], rate: impl Fn([f64; 3]) -> f64) {
    sheet.scan.add(places);
    sheet.scan.node_lines = lines_of(&sheet.scan.tree, sheet.scan.depth_level, rate);
    sheet.set_values(&[], &[]);
}

pub(crate) fn assert_close(found: f64, expected: f64, allowed: f64) {
    assert!((found - expected).abs() <= allowed, "{found} instead of {expected}");
}
