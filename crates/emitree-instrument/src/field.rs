//! Sums over the field of view; pixels that are not numbers are outside of it.

use emitree::{Cube, Image};

/// The sum of the pixels in the field.
pub(crate) fn total(image: &Image) -> f64 {
    image.pixels().iter().filter(|pixel| !pixel.is_nan()).sum()
}

/// The sum of the voxels in the field.
pub(crate) fn total_of(cube: &Cube) -> f64 {
    cube.bands().iter().map(total).sum()
}
