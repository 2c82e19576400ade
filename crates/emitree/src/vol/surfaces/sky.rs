//! Views whose image planes are no coordinates for surfaces: those of several tiles, of a disc with its rim, and
//! those with a pole, at which all lines of a row are one.
//!
//! Their surfaces are searched for in a chart of all lines of sight about one direction, which depends on the
//! observer and on the directions in view alone. A pixel is the mean over its lines, weighted with solid angle.

use crate::image::Image;
use crate::projection::disc_chart::DiscChart;
use crate::projection::vector::{along, dot, norm, unit};
use crate::projection::{Chart, ViewGeometry};
use crate::tile::Tile;
use crate::vol::view::part::{Footing, Part, Parts};
use crate::vol::view::scattered::PartSamples;
use core::f64::consts::PI;
use std::sync::Arc;

/// An image plane has a pole if its density of solid angle somewhere is below this share of the largest. That of a
/// perspective view of 165° is not.
const LEAST_DENSITY: f64 = 1e-3;
/// Directions along each axis of a tile.
const DIRECTIONS: usize = 33;
/// From this angle on around its middle, a view is one of all of the sky: the middle of its chart is where the
/// emission is.
const WHOLE_RAD: f64 = 2.2;
/// Half of the diagonal of a base cell, as a share of the edge of the chart, and steps of it.
const BASE_CELL: f64 = 0.09;
const STEPS_INWARDS: usize = 3;
/// By how much the chart reaches beyond the directions in view.
const MARGIN: f64 = 1.02;

/// The pixels of a view, and the chart of all of their lines.
pub(crate) struct Sky<'a> {
    chart: DiscChart<'a>,
    geometries: Vec<&'a dyn ViewGeometry>,
    /// Height and width of a tile.
    tile: [usize; 2],
    /// The edge of a pixel of mean solid angle, as a share of the edge of the chart.
    pub(super) pixel_size: f64,
}

/// Whether an image plane is a chart in which surfaces may be searched for.
pub(super) fn is_regular(part: &Part<'_>) -> bool {
    let place = |k: usize| k as f64 / (DIRECTIONS - 1) as f64;
    let densities = (0..DIRECTIONS * DIRECTIONS)
        .map(|k| part.chart.density([place(k % DIRECTIONS), place(k / DIRECTIONS)]));
    let (least, most) = densities
        .fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), density| {
            (least.min(density), most.max(density))
        });
    part.footing.is_raster_of_pixels() && least > LEAST_DENSITY * most
}

impl<'a> Sky<'a> {
    /// The sky of a view of a point observer, given unit vectors away from the observer with the rates there; `None`
    /// for other views.
    pub(super) fn new(tiles: &[Tile<'a>], rates: &[([f64; 3], f64)]) -> Option<Self> {
        let geometries: Vec<&'a dyn ViewGeometry> =
            tiles.iter().map(|tile| tile.projection.view_geometry()).collect::<Option<_>>()?;
        let mut directions = Vec::new();
        let mut solid_angle = 0.0;
        for geometry in &geometries {
            for k in 0..DIRECTIONS * DIRECTIONS {
                let place = |k: usize| k as f64 / (DIRECTIONS - 1) as f64;
                let xy = [place(k % DIRECTIONS), place(k / DIRECTIONS)];
                let density = geometry.solid_angle_density(xy);
                if density > 0.0 || !geometry.has_rim() {
                    directions.push((geometry.line(xy)?.direction(), density));
                }
            }
            solid_angle += geometry.solid_angle([0.0; 2], [1.0; 2]);
        }
        let mean = |of: &[([f64; 3], f64)]| {
            let sum = of.iter().fold([0.0; 3], |sum, (at, weight)| along(sum, *weight, *at));
            let weights: f64 = of.iter().map(|(_, weight)| weight).sum();
            (norm(sum) > 1e-6 * weights).then(|| unit(sum)).flatten()
        };
        let reach = |middle: [f64; 3]| {
            let angles = directions.iter().map(|(at, _)| dot(middle, *at).clamp(-1.0, 1.0).acos());
            angles.fold(0.0, f64::max)
        };
        let first = directions.first()?.0;
        let of_view = mean(&directions).filter(|middle| reach(*middle) < WHOLE_RAD);
        let middle = of_view.or_else(|| mean(rates)).unwrap_or(first);
        let reach_rad = (MARGIN * reach(middle)).min(PI);
        let chart = DiscChart::new(geometries.clone(), middle, reach_rad)?;
        let tile = tiles.first()?.shape;
        let pixels = tile[0] * tile[1] * tiles.len();
        let pixel_size = (solid_angle / pixels as f64).sqrt() / (2.0 * reach_rad);
        Some(Self { chart, geometries, tile, pixel_size })
    }

    /// All of the view as one part, in the chart, given 1 in the pixels of the image.
    pub(super) fn part(&self, scale: Arc<Image>) -> Part<'a> {
        Part {
            chart: Box::new(self.chart.clone()),
            footing: Arc::new(Footing::Pixels { first_row: 0, rim: None }),
            scale,
            share: 1.0,
            coarser: 0,
            pieces_of_line: 1,
            least_feature: 1.0,
        }
    }

