//! Images and cubes larger than the memory: products of a view, from which the rows of each band follow one by one.
//!
//! A low-rank approximation of g is a function of the whole view, and its residuals at scattered points are its
//! error at any place. Neither depends on the number of pixels. The search for it takes an image of few pixels;
//! then the means over pixels of any size, and their errors, follow row by row, without an array of the size of
//! the image. The bands of a cube are weighted sums of such approximations at a few energies. Errors of small pixels
//! may be larger than those of large ones: all rows of all bands are compared with the tolerance before any of them
//! is returned.

mod cube;
mod image;

pub use cube::LargeCube;
pub use image::LargeImage;

use crate::cube::Cube;
use crate::emission::Emission;
use crate::energy::EnergyAxis;
use crate::erased::{AnyEmission, AnyError, Erased, typed};
use crate::error::RenderError;
use crate::memory::{check_size, largest_that_fits};
use crate::meter::RowsWanted;
use crate::options::{Method, RenderOptions};
use crate::projection::Projection;
use crate::radiance::PixelRows;
use crate::session::{Kept, Session};
use crate::vol::VolOptions;
use std::sync::Arc;

/// The most voxels of the search are those of a square image with so many pixels along a side. Its error is
/// interpolated between eight cells along each side, and an image of so many pixels shows it to a percent.
const SEARCH_PIXELS: usize = 512;
/// The fewest pixels along a side of the search for a cube of many bins: eight along a side of each cell.
const LEAST_SEARCH_PIXELS: usize = 64;
/// The tolerance of a second search over that of the first, if small pixels have larger errors.
const SECOND_TOLERANCE: f64 = 0.9;

/// The image of an emission from a camera, of `shape` = \[height, width\] pixels, whose rows are made one by one
/// from a low-rank approximation. Memory grows with the height and the width, and not with their product.
///
/// The guarantee is that of [`render`](crate::render()): each |error| is within the tolerance times the largest |pixel|. The
/// values of a view that is one image plane are those of `render`, bit by bit, up to 512 × 512 pixels; beyond, the search for
/// the approximation takes fewer pixels, and may end a step earlier. Beside limbs the quadrature of pixels is made for
/// some rows at a time, and both are within their errors of each other.
///
/// ```
/// use emitree::large::render_large;
/// use emitree::{Canonical, FromFn, RenderOptions, VolOptions};
///
/// let peak = |[x, y, z]: [f64; 3], _| (-30.0 * (x * x + y * y + z * z)).exp();
/// let options = RenderOptions::new(VolOptions::new(1e-3));
/// let image = render_large(&FromFn(peak), &Canonical, [2000, 3000], &options)?;
/// let rows = image.values(0..10);
/// assert_eq!((rows.height(), rows.width()), (10, 3000));
/// assert!(image.estimated_error() < 1e-3);
/// # Ok::<(), emitree::RenderError<std::convert::Infallible>>(())
/// ```
///
/// # Errors
///
/// [`RenderError::NotByRows`] if the view has the rim of a disc, but no charts (of bodies, bounds or edges), if a
/// singularity of g is declared, if the image is a sky of several tiles, if g has no
/// low-rank approximation to the tolerance, if the medium absorbs, with another method than
/// [`Method::Vol`], with errors by pixel, weights or sums. Others as [`render`](crate::render()).
pub fn render_large<'a, E: Emission>(
    emission: &E,
    projection: &'a dyn Projection,
    shape: [usize; 2],
    options: &RenderOptions<'_>,
) -> Result<LargeImage<'a>, RenderError<E::Error>> {
    render_large_cube(emission, projection, shape, None, options).map(LargeCube::into_first_band)
}

/// The spectral cube of an emission, likewise, in the bins of an energy axis; without one the cube has one band, the image.
///
/// The guarantee is that of [`render_cube`](crate::render_cube): each |error| is within the tolerance times the largest
/// |voxel|.
///
/// ```
/// use emitree::large::render_large_cube;
/// use emitree::{Canonical, EnergyAxis, EnergyScale, FromSpectralFn, RenderOptions, VolOptions};
///
/// let glow = FromSpectralFn(|[x, y, z]: [f64; 3], _, energy: f64| {
///     (-4.0 * (x * x + y * y + z * z)).exp() * (-energy).exp()
/// });
/// let axis = EnergyAxis::new(0.1, 2.0, 8, EnergyScale::Log)?;
/// let options = RenderOptions::new(VolOptions::new(1e-3));
/// let cube = render_large_cube(&glow, &Canonical, [2000, 3000], Some(&axis), &options)?;
/// assert_eq!(cube.shape(), [8, 2000, 3000]);
/// let rows = cube.bands()[7].values(0..10);
/// assert_eq!((rows.height(), rows.width()), (10, 3000));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// As [`render_large`], and [`RenderError::NotByRows`] if a body, bounds or an ellipsoidal edge divides the view.
pub fn render_large_cube<'a, E: Emission>(
    emission: &E,
    projection: &'a dyn Projection,
    shape: [usize; 2],
    axis: Option<&EnergyAxis>,
    options: &RenderOptions<'_>,
) -> Result<LargeCube<'a>, RenderError<E::Error>> {
    of_any(&Erased(emission), projection, shape, axis, options).map_err(typed)
}

