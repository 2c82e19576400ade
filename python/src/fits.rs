//! FITS files of a rendering: images and cubes in HDUs, or columns of one table for a sky.

use crate::about::About;
use emitree::{Cube, Healpix};
use emitree_instrument::Channel;
use emitree_io::{
    Card, Energies, FitsEncodeError, FitsFile, FitsImage, HealpixColumn, HealpixFile,
};
use std::time::SystemTime;

/// A map of a file: its name, its values and their unit, and its channels if it has counts.
pub(crate) struct NamedMap<'a> {
    pub(crate) name: &'a str,
    pub(crate) map: &'a Cube,
    pub(crate) unit: &'a str,
    pub(crate) channels: Option<&'a [Channel]>,
}

/// The bytes of a file with named maps, the first of which is the main one.
pub(crate) fn encode(
    about: &About,
    maps: &[NamedMap<'_>],
    energies: Option<&Energies>,
    provenance: Vec<Card>,
) -> Result<Vec<u8>, FitsEncodeError> {
    let (history, date) = (about.history(), Some(SystemTime::now()));
    if about.is_sky {
        let columns: Vec<(String, &str, Vec<f64>)> =
            maps.iter().flat_map(|map| columns(map, about.bins.is_some())).collect();
        let columns = columns
            .iter()
            .map(|(name, unit, values)| HealpixColumn { name, unit: known(unit), values })
            .collect();
        let coordinates = None;
        return HealpixFile { columns, coordinates, energies, provenance, history, date }.encode();
    }
    let mut images = maps.iter().map(|map| hdu(map, about.bins.is_some()));
    let Some(primary) = images.next() else { return Ok(Vec::new()) };
    let (extensions, wcs) = (images.collect(), about.wcs());
    FitsFile { primary, extensions, wcs, energies, provenance, history, date }.encode()
}

/// A unit, if it is told.
fn known(unit: &str) -> Option<&str> {
    Some(unit).filter(|unit| !unit.is_empty())
}

/// An image, a cube or counts as an HDU.
fn hdu<'a>(named: &NamedMap<'a>, is_cube: bool) -> FitsImage<'a> {
    let NamedMap { name, map, unit, channels } = *named;
    match (map.bands(), channels) {
        (_, Some(channels)) => FitsImage::channels(name, map, channels, known(unit)),
        ([image], None) if !is_cube => FitsImage::new(name, image, known(unit)),
        _ => FitsImage::cube(name, map, known(unit)),
    }
}

/// A column for each band: `RADIANCE`, or `RADIANCE_1`, `RADIANCE_2` and so on of a cube.
fn columns<'a>(named: &NamedMap<'a>, is_cube: bool) -> Vec<(String, &'a str, Vec<f64>)> {
    let NamedMap { name, map, unit, .. } = *named;
    let number = |bin: usize| if is_cube { format!("_{}", bin + 1) } else { String::new() };
    let bands = map.bands().iter().enumerate();
    bands
        .map(|(bin, band)| (format!("{name}{}", number(bin)), unit, Healpix::nested(band)))
        .collect()
}
