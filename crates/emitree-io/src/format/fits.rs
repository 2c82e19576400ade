//! FITS: all maps of a product, with units, coordinates and provenance.

use super::{EncodeError, FormatDescription, PictureStyle};
use crate::fits::HealpixFile;
use crate::product::{FitsProduct, Product, scene_history};
use crate::sky::Sky;

pub(super) const FITS: FormatDescription = FormatDescription {
    name: "FITS",
    endings: &["fits", "fit"],
    is_default: true,
    is_picture: false,
    image: "an HDU for each map, with units, coordinates and provenance",
    cube: "an HDU for each map, whose third axis is the energy or the channel",
    sky: "a table with a row for each pixel and a column for each band of a map",
    most_maps_of_sky: Some(HealpixFile::MOST_COLUMNS),
    encode,
};

fn encode(product: &Product<'_>, _: PictureStyle) -> Result<Vec<u8>, EncodeError> {
    let scene = product.scene;
    let file = FitsProduct {
        maps: std::iter::once(product.map).chain(product.others.iter().copied()).collect(),
        is_sky: scene.camera.description().is_sky(),
        wcs: scene.celestial_wcs(),
        coordinates: scene.sky.as_ref().and_then(Sky::healpix_system),
        energies: product.energies(),
        provenance: product.provenance.clone(),
        history: scene_history(&scene.text, &scene.overrides),
    };
    Ok(file.encode()?)
}
