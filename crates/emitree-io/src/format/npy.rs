//! NPY: the numbers of the main map of a product, and nothing else.

use super::{EncodeError, FormatDescription, PictureStyle};
use crate::npy::{encode_npy, encode_npy_cube, encode_npy_image};
use crate::product::Product;
use crate::scene::PixelLayout;
use emitree::Healpix;

pub(super) const NPY: FormatDescription = FormatDescription {
    name: "NPY",
    endings: &["npy"],
    is_default: true,
    is_picture: false,
    image: "an array (height, width), row 0 at the bottom",
    cube: "an array (bins, height, width)",
    sky: "an array of the pixels in nested order, (12 nside²) or (bins, 12 nside²)",
    most_maps_of_sky: None,
    encode,
};

fn encode(product: &Product<'_>, _: PictureStyle) -> Result<Vec<u8>, EncodeError> {
    let (map, is_cube) = (product.map.map, product.map.is_cube());
    let bands = map.bands();
    Ok(match (product.scene.camera.description().pixels, bands) {
        (PixelLayout::Rectangle, [image]) if !is_cube => encode_npy_image(image),
        (PixelLayout::Rectangle, _) => encode_npy_cube(map),
        (PixelLayout::Healpix, _) => {
            let nested: Vec<f64> = bands.iter().flat_map(Healpix::nested).collect();
            let shape = [bands.len(), nested.len() / bands.len().max(1)];
            encode_npy(if is_cube { &shape } else { &shape[1..] }, &nested)?
        }
    })
}
