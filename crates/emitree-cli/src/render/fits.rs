//! FITS files of a rendering: what the maps of a product are, and how they came about.

use super::map::{Kind, Map, Rendered};
use super::outputs::Product;
use crate::failure::Failure;
use emitree::Method;
use emitree_io::units::Unit;
use emitree_io::{Bands, CameraKind, FitsProduct, ProductMap, Provenance, Scene, scene_history};

/// One of the maps of a file: its name, its values and their unit, which may be empty.
pub(super) type NamedMap<'a> = (&'static str, &'a Map, &'a str);

/// The bytes of a file with a product and the maps that go with it.
pub(super) fn encode(
    scene: &Scene,
    rendered: &Rendered,
    product: &Product<'_>,
) -> Result<Vec<u8>, Failure> {
    let length = scene.length_unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
    let first = (product.name, product.map, product.unit);
    let mut provenance = provenance(scene, rendered).cards();
    provenance.extend(product.provenance.iter().cloned());
    let file = FitsProduct {
        maps: std::iter::once(&first).chain(&product.others).map(map).collect(),
        is_sky: scene.camera.kind() == CameraKind::Healpix,
        wcs: scene.camera.wcs(scene.height, scene.width, &length.unwrap_or_else(Unit::one)),
        energies: scene.energy.as_ref().filter(|_| product.map.has_energies()),
        provenance,
        history: scene_history(&scene.text, &scene.overrides),
    };
    Ok(file.encode()?)
}

fn map<'a>(&(name, map, unit): &NamedMap<'a>) -> ProductMap<'a> {
    let bands = match map.kind() {
        Kind::Image => Bands::Image,
        Kind::Energies | Kind::Counts { are_bins: true, .. } => Bands::Energies,
        Kind::Counts { channels, are_bins: false } => Bands::Channels(channels),
    };
    ProductMap { name, map: map.cube(), unit, bands }
}

/// How the image came about.
fn provenance<'a>(scene: &'a Scene, rendered: &Rendered) -> Provenance<'a> {
    Provenance {
        scene: &scene.name,
        method: scene.render.method.name(),
        evaluations: rendered.stats.evaluations,
        converged: rendered.converged(),
        energies: rendered.energies(),
        tolerance: scene.render.tolerance,
        estimated_error: rendered.estimated_error(),
        threshold: rendered.tree.as_ref().map(|tree| tree.threshold),
        order: match &scene.render.method {
            Method::Paper(options) => Some(options.order),
            _ => None,
        },
        base_level: rendered.stats.base_level,
        length_unit: scene.length_unit.as_deref(),
        is_cube: rendered.map.is_cube(),
    }
}
