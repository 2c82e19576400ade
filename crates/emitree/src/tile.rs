//! Tiles: the squares of an image that projections map one by one.

use crate::error::{OptionError, RenderError};
use crate::image::Image;
use crate::projection::{Projection, Region};
use crate::radiance::PixelRows;

/// One square of an image: all of it, or one of several in a stack.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile<'a> {
    pub(crate) projection: &'a dyn Projection,
    /// Height and width in pixels.
    pub(crate) shape: [usize; 2],
    /// Its number from the lowest, and the number of all.
    pub(crate) place: (usize, usize),
}

impl<'a> Tile<'a> {
    /// Height and width of the image of all tiles.
    pub(crate) fn shape_of_image(&self) -> [usize; 2] {
        let [height, width] = self.shape;
        [height * self.place.1, width]
    }

    /// The tiles of a projection's image, the lowest first.
    pub(crate) fn of<E>(
        projection: &'a dyn Projection,
        [height, width]: [usize; 2],
    ) -> Result<Vec<Self>, RenderError<E>> {
        let tiles = projection.tiles();
        let count = tiles.len();
        if count == 0 {
            let shape = [height, width];
            if !has_image(&PixelRows { projection, shape }) {
                return Err(RenderError::NoSolidAngle);
            }
            return Ok(vec![Self { projection, shape, place: (0, 1) }]);
        }
        if !height.is_multiple_of(count) {
            return Err(OptionError::RowsOfTiles(height).into());
        }
        let tile = |(number, projection)| Self {
            projection,
            shape: [height / count, width],
            place: (number, count),
        };
        Ok(tiles.into_iter().enumerate().map(tile).collect())
    }

    /// Finds a pixel of the tile whose sum is not finite, although the rates are, in an image in which
    /// the tile begins at a row.
    pub(crate) fn check_finite<E>(
        &self,
        image: &Image,
        first_row: usize,
    ) -> Result<(), RenderError<E>> {
        let [height, width] = self.shape;
        for row_of_tile in 0..height {
            let row = row_of_tile + self.place.0 * height;
            for (column, &value) in image.row(first_row + row_of_tile).iter().enumerate() {
                let middle = [(column, width), (row_of_tile, height)];
                let middle = middle.map(|(at, pixels)| (at as f64 + 0.5) / pixels as f64);
                if !value.is_finite() && self.projection.region(middle) != Region::Outside {
                    return Err(RenderError::ImageNotFinite { row, column, value });
                }
            }
        }
        Ok(())
    }
}

/// Whether any pixel has a solid angle.
fn has_image(rows: &PixelRows<'_>) -> bool {
    let [height, width] = rows.shape;
    let mut solid_angles = vec![0.0; width];
    (0..height).any(|row| {
        rows.solid_angles(row, &mut solid_angles);
        solid_angles.iter().any(|&angle: &f64| angle > 0.0 && angle.is_finite())
    })
}