/// The cube of an emission of any type.
fn of_any<'a>(
    emission: &AnyEmission<'_>,
    projection: &'a dyn Projection,
    shape: [usize; 2],
    axis: Option<&EnergyAxis>,
    options: &RenderOptions<'_>,
) -> Result<LargeCube<'a>, RenderError<AnyError>> {
    let bins = axis.map(EnergyAxis::bins);
    let wanted = RowsWanted { shape, fits: largest_that_fits(shape, bins, options) };
    let [height, width] = shape;
    if height == 0 || width == 0 {
        return Err(RenderError::EmptyImage { height, width });
    }
    if !projection.tiles().is_empty() {
        return Err(wanted.refused("its pixels are those of a sky of several tiles"));
    }
    let vol = check(emission.absorbs(), options, wanted)?;
    let rates = Arc::default();
    let mut tolerance = vol.tolerance;
    loop {
        let method = Method::Vol(VolOptions { tolerance, ..vol.clone() });
        let search = RenderOptions { method, frame: None, mesh_up_to: 0, ..options.clone() };
        let kept = Kept {
            rates: Some(Arc::clone(&rates)),
            images: false,
            repeats: false,
            rows: Some(wanted),
        };
        let of_search = shape.map(|pixels| pixels.min(search_pixels(bins.unwrap_or(1))));
        let whole = emission.takes_whole_batches();
        let mut session: Session<'_, Cube> =
            Session::start(projection, of_search, axis.copied(), &search, kept, whole)?;
        while !session.is_done() {
            session.evaluate(emission, options.progress)?;
        }
        let products = session.products();
        let stats = session.into_rendering()?.stats;
        let pixels = PixelRows { projection, shape };
        let bands = products.and_then(|products| products.bands(pixels));
        let bands = bands.ok_or_else(|| wanted.refused("it has no products"))?;
        let progress = options.progress;
        let mut cube = LargeCube::measured(pixels, bands, stats, progress)?;
        let is_within = cube.estimated_error() <= vol.tolerance;
        if is_within || tolerance < vol.tolerance {
            if !is_within {
                cube.set_not_converged();
            }
            return Ok(cube);
        }
        tolerance *= SECOND_TOLERANCE;
    }
}

/// The most pixels along a side of the bands of a search with so many of them.
fn search_pixels(bins: usize) -> usize {
    let of_bins = (SEARCH_PIXELS as f64 / (bins as f64).sqrt()).floor();
    crate::cell::whole(of_bins).max(LEAST_SEARCH_PIXELS)
}

/// Whether [`render`](crate::render()) could make an image of `shape` = \[height, width\] in the memory allowed, or
/// [`render_cube`](crate::render_cube) a cube with so many bins.
pub fn fits_in_memory(shape: [usize; 2], bins: Option<usize>, options: &RenderOptions<'_>) -> bool {
    check_size::<core::convert::Infallible>(shape, bins, options).is_ok()
}

/// The options of `vol`, if an image can be made row by row with them.
fn check<'o, E>(
    absorbs: bool,
    options: &'o RenderOptions<'_>,
    wanted: RowsWanted,
) -> Result<&'o VolOptions, RenderError<E>> {
    let vol = match &options.method {
        Method::Vol(vol) => vol,
        other => {
            return Err(wanted.refused(format!("the method `{}` has no products", other.name())));
        }
    };
    let reasons = [
        (absorbs, "its medium absorbs"),
        (!vol.is_uniform(), "the error allowed is not the same in all pixels"),
        (!vol.sums.is_empty(), "sums over regions are asked for"),
        (options.start.is_some(), "it begins with a mesh"),
    ];
    match reasons.into_iter().find(|(is_so, _)| *is_so) {
        Some((_, reason)) => Err(wanted.refused(reason)),
        None => Ok(vol),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_search_for_a_cube_has_as_many_voxels_as_that_for_an_image() {
        assert_eq!([1, 4, 16, 100, 10_000].map(search_pixels), [512, 256, 128, 64, 64]);
    }
}
