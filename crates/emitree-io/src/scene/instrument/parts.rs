//! The parts of an instrument: numbers, or files of missions.

use super::super::beside_scene;
use super::super::camera::cameras;
use super::super::document::{Node, Value};
use super::super::error::SceneError;
use super::super::source::Place;
use super::super::table::Table;
use super::{Observer, pixel_rad, positive};
use crate::words::all_of;
use emitree_instrument::{Background, EffectiveArea, Psf, Redistribution};
use std::path::Path;

pub(super) const AREA: &str = "an area in cm2, or the name of a file: an ARF (.arf, .fits) or a \
                               table of energies and areas";

/// The endings of files that are FITS; all others are text.
const FITS_ENDINGS: [&str; 3] = ["arf", "fits", "fit"];

/// A number, which is the same at all energies from the first to the second of `ends` \[keV\], or a
/// file.
pub(super) fn area(node: &Node, ends: [f64; 2]) -> Result<EffectiveArea, SceneError> {
    let found = match &node.value {
        Value::Integer(_) | Value::Real(_) => {
            let area_cm2 = positive(node, AREA)?;
            EffectiveArea::from_bins(&[ends[0]], &[ends[1]], &[area_cm2])
                .map_err(|error| error.to_string())
        }
        Value::Text(file) => read_area(&beside_scene(file, &node.place)),
        other => return Err(node.refuse(other.kind(), AREA)),
    };
    found.map_err(|error| at(&node.place, "effective_area", &error))
}

fn read_area(path: &Path) -> Result<EffectiveArea, String> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if FITS_ENDINGS.contains(&&*ending) {
        EffectiveArea::read_arf(path).map_err(|error| error.to_string())
    } else {
        EffectiveArea::read_table(path).map_err(|error| error.to_string())
    }
}

pub(super) fn redistribution(
    (file, place): &(String, Place),
) -> Result<Redistribution, SceneError> {
    Redistribution::read_rmf(beside_scene(file, place)).map_err(|error| {
        at(place, "redistribution", &error.to_string())
            .label("expected a redistribution matrix as missions write it: an RMF or an RSP")
    })
}

/// The cameras whose pixels are on no plane, in the order of the alphabet.
fn planeless() -> String {
    let cameras = cameras().iter().filter(|camera| !camera.has_plane);
    let mut names: Vec<&str> = cameras.map(|camera| camera.name).collect();
    names.sort_unstable();
    all_of(names.iter().map(|name| format!("`{name}`")))
}

/// `{ fwhm_pixels = … }`, `{ fwhm_arcsec = … }` or `{ kernel = "…" }`.
pub(super) fn psf(node: Node, observer: Observer<'_>) -> Result<Psf, SceneError> {
    const FWHM: &str = "a full width at half maximum in pixels, or two [x, y]";
    const FWHM_ARCSEC: &str = "a full width at half maximum in arcsec, 0 or more";
    let Some(pixel_rad) = pixel_rad(observer) else {
        return Err(SceneError::at(&node.place, "`instrument.psf` has no meaning for this camera")
            .label(format!("expected none: the pixels of {} are on no plane", planeless())));
    };
    let (key, value) = only(node, "instrument.psf", ["fwhm_pixels", "fwhm_arcsec", "kernel"])?;
    let found = match key {
        "fwhm_pixels" => {
            let widths = match value.value {
                Value::Array(_) => value.vector(FWHM)?,
                _ => [value.number()?; 2],
            };
            Psf::gaussian(widths).map_err(|error| error.to_string())
        }
        "fwhm_arcsec" => match value.number()? {
            width if width >= 0.0 => {
                Psf::gaussian_angular((width / ARCSEC_PER_DEG).to_radians(), pixel_rad)
                    .map_err(|error| error.to_string())
            }
            negative => return Err(value.refuse(&negative.to_string(), FWHM_ARCSEC)),
        },
        _ => {
            let (file, place) = value.text()?;
            Psf::read_kernel(beside_scene(&file, &place)).map_err(|error| error.to_string())
        }
    };
    found.map_err(|error| at(&value.place, &format!("psf.{key}"), &error))
}

const ARCSEC_PER_DEG: f64 = 3600.0;

/// `{ per_pixel = … }` or `{ per_kev_sr = … }`.
pub(super) fn background(node: Node) -> Result<Background, SceneError> {
    let (key, value) = only(node, "instrument.background", ["per_pixel", "per_kev_sr"])?;
    let rate = value.number()?;
    let found = match key {
        "per_pixel" => Background::per_pixel(rate),
        _ => Background::per_kev_sr(rate),
    };
    found.map_err(|error| at(&value.place, &format!("background.{key}"), &error.to_string()))
}

/// The only entry of a table that has one of several.
fn only<const N: usize>(
    node: Node,
    path: &str,
    keys: [&'static str; N],
) -> Result<(&'static str, Node), SceneError> {
    let mut table = Table::new(node)?;
    let place = table.place().clone();
    let found: Vec<_> = keys.iter().filter_map(|key| Some((*key, table.take(key)?))).collect();
    table.finish()?;
    let expected = format!("expected one of `{}`", keys.join("`, `"));
    let mut found = found.into_iter();
    match (found.next(), found.next()) {
        (Some(one), None) => Ok(one),
        (None, _) => Err(SceneError::at(&place, format!("`{path}` is empty")).label(expected)),
        (Some((first, _)), Some((second, node))) => {
            let message = format!("`{path}` has both `{first}` and `{second}`");
            Err(SceneError::at(&node.place, message).label(expected))
        }
    }
}

fn at(place: &Place, key: &str, error: &str) -> SceneError {
    SceneError::at(place, format!("`instrument.{key}`: {error}"))
}
