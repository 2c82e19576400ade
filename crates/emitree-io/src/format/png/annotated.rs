//! Annotated pictures: the image with its axes, a title and a colour bar, or a sheet of all bands.

use super::{EncodeError, MOST_SKY_ROWS, SKY_ROWS_OF_TILE, flat, sheet};
use crate::colour::ValueRange;
use crate::figure::{Axis, Heatmap, Panel, Sheet};
use crate::product::Product;
use crate::scene::{PlotAxis, PlotFrame, PlotScale, Scene};
use emitree::Image;
use std::borrow::Cow;
use std::path::Path;

/// Device pixels in a unit of a figure.
const SCALE: f64 = 2.0;

/// Colours of a logarithmic scale start at this fraction of the largest pixel, or at the smallest
/// pixel above 0 if that is more: errors are relative to the largest pixel, so that what is fainter
/// means little.
const FAINTEST: f64 = 1e-3;

/// Rows of the picture of a sky: as many as the panel of a figure has device pixels for.
const ANNOTATED_SKY_ROWS: usize = 320;

/// The bytes of an annotated picture: the image with its axes, or a sheet of all bands.
pub(super) fn annotated(product: &Product<'_>, logarithmic: bool) -> Result<Vec<u8>, EncodeError> {
    let scene = product.scene;
    let tiles = sheet::tiles(&product.map, product.energies());
    let rows = if tiles.len() > 1 { SKY_ROWS_OF_TILE } else { [ANNOTATED_SKY_ROWS, MOST_SKY_ROWS] };
    let labels: Vec<String> = tiles.iter().map(|tile| tile.label.clone()).collect();
    let images: Vec<Cow<'_, Image>> =
        tiles.into_iter().map(|tile| flat(tile.image, scene, rows)).collect();
    let range = colour_range(&images, logarithmic);
    let bar = format!("{} [{}]", product.meaning, typeset(product.map.unit));
    let panel = |image| {
        let panel = with_axes(Panel::new(image), scene).colour_bar(&bar);
        let panel = if logarithmic { panel.logarithmic() } else { panel };
        range.map_or(panel.clone(), |range| panel.range(range))
    };
    let title = title(&scene.name);
    let figure = match images.as_slice() {
        [image] if !product.map.is_cube() => {
            Heatmap::new().panel(panel(image).title(title)).draw()?
        }
        images => {
            let proportion = images.first().map_or(1.0, |i| i.width() as f64 / i.height() as f64);
            let sheet = Sheet::new(sheet::columns(images.len(), proportion)).title(title);
            let panels = images.iter().zip(labels);
            panels
                .fold(sheet, |sheet, (image, label)| sheet.panel(panel(image).title(label)))
                .draw()?
        }
    };
    Ok(figure.png(SCALE)?)
}

/// The colours of all tiles; none for those that a panel finds by itself.
fn colour_range(images: &[Cow<'_, Image>], logarithmic: bool) -> Option<ValueRange> {
    let images: Vec<&Image> = images.iter().map(AsRef::as_ref).collect();
    let all = ValueRange::of(&images);
    if !logarithmic {
        return Some(all);
    }
    let pixels = images.iter().flat_map(|image| image.pixels());
    let lowest = pixels.copied().filter(|&pixel| pixel > 0.0).fold(f64::INFINITY, f64::min);
    let low = lowest.max(FAINTEST * all.high);
    (low < all.high).then_some(ValueRange { low, ..all })
}

/// The name of the scene, without folder and ending.
fn title(name: &str) -> String {
    Path::new(name).file_stem().unwrap_or(name.as_ref()).to_string_lossy().into_owned()
}

/// The panel with the axes of the camera, or the ellipse that bounds its image.
fn with_axes<'a>(panel: Panel<'a>, scene: &Scene) -> Panel<'a> {
    let axis = |axis| drawn(axis, scene.length_unit.as_deref());
    match scene.camera.frame() {
        PlotFrame::Axes { x, y } => panel.axes(axis(x), axis(y)),
        PlotFrame::UnlikeAxes { x, y } => panel.axes(axis(x), axis(y)).square_pixels(),
        PlotFrame::Ellipse => panel.ellipse(),
    }
}

/// An axis with its unit, for a scene with this length unit.
fn drawn(PlotAxis { label, ends, scale }: PlotAxis, length_unit: Option<&str>) -> Axis {
    let in_degrees = || format!("{label} [deg]");
    let axis = match (scale, length_unit) {
        (PlotScale::Lengths, Some(unit)) => Axis::linear(format!("{label} [{}]", typeset(unit))),
        (PlotScale::Lengths, None) => Axis::linear(label),
        (PlotScale::Angles, _) => Axis::linear(in_degrees()),
        (PlotScale::Tangents, _) => Axis::tangent(in_degrees()),
    };
    axis.range(ends)
}

/// A unit of the FITS grammar with raised powers; 1 for none.
fn typeset(unit: &str) -> String {
    if unit.is_empty() {
        return "1".to_owned();
    }
    let factors: Vec<String> = unit.split(' ').map(raised).collect();
    factors.join(" ")
}

/// A factor such as `cm-2` with its power raised; anything else as it is.
fn raised(factor: &str) -> String {
    let name = factor.trim_end_matches(|c: char| c == '-' || c.is_ascii_digit());
    let power = &factor[name.len()..];
    let is_number = power.parse::<i32>().is_ok();
    if !is_number || !name.chars().all(|c| c.is_alphabetic() || c == '_') || name.is_empty() {
        return factor.to_owned();
    }
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raise = |c: char| match c.to_digit(10) {
        Some(digit) => DIGITS[digit as usize],
        None => '⁻',
    };
    name.chars().chain(power.chars().map(raise)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_units_are_raised() {
        assert_eq!(typeset("keV cm-2 s-1 sr-1"), "keV cm⁻² s⁻¹ sr⁻¹");
        assert_eq!(typeset("R_E"), "R_E");
        assert_eq!(typeset("m10"), "m¹⁰");
        assert_eq!(typeset("10**-3 cm-2"), "10**-3 cm⁻²");
        assert_eq!(typeset(""), "1");
    }

    #[test]
    fn titles_are_names_alone() {
        assert_eq!(title("examples/smile.toml"), "smile");
        assert_eq!(title("smile"), "smile");
    }
}
