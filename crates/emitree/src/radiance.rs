//! From means over pixels to radiances, F(Ω)/Ω, and irradiances, with the solid angles of pixels.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::projection::Projection;
use crate::tree::SparseTree;
use core::ops::Range;

/// The rows of pixels of an image, and the solid angles that a projection gives them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelRows<'a> {
    pub(crate) projection: &'a dyn Projection,
    /// Height and width in pixels.
    pub(crate) shape: [usize; 2],
}

impl PixelRows<'_> {
    /// The solid angle of each pixel of a row \[sr\]: 0 where the projection has no image.
    pub(crate) fn solid_angles(&self, row: usize, solid_angles: &mut [f64]) {
        // Borders as quotients, so that neighbours share them to the last bit.
        let y = [row, row + 1].map(|r| r as f64 / self.shape[0] as f64);
        self.projection.solid_angles_of_row(y, solid_angles);
    }

    /// For each pixel of a row, its radiance over the mean of the irradiance density on it; 0 where the
    /// projection has no image.
    pub(crate) fn radiances_per_density(&self, row: usize, scale: &mut [f64]) {
        let area = 1.0 / (self.shape[0] as f64 * self.shape[1] as f64);
        self.solid_angles(row, scale);
        for scale in scale {
            *scale = if *scale > 0.0 { area / *scale } else { 0.0 };
        }
    }

    /// Some of the rows, which `fill` makes one by one, given the number of the row.
    ///
    /// # Panics
    ///
    /// If a row is not one of the image.
    pub(crate) fn block(
        &self,
        rows: Range<usize>,
        fill: impl Fn(usize, &mut [f64]) + Sync,
    ) -> Image {
        let [height, width] = self.shape;
        assert!(rows.end <= height, "rows {rows:?} of an image of {height}");
        map_of_rows([rows.len(), width], |number, values| fill(rows.start + number, values))
    }

    /// The map that `fill` makes row by row, given the number of the row.
    pub(crate) fn map(&self, fill: impl Fn(usize, &mut [f64]) + Sync) -> Image {
        map_of_rows(self.shape, fill)
    }
}

/// The map of a shape that `fill` makes row by row, given the number of the row.
pub(crate) fn map_of_rows(
    [height, width]: [usize; 2],
    fill: impl Fn(usize, &mut [f64]) + Sync,
) -> Image {
    let mut map = Image::zeros(height, width);
    let rows = map.pixels_mut().par_chunks_mut(width.max(1)).enumerate();
    rows.with_min_len(rows_at_once(width)).for_each(|(row, pixels)| fill(row, pixels));
    map
}

/// The smallest number of pixels for which another thread is worthwhile.
const PIXELS_AT_ONCE: usize = 1 << 14;

/// Rows of so many pixels that one thread makes at a time, at the least.
pub(crate) fn rows_at_once(width: usize) -> usize {
    PIXELS_AT_ONCE.div_ceil(width.max(1))
}

/// For each pixel, its radiance over the mean of the irradiance density on it; 0 where the projection
/// has no image.
pub(crate) fn radiance_per_density(projection: &dyn Projection, shape: [usize; 2]) -> Image {
    let rows = PixelRows { projection, shape };
    rows.map(|row, scale| rows.radiances_per_density(row, scale))
}

/// The solid angle of each pixel \[sr\]: 0 where the projection has no image.
pub(crate) fn solid_angles(projection: &dyn Projection, shape: [usize; 2]) -> Image {
    let rows = PixelRows { projection, shape };
    rows.map(|row, solid_angles| rows.solid_angles(row, solid_angles))
}

/// The irradiance F(Ω) of each pixel from its radiance F(Ω)/Ω, or their errors: each pixel times its
/// solid angle \[sr\].
///
/// ```
/// use emitree::radiance::irradiance_of;
/// use emitree::{Equirectangular, Image, Viewpoint};
/// use std::f64::consts::{PI, TAU};
///
/// let viewpoint =
///     Viewpoint { position: [0.0; 3], target: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
/// let sky = Equirectangular::new(viewpoint, [TAU, PI], [0.0, 1.0])?;
/// let even = Image::from_pixels(2, 3, vec![0.5; 6]);
/// let irradiance = irradiance_of(&even, &sky);
/// assert!((irradiance.pixels().iter().sum::<f64>() - TAU).abs() < 1e-12); // half of 4π
/// # Ok::<(), emitree::projection::GeometryError>(())
/// ```
pub fn irradiance_of(radiance: &Image, projection: &dyn Projection) -> Image {
    let mut image = radiance.clone();
    let solid_angles = solid_angles(projection, [radiance.height(), radiance.width()]);
    for (pixel, solid_angle) in image.pixels_mut().iter_mut().zip(solid_angles.pixels()) {
        *pixel *= solid_angle;
    }
    image
}

/// The radiance of each pixel from the tree of the irradiance density on the image plane; NaN where
/// the projection has no image.
///
/// # Panics
///
/// If the shape is one that [`SparseTree::sample`] can't make.
pub fn image_of_tree(
    tree: &SparseTree<2>,
    projection: &dyn Projection,
    [height, width]: [usize; 2],
) -> Image {
    let mut image = tree.sample(height, width);
    to_radiance(&mut image, &solid_angles(projection, [height, width]));
    image
}

/// Makes radiances of the means of the irradiance density over pixels, with the [`solid_angles`] of
/// the image; NaN where the projection has none.
pub(crate) fn to_radiance(image: &mut Image, solid_angles: &Image) {
    let (dx, dy) = (1.0 / image.width() as f64, 1.0 / image.height() as f64);
    for (pixel, &solid_angle) in image.pixels_mut().iter_mut().zip(solid_angles.pixels()) {
        // Where there is no image a pixel has no value, whatever the tree has near its edge.
        *pixel = if solid_angle > 0.0 { *pixel * dx * dy / solid_angle } else { f64::NAN };
    }
}
