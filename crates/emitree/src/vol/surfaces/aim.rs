//! What a surface may be wrong by: displacements allowed, from their effect on the image.

use crate::image::Image;
use crate::projection::vector::along;
use crate::vol::surfaces::octree::{Cell, Grid};
use crate::vol::surfaces::patch::Patch;
use crate::vol::surfaces::visible::Visible;
use crate::vol::tuning::TUNING;

/// The error allowed in the image, and the image's scale.
pub(super) struct Aim<'a> {
    /// The error allowed in a pixel.
    pub(super) target: f64,
    /// The ratio of each pixel to the mean of G over it.
    pub(super) scale: &'a Image,
    /// Where lines of sight end, if there are opaque bodies.
    pub(super) visible: Option<Visible<'a>>,
}

impl Aim<'_> {
    /// The number of the pixel at canonical (x, y).
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

    /// The first corner of a pixel, in pixels.
    pub(super) fn corner(&self, pixel: usize) -> [f64; 2] {
        let width = self.scale.width();
        [(pixel % width) as f64, (pixel / width) as f64]
    }

    /// The error allowed in ∫ G dz of a line; infinite where there is no image.
    pub(super) fn of_line(&self, xy: [f64; 2]) -> f64 {
        let scale = self.scale.pixels().get(self.pixel(xy)).copied().unwrap_or(0.0);
        if scale > 0.0 { self.target / scale } else { f64::INFINITY }
    }

    /// The depth, in the coordinates of a grid, at which the line there ends.
    pub(super) fn end_of_line(&self, grid: &Grid, [x, y]: [f64; 2]) -> f64 {
        let of_canonical = |of: &Visible<'_>| of.depth([x / grid.edges[0], y / grid.edges[1]]);
        grid.edges[2] * self.visible.as_ref().map_or(1.0, of_canonical)
    }

    /// Whether no line of sight reaches a point.
    pub(super) fn hides(&self, grid: &Grid, [x, y, z]: [f64; 3]) -> bool {
        self.visible.is_some() && z > self.end_of_line(grid, [x, y])
    }

    /// Whether no line of sight reaches a cell.
    pub(super) fn hides_cell(&self, grid: &Grid, (level, at): Cell) -> bool {
        let Some(visible) = &self.visible else { return false };
        let [low, high] = [0.0, 1.0]
            .map(|side| grid.canonical(grid.point(level, at.map(|k| f64::from(k) + side))));
        visible.end_before([[low[0], low[1]], [high[0], high[1]]], low[2])
    }

    /// The longest edge of a pixel in the coordinates of a grid.
    pub(super) fn pixel_size(&self, grid: &Grid) -> f64 {
        let [height, width] = [self.scale.height(), self.scale.width()];
        (grid.edges[0] / width as f64).max(grid.edges[1] / height as f64)
    }

    /// The displacement of a patch along its normal that is allowed at a jump: tight where lines of
    /// sight are tangent to the surface, and loose elsewhere.
    pub(super) fn displacement(&self, grid: &Grid, patch: &Patch, size: f64, jump: f64) -> f64 {
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
        self.across(grid, middle, jump) * (least + tangent).sqrt()
    }

    /// The displacement along z that is allowed at a jump.
    pub(super) fn across(&self, grid: &Grid, at: [f64; 3], jump: f64) -> f64 {
        let [x, y, _] = grid.canonical(at);
        let of_line = TUNING.surfaces.patch_share * self.of_line([x, y]);
        (of_line * grid.edges[2] / jump.max(f64::MIN_POSITIVE)).min(grid.edges[2])
    }
}