    /// The chart of all lines.
    pub(super) fn chart(&self) -> &dyn Chart {
        &self.chart
    }

    /// The number of tiles.
    pub(super) fn tiles(&self) -> usize {
        self.geometries.len()
    }

    /// The place in the chart of the line at a place of a pixel, from 0 to 1, and its density of solid angle.
    pub(super) fn line(&self, pixel: usize, [u, v]: [f64; 2]) -> ([f64; 2], f64) {
        let [height, width] = self.tile;
        let (row, column) = (pixel / width, pixel % width);
        let geometry = self.geometries[row / height];
        let xy = [(column as f64 + u) / width as f64, ((row % height) as f64 + v) / height as f64];
        let place = self.place(geometry, xy);
        let place = place.unwrap_or([0.5; 2]).map(|along| along.clamp(0.0, 1.0));
        (place, geometry.solid_angle_density(xy))
    }

    /// The place in the chart of a line at (x, y) of an image plane.
    fn place(&self, geometry: &dyn ViewGeometry, xy: [f64; 2]) -> Option<[f64; 2]> {
        geometry.line(xy).and_then(|line| self.chart.place(&line))
    }

    /// The place in the chart of the line at (x, y) of the only image plane; `None` if there is no image, or if there
    /// are several.
    pub(super) fn place_on_only(&self, xy: [f64; 2]) -> Option<[f64; 2]> {
        let [geometry] = self.geometries[..] else { return None };
        let has_image = geometry.solid_angle_density(xy) > 0.0 || !geometry.has_rim();
        self.place(geometry, xy).filter(|_| has_image)
    }

    /// The number of the pixel that sees the line at a place of the chart, or lines near it; `None` if these are not
    /// in view, either: a cell of the lattice may be in view although its centre is not.
    pub(super) fn pixel_near(&self, uv: [f64; 2]) -> Option<usize> {
        let from_middle = uv.map(|along| along - 0.5);
        let distance = from_middle[0].hypot(from_middle[1]);
        // No cell reaches further than half of the diagonal of a base cell, and the lines of a view are about its
        // middle.
        (0..=STEPS_INWARDS).find_map(|step| {
            let nearer = distance - BASE_CELL * step as f64 / STEPS_INWARDS as f64;
            let share = (nearer / distance).max(0.0);
            if step == 0 {
                self.pixel(uv)
            } else {
                self.pixel(from_middle.map(|along| 0.5 + share * along))
            }
        })
    }

    /// The number of the pixel that sees the line at a place of the chart; `None` if it is not in view.
    pub(super) fn pixel(&self, uv: [f64; 2]) -> Option<usize> {
        let [height, width] = self.tile;
        let (tile, xy) = self.chart.seen(uv)?;
        let at = |along: f64, count: usize| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "0 to the number of pixels"
            )]
            let at = (along * count as f64) as usize;
            at.min(count.saturating_sub(1))
        };
        Some((tile * height + at(xy[1], height)) * width + at(xy[0], width))
    }
}

/// Unit vectors away from the observer, and the rates at points that are known.
pub(super) fn known_rates(parts: &Parts<'_>, samples: &[PartSamples]) -> Vec<([f64; 3], f64)> {
    let of_parts = parts.parts.iter().zip(samples);
    let of_part = |(part, samples): (&Part<'_>, &PartSamples)| {
        let chart: &dyn Chart = &*part.chart;
        let rates = samples.points.iter().zip(&samples.rates);
        let of_point = rates.map(|(point, rate)| {
            let towards = chart.world_from_chart(*point).direction.map(|along| -along);
            (towards, rate.abs() * chart.density([point[0], point[1]]))
        });
        of_point.collect::<Vec<_>>()
    };
    of_parts.flat_map(of_part).collect()
}
