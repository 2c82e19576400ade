//! PNG files: bare pixels, or pictures with axes, a title and a colour bar.

use super::map::Map;
use super::outputs::Product;
use super::sheet;
use crate::arguments::RenderArguments;
use crate::failure::Failure;
use emitree::projection::ViewGeometry;
use emitree::projection::healpix::pixel_of_direction;
use emitree::{Healpix, Image};
use emitree_io::figure::{Axis, Heatmap, Panel, Sheet};
use emitree_io::units::Unit;
use emitree_io::{CameraKind, East, PictureOptions, Scene, ValueRange, encode_png, mollweide};
use std::borrow::Cow;
use std::path::Path;

/// How the PNG files of a rendering look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// A pixel of the image is one of the file.
    Bare,
    /// With axes, a title and a colour bar.
    Annotated {
        /// Equal ratios are equal steps of colour.
        logarithmic: bool,
    },
}

impl Style {
    pub(super) fn of(arguments: &RenderArguments) -> Self {
        let logarithmic = arguments.log;
        if arguments.annotate { Self::Annotated { logarithmic } } else { Self::Bare }
    }
}

/// The bytes of a bare picture, a sheet of all bands if it is of a cube; its colours in `range`, or
/// in the map's own.
pub(super) fn bare(
    map: &Map,
    unit: &str,
    scene: &Scene,
    range: Option<ValueRange>,
) -> Result<Vec<u8>, Failure> {
    let geometry = scene.camera.projection().view_geometry();
    let has_edges = geometry.is_some_and(ViewGeometry::has_regions);
    let options = PictureOptions {
        range,
        title: Some(scene.name.clone()),
        unit: Some(unit.to_owned()).filter(|unit| !unit.is_empty()),
        // A disc and a sky have corners where there is nothing, and a sheet has gaps.
        blank_outside: has_edges || is_sky(scene) || map.is_cube(),
        ..Default::default()
    };
    let tiles = sheet::tiles(map, scene.energy.as_ref());
    let rows = if tiles.len() > 1 { SKY_ROWS_OF_TILE } else { [LEAST_SKY_ROWS, MOST_SKY_ROWS] };
    let images: Vec<Image> =
        tiles.into_iter().map(|tile| flat(tile.image, scene, rows).into_owned()).collect();
    Ok(encode_png(&sheet::joined(&images), &options)?)
}

/// Device pixels in a unit of a figure.
const SCALE: f64 = 2.0;

/// Colours of a logarithmic scale start at this fraction of the largest pixel, or at the smallest
/// pixel above 0 if that is more: errors are relative to the largest pixel, so that what is fainter
/// means little.
const FAINTEST: f64 = 1e-3;

/// The bytes of an annotated picture: the image with its axes, or a sheet of all bands.
pub(super) fn annotated(
    product: &Product<'_>,
    scene: &Scene,
    logarithmic: bool,
) -> Result<Vec<u8>, Failure> {
    let tiles = sheet::tiles(product.map, scene.energy.as_ref());
    let rows = if tiles.len() > 1 { SKY_ROWS_OF_TILE } else { [ANNOTATED_SKY_ROWS, MOST_SKY_ROWS] };
    let labels: Vec<String> = tiles.iter().map(|tile| tile.label.clone()).collect();
    let images: Vec<Cow<'_, Image>> =
        tiles.into_iter().map(|tile| flat(tile.image, scene, rows)).collect();
    let range = colour_range(&images, logarithmic);
    let bar = format!("{} [{}]", product.meaning, typeset(product.unit));
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

/// What the pixels of the scene's image are: its quantity, or the column density that the integral
/// of a density is.
pub(super) fn meaning(scene: &Scene) -> &'static str {
    let is_column = Unit::parse(scene.image_unit())
        .and_then(|unit| unit.factor_to(&Unit::parse("m-2")?))
        .is_ok();
    if is_column { "column density" } else { scene.quantity.name() }
}

/// The name of the scene, without folder and ending.
fn title(name: &str) -> String {
    Path::new(name).file_stem().unwrap_or(name.as_ref()).to_string_lossy().into_owned()
}

