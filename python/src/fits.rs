//! FITS files of a rendering: images and cubes in HDUs, or columns of one table for a sky.

use emitree::{Cube, Healpix};
use emitree_io::units::Unit;
use emitree_io::{
    CameraKind, Card, FitsEncodeError, FitsFile, FitsImage, HealpixColumn, HealpixFile, Scene, Wcs,
};
use std::time::SystemTime;

/// The coordinates of the pixels; none for a sky in `HEALPix` pixels.
pub(crate) fn coordinates(scene: &Scene) -> Option<Wcs> {
    let length = scene.length_unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
    scene.camera.wcs(scene.height, scene.width, &length.unwrap_or_else(Unit::one))
}

/// The bytes of a file with named maps, the first of which is the main one.
pub(crate) fn encode(
    scene: &Scene,
    maps: &[(&str, &Cube)],
    provenance: Vec<Card>,
) -> Result<Vec<u8>, FitsEncodeError> {
    let unit = Some(scene.image_unit()).filter(|unit| !unit.is_empty());
    let energies = scene.energy.as_ref();
    let (history, date) = (scene.text.clone(), Some(SystemTime::now()));
    let names: Vec<String> = maps.iter().map(|(name, _)| name.to_uppercase()).collect();
    if scene.camera.kind() == CameraKind::Healpix {
        let maps = names.iter().zip(maps);
        let columns: Vec<(String, Vec<f64>)> =
            maps.flat_map(|(name, (_, map))| columns(name, map, energies.is_some())).collect();
        let columns =
            columns.iter().map(|(name, values)| HealpixColumn { name, unit, values }).collect();
        let coordinates = None;
        return HealpixFile { columns, coordinates, energies, provenance, history, date }.encode();
    }
    let named = names.iter().zip(maps);
    let mut images = named.map(|(name, (_, map))| hdu(name, map, unit, energies.is_some()));
    let Some(primary) = images.next() else { return Ok(Vec::new()) };
    let (extensions, wcs) = (images.collect(), coordinates(scene));
    FitsFile { primary, extensions, wcs, energies, provenance, history, date }.encode()
}

/// An image or a cube as an HDU.
fn hdu<'a>(name: &'a str, map: &'a Cube, unit: Option<&'a str>, is_cube: bool) -> FitsImage<'a> {
    match map.bands() {
        [image] if !is_cube => FitsImage::new(name, image, unit),
        _ => FitsImage::cube(name, map, unit),
    }
}

/// A column for each band: `RADIANCE`, or `RADIANCE_1`, `RADIANCE_2` and so on of a cube.
fn columns(name: &str, map: &Cube, is_cube: bool) -> Vec<(String, Vec<f64>)> {
    let number = |bin: usize| if is_cube { format!("_{}", bin + 1) } else { String::new() };
    let bands = map.bands().iter().enumerate();
    bands.map(|(bin, band)| (format!("{name}{}", number(bin)), Healpix::nested(band))).collect()
}
