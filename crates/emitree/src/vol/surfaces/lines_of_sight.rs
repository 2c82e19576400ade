//! The lines of sight of a view as one part, in whose coordinates surfaces are searched for: those of the image plane,
//! or, where that is no chart for surfaces, of a chart of all lines.

use crate::image::Image;
use crate::projection::charts::chart::AcrossGap;
use crate::projection::charts::depth::Weights;
use crate::projection::charts::unclipped::{CommonEnds, Unclipped};
use crate::projection::{Chart, MappedPoint, SightLine, Surroundings};
use crate::radiance::radiance_per_density;
use crate::tile::Tile;
use crate::vol::surfaces::sky::{Sky, is_regular};
use crate::vol::view::part::{Part, Parts, parts as parts_of};
use std::sync::Arc;

/// The coordinates of the lines of sight in which surfaces are searched for.
pub(super) struct LinesOfSight<'a> {
    /// The image planes, if the parts of the view are charts about bodies or layers.
    planes: Option<Parts<'a>>,
    /// All lines in one chart, if the image plane is not one for surfaces.
    pub(super) sky: Option<Sky<'a>>,
    /// Whether lines of sight end at bodies.
    has_bodies: bool,
    /// What bounds clip the lines, and the distances at which all lines begin and end nevertheless.
    unclipped: Option<(&'a Surroundings, CommonEnds)>,
}

impl<'a> LinesOfSight<'a> {
    /// Those of a view with these parts, given the brightness in some directions; `None` if there is no chart.
    pub(super) fn new(
        tiles: &[Tile<'a>],
        parts: &Parts<'a>,
        brightness: &[([f64; 3], f64)],
    ) -> Option<Self> {
        // Bodies hide a part of the lines of sight, but do not end the chart of the image plane.
        let has_bodies = parts.parts.iter().any(|part| !part.footing.is_of_pixels());
        let is_divided = has_bodies || parts.parts.len() > tiles.len();
        let planes = is_divided.then(|| parts_of(tiles, None, None));
        let plane = &planes.as_ref().unwrap_or(parts).parts[..];
        let sky = match plane {
            [part] if is_regular(part) => None,
            _ => Some(Sky::new(tiles, brightness)?),
        };
        let chart = match &sky {
            Some(sky) => sky.chart(),
            None => &*plane.first()?.chart,
        };
        let around = tiles.first()?.projection.view_geometry().and_then(|of| of.surroundings());
        let unclipped = around.and_then(|around| Some((around, CommonEnds::of(chart, around)?)));
        Some(Self { planes, sky, has_bodies, unclipped })
    }

    /// All of the view as one part, on which G = g · ds/dz: where g is constant, G is. Its scale is 1 in the pixels of
    /// the image, which are means weighted with solid angle.
    pub(super) fn part<'s>(&'s self, tiles: &[Tile<'a>], parts: &'s Parts<'a>) -> Option<Part<'s>> {
        let scale = Arc::new(in_view(tiles));
        let part = match &self.sky {
            Some(sky) => sky.part(scale),
            None => {
                let plane = self.plane(parts)?;
                let chart = Box::new(Even { chart: &*plane.chart });
                Part { chart, scale, footing: Arc::clone(&plane.footing), ..*plane }
            }
        };
        let Some((around, ends)) = self.unclipped else { return Some(part) };
        let least_feature = part.least_feature * ends.share.cbrt();
        let chart = Box::new(Unclipped::new(part.chart, around, ends));
        Some(Part { chart, least_feature, ..part })
    }

    /// The image plane.
    pub(super) fn plane<'s>(&'s self, parts: &'s Parts<'a>) -> Option<&'s Part<'a>> {
        self.planes.as_ref().unwrap_or(parts).parts.first()
    }

    /// Whether its coordinates are those of the only part of the view.
    pub(super) fn are_of_parts(&self) -> bool {
        self.planes.is_none() && self.sky.is_none() && self.unclipped.is_none()
    }

    /// The parts that know where lines of sight end, and which pixels limbs or a rim cross.
    pub(super) fn limbs<'s>(&'s self, parts: &'s Parts<'a>) -> Option<&'s Parts<'a>> {
        let planes = self.planes.as_ref().unwrap_or(parts);
        if self.has_bodies {
            return Some(parts);
        }
        Some(planes).filter(|of| of.has_rim() || self.unclipped.is_some())
    }
}

/// 1 in the pixels of the image, and 0 where the projection has none.
pub(super) fn in_view(tiles: &[Tile<'_>]) -> Image {
    let scales = tiles.iter().map(|tile| radiance_per_density(tile.projection, tile.shape));
    let scales: Vec<Image> = scales.collect();
    let (height, width) = (scales.iter().map(Image::height).sum(), scales[0].width());
    let pixels = scales.iter().flat_map(Image::pixels);
    let pixels = pixels.map(|scale| f64::from(u8::from(*scale > 0.0))).collect();
    Image::from_pixels(height, width, pixels)
}

/// An image plane on which all lines have the same weight.
#[derive(Debug)]
struct Even<'a> {
    chart: &'a dyn Chart,
}

impl Chart for Even<'_> {
    fn world_from_chart(&self, u: [f64; 3]) -> MappedPoint {
        self.chart.world_from_chart(u)
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        self.chart.chart_from_world(position)
    }

    fn density(&self, _uv: [f64; 2]) -> f64 {
        1.0
    }

    fn line(&self, uv: [f64; 2]) -> Option<SightLine> {
        self.chart.line(uv)
    }

    fn depth_of(&self, line: &SightLine, distance: f64) -> f64 {
        self.chart.depth_of(line, distance)
    }

    fn depth_shares(&self, u: [f64; 3]) -> Option<Weights> {
        self.chart.depth_shares(u)
    }

    fn visible_end(&self, uv: [f64; 2]) -> Option<(usize, f64)> {
        self.chart.visible_end(uv)
    }

    fn has_gaps(&self) -> bool {
        self.chart.has_gaps()
    }

    fn across_gap(&self, u: [f64; 3]) -> Option<AcrossGap> {
        self.chart.across_gap(u)
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        self.chart.image_place(uv)
    }
}
