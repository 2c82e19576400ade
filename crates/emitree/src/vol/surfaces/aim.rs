//! What a surface may be wrong by: displacements allowed, from their effect on the image.

use crate::image::Image;
use crate::projection::Chart;
use crate::projection::vector::along;
use crate::vol::surfaces::octree::{Cell, Grid};
use crate::vol::surfaces::patch::Patch;
use crate::vol::surfaces::sky::Sky;
use crate::vol::surfaces::visible::Visible;
use crate::vol::tuning::TUNING;

/// The error allowed in the image, and the image's scale.
pub(super) struct Aim<'a> {
    /// The error allowed in a pixel.
    pub(super) target: f64,
    /// 1 in the pixels of the image, and 0 where the projection has none.
    pub(super) scale: &'a Image,
    /// Where lines of sight end, if there are opaque bodies, and which pixels limbs or a rim cross.
    pub(super) visible: Option<Visible<'a>>,
    /// The lines of pixels, if the chart is not the image plane.
    pub(super) sky: Option<&'a Sky<'a>>,
    /// The image plane with its density of solid angle; without one, that is 1.
    pub(super) plane: Option<&'a dyn Chart>,
}

impl Aim<'_> {
    /// The number of the pixel at (x, y) on the image plane.
    pub(super) fn pixel(&self, [x, y]: [f64; 2]) -> usize {
        let [height, width] = [self.scale.height(), self.scale.width()];
        let [row, column] = [(y, height), (x, width)].map(|(along, pixels)| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "0 or more"
            )]
            let at = (along * pixels as f64).max(0.0) as usize;
            at.min(pixels.saturating_sub(1))
        });
        row * width + column
    }

    /// The canonical (x, y) of the line at a place of a pixel, from 0 to 1, and its weight in the mean.
    pub(super) fn line(&self, pixel: usize, place @ [u, v]: [f64; 2]) -> ([f64; 2], f64) {
        if let Some(sky) = self.sky {
            return sky.line(pixel, place);
        }
        let [height, width] = [self.scale.height(), self.scale.width()];
        let [column, row] = [(pixel % width) as f64 + u, (pixel / width) as f64 + v];
        let xy = [column / width as f64, row / height as f64];
        (xy, self.plane.map_or(1.0, |plane| plane.density(xy)))
    }

    /// The change of the pixel at canonical (x, y) by that of the mean of ∫ G dz over it; 0 where there is no
    /// image near it.
    pub(super) fn effect(&self, xy: [f64; 2]) -> f64 {
        let pixel = self.sky.map_or(Some(self.pixel(xy)), |sky| sky.pixel_near(xy));
        pixel.and_then(|pixel| self.scale.pixels().get(pixel)).copied().unwrap_or(0.0)
    }

    /// Whether the line at canonical (x, y) is in view.
    pub(super) fn is_in_view(&self, xy: [f64; 2]) -> bool {
        self.effect(xy) > 0.0 && self.sky.is_none_or(|sky| sky.pixel(xy).is_some())
    }

    /// The error allowed in ∫ G dz of a line; infinite where there is no image.
    pub(super) fn of_line(&self, xy: [f64; 2]) -> f64 {
        let effect = self.effect(xy);
        if effect > 0.0 { self.target / effect } else { f64::INFINITY }
    }

    /// The depths, in the coordinates of a grid, between which the line there is seen.
    pub(super) fn ends_of_line(&self, grid: &Grid, [x, y]: [f64; 2]) -> [f64; 2] {
        let of_canonical = |of: &Visible<'_>| of.ends([x / grid.edges[0], y / grid.edges[1]]);
        let ends = self.visible.as_ref().map_or([0.0, 1.0], of_canonical);
        ends.map(|end| grid.edges[2] * end)
    }

    /// Whether no line of sight reaches a point.
    pub(super) fn hides(&self, grid: &Grid, [x, y, z]: [f64; 3]) -> bool {
        if self.visible.is_none() {
            return false;
        }
        let [from, to] = self.ends_of_line(grid, [x, y]);
        z < from || z > to
    }

    /// A point of a cell that a line of sight reaches; `None` if no line does.
    pub(super) fn place_in_view(&self, grid: &Grid, (level, at): Cell) -> Option<[f64; 3]> {
        let Some(visible) = &self.visible else { return Some(grid.centre((level, at))) };
        let [low, high] = [0.0, 1.0]
            .map(|side| grid.canonical(grid.point(level, at.map(|k| f64::from(k) + side))));
        visible.place_in_view([low, high]).map(|at| grid.at_canonical(at))
    }

    /// The numbers of pixels along x and y of the chart.
    pub(super) fn pixels_across(&self) -> [f64; 2] {
        match self.sky {
            Some(sky) => [1.0 / sky.pixel_size; 2],
            None => [self.scale.width() as f64, self.scale.height() as f64],
        }
    }

    /// The longest edge of a pixel in the coordinates of a grid.
    pub(super) fn pixel_size(&self, grid: &Grid) -> f64 {
        let [across, along] = self.pixels_across();
        (grid.edges[0] / across).max(grid.edges[1] / along)
    }

    /// The displacement of a patch along its normal that is allowed at a jump: tight where lines of
    /// sight are tangent to the surface, and loose elsewhere. The middle of the patch of a cell at the border of a
    /// view may be out of view although a part of the cell is not.
    pub(super) fn displacement(
        &self,
        grid: &Grid,
        patch: &Patch,
        (size, centre): (f64, [f64; 3]),
        jump: f64,
    ) -> f64 {
        let curvature = patch.curvature().max(1e-9);
        let middle = patch.middle();
        let across = |u: f64, v: f64| {
            let [a, b] = patch.tangents();
            let n = patch.normal(along(along(middle, u * size, a), v * size, b));
            n[2] * n[2]
        };
        let places = [-0.5, 0.0, 0.5];
        let least = places.iter().flat_map(|&u| places.iter().map(move |&v| (u, v)));
        let least = least.map(|(u, v)| across(u, v)).fold(f64::INFINITY, f64::min);
        let tangent = 0.5 * self.pixel_size(grid) * curvature;
        let [of_middle, of_centre] = [middle, centre].map(|at| self.across(grid, at, jump));
        let across = if of_middle < grid.edges[2] { of_middle } else { of_centre };
        across * (least + tangent).sqrt()
    }

    /// The displacement along z that is allowed at a jump.
    pub(super) fn across(&self, grid: &Grid, at: [f64; 3], jump: f64) -> f64 {
        let [x, y, _] = grid.canonical(at);
        let of_line = TUNING.surfaces.patch_share * self.of_line([x, y]);
        (of_line * grid.edges[2] / jump.max(f64::MIN_POSITIVE)).min(grid.edges[2])
    }
}