/// The panel with the axes of the camera, or the ellipse that bounds its image.
fn with_axes<'a>(panel: Panel<'a>, scene: &Scene) -> Panel<'a> {
    let length = |label: &str| match &scene.length_unit {
        Some(unit) => format!("{label} [{}]", typeset(unit)),
        None => label.to_owned(),
    };
    let centred = |[width, height]: [f64; 2], x: Axis, y: Axis| {
        let [x_end, y_end] = [0.5 * width, 0.5 * height];
        (x.range([-x_end, x_end]), y.range([-y_end, y_end]))
    };
    let (x, y) = match scene.camera.kind() {
        CameraKind::Orthographic { extent } => {
            let (x, y) = (length("to the right"), length("up"));
            centred(extent, Axis::linear(x), Axis::linear(y))
        }
        CameraKind::Perspective { fov_deg } => {
            centred(fov_deg, Axis::tangent("to the right [deg]"), Axis::tangent("up [deg]"))
        }
        CameraKind::Equirectangular { fov_deg } => {
            let (x, y) = ("longitude about the pointing [deg]", "latitude [deg]");
            centred(fov_deg, Axis::linear(x), Axis::linear(y))
        }
        CameraKind::Polar { fov_deg } => {
            let azimuth = Axis::linear("azimuth [deg]").range([0.0, 360.0]);
            let angle = Axis::linear("angle from the pointing [deg]").range([0.0, 0.5 * fov_deg]);
            return panel.axes(azimuth, angle).square_pixels();
        }
        CameraKind::Fisheye { .. } | CameraKind::Healpix => return panel.ellipse(),
        _ => {
            let [x, y] = ["x", "y"].map(|label| Axis::linear(length(label)).range([0.0, 1.0]));
            (x, y)
        }
    };
    panel.axes(x, y)
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

fn is_sky(scene: &Scene) -> bool {
    scene.camera.kind() == CameraKind::Healpix
}

/// The image as a picture shows it: the whole sky as an ellipse of so many rows at the least and at
/// the most.
fn flat<'a>(image: Cow<'a, Image>, scene: &Scene, rows: [usize; 2]) -> Cow<'a, Image> {
    if is_sky(scene) { Cow::Owned(picture_of_sky(&image, rows)) } else { image }
}

/// Rows of the picture of a sky, for each pixel along the edge of a face, at the least and the most.
const SKY_ROWS_PER_PIXEL: usize = 4;
const LEAST_SKY_ROWS: usize = 256;
const MOST_SKY_ROWS: usize = 2048;
/// As many as the panel of a figure has device pixels for.
const ANNOTATED_SKY_ROWS: usize = 320;
/// Of each of many bands, at the least and the most.
const SKY_ROWS_OF_TILE: [usize; 2] = [96, 256];

/// The whole sky as an ellipse.
fn picture_of_sky(image: &Image, [least_rows, most_rows]: [usize; 2]) -> Image {
    let side = u32::try_from(image.width()).unwrap_or(u32::MAX);
    let rows = (SKY_ROWS_PER_PIXEL * image.width()).clamp(least_rows, most_rows);
    let map = Healpix::nested(image);
    let value = |direction| {
        let pixel = usize::try_from(pixel_of_direction(side, direction)).unwrap_or(usize::MAX);
        map.get(pixel).copied().unwrap_or(f64::NAN)
    };
    mollweide(rows, East::Left, value)
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

    #[test]
    fn integrals_of_densities_are_column_densities() {
        let meaning = |unit: &str| {
            let text = format!(
                "emission = {{ expression = \"1\", unit = \"{unit}\" }}\nimage = {{ width = 1, \
                 height = 1 }}\nprojection = {{ type = \"perspective\", position = [0, 0, 0], \
                 target = [1, 0, 0], field_of_view = [1, 1], far = 1, length_unit = \"km\" }}"
            );
            meaning(&Scene::parse("scene.toml", &text, &[]).unwrap())
        };
        assert_eq!(meaning("cm-3"), "column density");
        assert_eq!(meaning("W m-3 sr-1"), "radiance");
        assert_eq!(meaning("m-1"), "radiance");
    }
}
