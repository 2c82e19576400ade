//! FITS: all maps of a product, with units, coordinates and provenance.

use super::{EncodeError, FormatDescription, PictureStyle};
use crate::fits::HealpixFile;
use crate::product::{FitsProduct, Product, scene_history};
use crate::units::Unit;

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
    let length = scene.length_unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
    let file = FitsProduct {
        maps: std::iter::once(product.map).chain(product.others.iter().copied()).collect(),
        is_sky: scene.camera.description().is_sky(),
        wcs: scene.camera.wcs(scene.height, scene.width, &length.unwrap_or_else(Unit::one)),
        energies: product.energies(),
        provenance: product.provenance.clone(),
        history: scene_history(&scene.text, &scene.overrides),
    };
    Ok(file.encode()?)
}
