//! Lines of sight at places of the image plane: their pieces in the charts of a view, and their radiances from
//! functions on these charts.

use crate::image::Image;
use crate::line_values::LineValues;
use crate::parallel::prelude::*;
use crate::projection::charts::chart::Window;
use crate::vol::view::chart_nodes::ChartNodes;
use crate::vol::view::part::{Footing, Parts, ProductImage};
use crate::vol::view::raster::cell_at;
use crate::vol::view::refined_raster::RefinedRaster;
use crate::vol::view::windows::{NaturalNode, in_window};

/// The raster of a function is made finer until the values on lines have errors below this share of the error allowed.
const RASTER_SHARE: f64 = 0.02;
/// Its error on a line is the largest of those there and at places beside it, in shares of the chart: a raster and a
/// coarser one agree in single places, beside kinks too.
const BESIDE: [[f64; 2]; 5] = [[0.0; 2], [-STEP, -STEP], [STEP, -STEP], [-STEP, STEP], [STEP; 2]];
const STEP: f64 = 1.0 / 512.0;
/// How far a line may be outside of what pixels see of a chart, in shares of that.
const OUTSIDE: f64 = 1e-6;

/// The pieces of lines in the parts of a view.
pub(crate) struct LinesInView {
    /// For each part the places of pieces, and those beside them: row k of the shape has those at `BESIDE[k]`.
    of_parts: Vec<ChartNodes>,
    /// Whether all pieces of a line are in charts that pixels see.
    is_known: Vec<bool>,
}

/// The function of a part: it is made of products, or a tree.
pub(crate) struct FunctionOfPart<'a> {
    /// Its means over a raster of a shape.
    pub(crate) means: Box<dyn Fn([usize; 2]) -> Vec<f64> + 'a>,
    /// Its errors, on a raster of any shape.
    pub(crate) errors: Image,
}

impl<'a> FunctionOfPart<'a> {
    /// Products, whose errors are those of pixels with this scale.
    pub(crate) fn of_products(product: &'a ProductImage, scale: &Image) -> Self {
        let mut errors = product.errors.clone();
        for (error, scale) in errors.pixels_mut().iter_mut().zip(scale.pixels()) {
            *error = if *scale > 0.0 { *error / scale } else { 0.0 };
        }
        Self { means: Box::new(|shape| product.function.means(shape)), errors }
    }
}

impl LinesInView {
    /// The lines at places of the image plane.
    pub(crate) fn new(parts: &Parts<'_>, places: &[[f64; 2]]) -> Self {
        let is_place = |xy: &[f64; 2]| xy.iter().all(|along| (0.0..=1.0).contains(along));
        let pieces = |(line, xy): (usize, &[f64; 2])| match is_place(xy) {
            true => parts.nodes_of_line(*xy, line),
            false => Vec::new(),
        };
        let of_lines: Vec<Vec<NaturalNode>> = places.par_iter().enumerate().map(pieces).collect();
        let mut is_known: Vec<bool> = of_lines.iter().map(|of| !of.is_empty()).collect();
        let mut seen = vec![0; places.len()];
        let plane = Window { c: [0.0, 1.0], azimuth_rad: [0.0, 1.0] };
        let mut of_part = |footing: &Footing| {
            let (chart, window, is_plane) = match footing {
                Footing::Pixels { .. } => (0, plane, true),
                Footing::Nodes { chart, window, .. } => (*chart, *window, false),
            };
            let own = of_lines.iter().flatten().filter(|node| node.chart == chart);
            let own: Vec<&NaturalNode> = own.collect();
            for node in &own {
                let is_in = |along: &f64| (-OUTSIDE..=1.0 + OUTSIDE).contains(along);
                is_known[node.pixel] &= window.unit(node.place).iter().all(is_in);
                seen[node.pixel] += if is_plane { 0 } else { 1 };
            }
            let beside = |(row, [u, v]): (usize, &[f64; 2])| {
                let first = row * places.len();
                let beside = own.iter().map(move |node| {
                    let node = NaturalNode { pixel: first + node.pixel, ..**node };
                    let mut node = in_window(&window, &node);
                    let moved = [(node.place[0], *u), (node.place[1], *v)];
                    #[expect(
                        clippy::cast_possible_truncation,
                        reason = "a place in single precision"
                    )]
                    let at = moved.map(|(at, by)| (f64::from(at) + by).clamp(0.0, 1.0) as f32);
                    node.place = at;
                    node
                });
                beside.collect::<Vec<_>>()
            };
            let nodes = BESIDE.iter().enumerate().flat_map(beside).collect();
            ChartNodes::new([BESIDE.len(), places.len()], nodes)
        };
        let of_parts = parts.parts.iter().map(|part| of_part(&part.footing)).collect();
        if parts.parts.iter().any(|part| !part.footing.is_of_pixels()) {
            // A piece may be in a chart that no pixel sees.
            for ((is_known, seen), of_line) in is_known.iter_mut().zip(&seen).zip(&of_lines) {
                *is_known &= *seen == of_line.len();
            }
        }
        Self { of_parts, is_known }
    }

    /// The radiances of the lines from the functions of all parts; `allowed` is the error allowed in a radiance.
    pub(crate) fn values(&self, functions: &[FunctionOfPart<'_>], allowed: f64) -> LineValues {
        let count = self.is_known.len();
        let mut found = LineValues { values: vec![0.0; count], errors: vec![0.0; count] };
        for (nodes, function) in self.of_parts.iter().zip(functions) {
            if nodes.nodes.is_empty() {
                continue;
            }
            let RefinedRaster { raster, error, .. } =
                RefinedRaster::new(nodes, &function.means, &|_| RASTER_SHARE * allowed);
            let values = nodes.image(&raster);
            for (value, of_part) in found.values.iter_mut().zip(values.row(0)) {
                *value += of_part;
            }
            for (line, of_line) in found.errors.iter_mut().enumerate() {
                *of_line += error.rows().map(|row| row[line]).fold(0.0, f64::max);
            }
            let shape = [function.errors.height(), function.errors.width()];
            // The first row of the shape.
            let own = nodes.nodes.iter().take_while(|node| (node.pixel as usize) < count);
            for node in own {
                let cell = cell_at(node.place.map(f64::from), shape);
                found.errors[node.pixel as usize] += node.weight * function.errors.pixels()[cell];
            }
        }
        for (line, is_known) in self.is_known.iter().enumerate() {
            if !is_known || !found.values[line].is_finite() {
                (found.values[line], found.errors[line]) = (0.0, f64::INFINITY);
            }
        }
        found
    }
}
