//! FITS files of a rendering: images and cubes in HDUs, or columns of one table for a sky.

use super::map::{Map, Rendered};
use super::outputs::Product;
use crate::failure::Failure;
use emitree::{Healpix, RenderedTree};
use emitree_io::units::Unit;
use emitree_io::{CameraKind, Card, FitsFile, FitsImage, HealpixColumn, HealpixFile, Scene};
use std::time::SystemTime;

/// One of the maps of a file: its name, its values and their unit, which may be empty.
pub(super) type NamedMap<'a> = (&'static str, &'a Map, &'a str);

/// The bytes of a file with a product and the maps that go with it.
pub(super) fn encode(
    scene: &Scene,
    rendered: &Rendered,
    product: &Product<'_>,
) -> Result<Vec<u8>, Failure> {
    let mut provenance = provenance(scene, rendered);
    provenance.extend(product.provenance.iter().cloned());
    let history = history(scene);
    let date = Some(SystemTime::now());
    let first = (product.name, product.map, product.unit);
    let energies = scene.energy.as_ref().filter(|_| product.map.has_energies());
    if scene.camera.kind() == CameraKind::Healpix {
        let maps = std::iter::once(&first).chain(&product.others);
        let columns: Vec<Column<'_>> = maps.flat_map(columns).collect();
        let columns = columns.iter().map(|column| HealpixColumn {
            name: &column.name,
            unit: known(column.unit),
            values: &column.values,
        });
        let columns = columns.collect();
        let file = HealpixFile { columns, coordinates: None, energies, provenance, history, date };
        return Ok(file.encode()?);
    }
    let length = scene.length_unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
    let wcs = scene.camera.wcs(scene.height, scene.width, &length.unwrap_or_else(Unit::one));
    let extensions: Vec<FitsImage<'_>> = product.others.iter().map(image).collect();
    let primary = image(&first);
    Ok(FitsFile { primary, extensions, wcs, energies, provenance, history, date }.encode()?)
}

fn image<'a>((name, map, unit): &NamedMap<'a>) -> FitsImage<'a> {
    map.fits(name, known(unit))
}

/// A unit, if it is told.
fn known(unit: &str) -> Option<&str> {
    Some(unit).filter(|unit| !unit.is_empty())
}

/// A column of a table of the sky.
struct Column<'a> {
    name: String,
    unit: &'a str,
    values: Vec<f64>,
}

/// A column for each band: `RADIANCE`, or `RADIANCE_1`, `RADIANCE_2` and so on of a cube.
fn columns<'a>((name, map, unit): &NamedMap<'a>) -> Vec<Column<'a>> {
    let number = |bin: usize| if map.is_cube() { format!("_{}", bin + 1) } else { String::new() };
    let column = |(bin, band)| Column {
        name: format!("{name}{}", number(bin)),
        unit,
        values: Healpix::nested(band),
    };
    map.bands().iter().enumerate().map(column).collect()
}

/// How the image came about.
fn provenance(scene: &Scene, rendered: &Rendered) -> Vec<Card> {
    let value = if rendered.map.is_cube() { "voxel" } else { "pixel" };
    let mut provenance = vec![
        Card::new("SCENE", scene.name.as_str(), "scene file, in full under HISTORY"),
        Card::new("METHOD", scene.render.method.name(), "from the emission to the image"),
        Card::new("NEVAL", rendered.stats.evaluations, "evaluations of the emission rate"),
        Card::new("CONVERGD", rendered.converged(), "the method ended by itself"),
    ];
    if let Some(energies) = rendered.energies() {
        provenance.push(Card::new("NENERGY", energies, "energies that were evaluated"));
    }
    if let Some(tolerance) = scene.render.tolerance {
        let meaning = format!("error asked for / largest {value}");
        provenance.push(Card::new("TOLERANC", tolerance, meaning));
    }
    if let Some(error) = rendered.estimated_error() {
        let meaning = format!("estimated error / largest {value}");
        provenance.push(Card::new("ESTERROR", error, meaning));
    }
    if let Some(RenderedTree { tree, threshold }) = &rendered.tree {
        provenance.push(Card::new("THRESHLD", *threshold, "details below it were dropped"));
        provenance.push(Card::new("ORDER", tree.order(), "order of the prediction"));
    }
    if let Some(base_level) = rendered.stats.base_level {
        let base_level = i32::from(base_level);
        provenance.push(Card::new("BASELEVL", base_level, "2^this base intervals along each axis"));
    }
    if let Some(unit) = &scene.length_unit {
        provenance.push(Card::new("LENUNIT", unit.as_str(), "unit of length of the scene"));
    }
    provenance
}

/// The scene with what the command line changed.
pub(crate) fn history(scene: &Scene) -> String {
    let mut history = scene.text.trim_end().to_owned() + "\n";
    for change in &scene.overrides {
        history.push_str(&format!("# command line: {change}\n"));
    }
    history
}
