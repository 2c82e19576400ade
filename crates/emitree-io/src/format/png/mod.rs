//! PNG: a picture of the main map of a product, bare or with axes, a title and a colour bar.

#[cfg(feature = "figure")]
mod annotated;
mod sheet;

use super::{EncodeError, FormatDescription};
use crate::colour::ValueRange;
use crate::mollweide::picture_of_sky;
use crate::png::{PictureOptions, encode_png};
use crate::product::Product;
use crate::scene::{PixelLayout, Scene};
use emitree::Image;
use emitree::projection::ViewGeometry;
use std::borrow::Cow;

pub(super) const PNG: FormatDescription = FormatDescription {
    name: "PNG",
    endings: &["png"],
    is_default: true,
    is_picture: true,
    image: "a picture, for looking",
    cube: "a sheet with a tile for each bin or channel, or for several where there are many",
    sky: "Mollweide's projection, as the sky is seen from inside",
    most_maps_of_sky: None,
    encode,
};

/// How pictures look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureStyle {
    /// A pixel of the image is one of the file.
    Bare {
        /// The values of the first and the last colour; without it those of the map.
        range: Option<ValueRange>,
    },
    /// With axes, a title and a colour bar.
    #[cfg(feature = "figure")]
    Annotated {
        /// Whether equal ratios, and not equal differences, are uniform steps of colour.
        logarithmic: bool,
    },
}

impl Default for PictureStyle {
    /// A bare picture in the colours of the map.
    fn default() -> Self {
        Self::Bare { range: None }
    }
}

fn encode(product: &Product<'_>, style: PictureStyle) -> Result<Vec<u8>, EncodeError> {
    match style {
        PictureStyle::Bare { range } => bare(product, range),
        #[cfg(feature = "figure")]
        PictureStyle::Annotated { logarithmic } => annotated::annotated(product, logarithmic),
    }
}

/// The bytes of a bare picture, a sheet of all bands if it is of a cube.
fn bare(product: &Product<'_>, range: Option<ValueRange>) -> Result<Vec<u8>, EncodeError> {
    let (scene, unit) = (product.scene, product.map.unit);
    let is_sky = scene.camera.description().is_sky();
    let options = PictureOptions {
        range,
        title: Some(scene.name.clone()),
        unit: Some(unit.to_owned()).filter(|unit| !unit.is_empty()),
        // A disc and a sky have corners where there is nothing, and a sheet has gaps.
        blank_outside: scene
            .camera
            .projection()
            .view_geometry()
            .is_some_and(ViewGeometry::has_regions)
            || is_sky
            || product.map.is_cube(),
        ..Default::default()
    };
    let tiles = sheet::tiles(&product.map, product.energies());
    let rows = if tiles.len() > 1 { SKY_ROWS_OF_TILE } else { [LEAST_SKY_ROWS, MOST_SKY_ROWS] };
    let images: Vec<Image> =
        tiles.into_iter().map(|tile| flat(tile.image, scene, rows).into_owned()).collect();
    Ok(encode_png(&sheet::joined(&images), &options)?)
}

/// Rows of the picture of a sky, for each pixel along the edge of a face, at the least and the most.
const SKY_ROWS_PER_PIXEL: usize = 4;
const LEAST_SKY_ROWS: usize = 256;
const MOST_SKY_ROWS: usize = 2048;
/// Of each of many bands, at the least and the most.
const SKY_ROWS_OF_TILE: [usize; 2] = [96, 256];

/// The image as a picture shows it: the whole sky as an ellipse of so many rows at the least and at
/// the most.
fn flat<'a>(image: Cow<'a, Image>, scene: &Scene, [least, most]: [usize; 2]) -> Cow<'a, Image> {
    match scene.camera.description().pixels {
        PixelLayout::Rectangle => image,
        PixelLayout::Healpix => {
            let rows = (SKY_ROWS_PER_PIXEL * image.width()).clamp(least, most);
            Cow::Owned(picture_of_sky(&image, rows))
        }
    }
}
