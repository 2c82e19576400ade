//! The error allowed in each pixel, as weights of errors.
//!
//! The engine compares errors with one number, the tolerance times the largest pixel. A pixel in which
//! another error is allowed has a *weight*: that number over the error allowed there. Where all weights
//! are 1 there are no maps of them.

use crate::cube::Cube;
use crate::image::Image;
use crate::vol::VolOptions;
use crate::vol::dyadic::{Place, STEPS, spacing, unit};
use crate::vol::options::DARKEST;
use crate::vol::tuning::TUNING;
use std::sync::Arc;

/// The smallest error allowed in a pixel, relative to the largest one: that of rounding.
const ROUNDING: f64 = 1e-14;

/// The weight beside pixels that matter below which structure is not resolved: ten pixels from those of
/// weight 1.
const NEGLIGIBLE: f64 = 1e-6;

/// The weights of the errors of an image or a cube.
#[derive(Clone, Debug)]
pub(crate) struct ErrorWeights {
    /// The largest |pixel| of those that matter.
    pub(crate) largest: f64,
    /// The weights of each band; `None` if all are 1.
    pub(crate) maps: Option<Vec<Arc<Image>>>,
}

/// The weights of each band on the raster of one part of the view.
pub(crate) type WeightsOfPart = Vec<Arc<Image>>;

impl ErrorWeights {
    /// The weights for the present `bands`, images with their errors; the pixels with the numbers `outside`
    /// belong to no image.
    ///
    /// A pixel whose error is larger than its value is taken to be as bright as the error. As long as errors
    /// are large, the weights of dark pixels are therefore moderate; and no such pixel is within `rtol`.
    pub(crate) fn new(vol: &VolOptions, bands: &[[&Image; 2]], outside: &[usize]) -> Self {
        let given = vol.weights.as_deref().map(Image::pixels);
        let weight = |pixel: usize| given.map_or(1.0, |weights| weights[pixel]);
        let largest_of = |[band, _]: &[&Image; 2]| {
            let pixels = band.pixels().iter().enumerate().filter(|(i, _)| weight(*i) > 0.0);
            pixels.fold(0.0, |largest: f64, (_, pixel)| largest.max(pixel.abs()))
        };
        let of_bands: Vec<f64> = bands.iter().map(largest_of).collect();
        let largest = of_bands.iter().copied().fold(0.0, f64::max);
        if vol.is_uniform() {
            return Self { largest, maps: None };
        }
        let reference = vol.tolerance * largest;
        let loosest = TUNING.engine.loosest_tolerance * largest;
        let of_band = |([band, errors], of_band): (&[&Image; 2], &f64)| {
            let of_band = if vol.per_band { *of_band } else { largest };
            let pixels = band.pixels().iter().zip(errors.pixels());
            let weight_of = |(i, (pixel, error)): (usize, (&f64, &f64))| {
                let allowed = match vol.by_pixel {
                    Some(by_pixel) => by_pixel.allowed(pixel.abs().max(*error), of_band),
                    None => vol.tolerance * of_band.max(DARKEST * largest),
                };
                let allowed = allowed.min(loosest).max(ROUNDING * largest);
                weight(i) * if allowed > 0.0 { reference / allowed } else { 1.0 }
            };
            let mut weights: Vec<f64> = pixels.enumerate().map(weight_of).collect();
            outside.iter().for_each(|&pixel| weights[pixel] = 0.0);
            let mut map = Image::from_pixels(band.height(), band.width(), weights);
            if vol.weights.is_some() {
                spread(&mut map);
                outside.iter().for_each(|&pixel| map.pixels_mut()[pixel] = 0.0);
            }
            Arc::new(map)
        };
        let maps = bands.iter().zip(&of_bands).map(of_band).collect();
        Self { largest, maps: Some(maps) }
    }

    /// The largest error of a finished cube over the error allowed there, or in a pixel beside one that
    /// matters; 0 without any error.
    pub(crate) fn over_allowed(vol: &VolOptions, values: &Cube, errors: &Cube) -> f64 {
        let [_, height, width] = values.shape();
        let none = Image::zeros(height, width);
        let bands: Vec<[&Image; 2]> = values.bands().iter().map(|band| [band, &none]).collect();
        let weights = Self::new(vol, &bands, &[]);
        let most = weights.largest_error(errors.bands().iter());
        if most > 0.0 { most / (vol.tolerance * weights.largest) } else { 0.0 }
    }

    /// The errors of a band times their weights.
    pub(crate) fn weighted(&self, band: usize, error: &Image) -> Option<Image> {
        Some(product(error, &self.maps.as_ref()?[band]))
    }

    /// The largest weighted error of the bands.
    pub(crate) fn largest_error<'e>(&self, errors: impl Iterator<Item = &'e Image>) -> f64 {
        let of_band = |(band, error): (usize, &Image)| match &self.maps {
            None => error.largest(),
            Some(maps) => {
                let pixels = error.pixels().iter().zip(maps[band].pixels());
                // No weight and no error: 0, and not NaN.
                pixels.fold(0.0, |most: f64, (error, weight)| most.max((error * weight).abs()))
            }
        };
        errors.enumerate().map(of_band).fold(0.0, f64::max)
    }
}

/// Raises each weight to a share of the largest one beside it. A pixel is predicted from values around it,
/// so that structure beside a pixel that matters is resolved to a few pixels from it.
fn spread(map: &mut Image) {
    let [height, width] = [map.height(), map.width()];
    let pixels = map.pixels_mut();
    let mut raise = |pixel: usize| {
        let (row, column) = (pixel / width, pixel % width);
        let rows = row.saturating_sub(1)..(row + 2).min(height);
        let columns = column.saturating_sub(1)..(column + 2).min(width);
        let beside = rows.flat_map(|row| columns.clone().map(move |column| row * width + column));
        let largest = beside.fold(0.0, |most: f64, other| most.max(pixels[other]));
        let beside = TUNING.engine.weight_beside * largest;
        if beside >= NEGLIGIBLE {
            pixels[pixel] = pixels[pixel].max(beside);
        }
    };
    (0..height * width).for_each(&mut raise);
    (0..height * width).rev().for_each(raise);
}

/// The product of two images, pixel by pixel.
pub(crate) fn product(a: &Image, b: &Image) -> Image {
    let pixels = a.pixels().iter().zip(b.pixels()).map(|(a, b)| a * b);
    Image::from_pixels(a.height(), a.width(), pixels.collect())
}

/// The largest weights of errors in dyadic squares of a raster.
#[derive(Clone, Debug)]
pub(crate) struct WeightsOfSquares {
    /// For each level ℓ the largest weight in each of 2^ℓ × 2^ℓ squares, row by row.
    levels: Vec<Vec<f64>>,
}

impl WeightsOfSquares {
    pub(crate) fn new(weights: &Image) -> Self {
        let [height, width] = [weights.height(), weights.width()];
        let finest = height.max(width).next_power_of_two().trailing_zeros();
        let side = 1_usize << finest;
        // The squares that overlap each pixel along one axis.
        let squares = |pixel: usize, pixels: usize| {
            pixel * side / pixels..((pixel + 1) * side).div_ceil(pixels).min(side)
        };
        let mut of_finest = vec![0.0; side * side];
        for (row, weights) in weights.rows().enumerate() {
            for (column, weight) in weights.iter().enumerate() {
                for i in squares(row, height) {
                    for square in &mut of_finest[i * side..][squares(column, width)] {
                        *square = f64::max(*square, *weight);
                    }
                }
            }
        }
        let mut levels = vec![of_finest];
        while let Some(finer) = levels.last().filter(|finer| finer.len() > 1) {
            let side = finer.len().isqrt() / 2;
            let of_square = |k: usize| {
                let first = k / side * 4 * side + k % side * 2;
                let below = first + 2 * side;
                finer[first].max(finer[first + 1]).max(finer[below]).max(finer[below + 1])
            };
            let coarser = (0..side * side).map(of_square).collect();
            levels.push(coarser);
        }
        levels.reverse();
        Self { levels }
    }

    /// The largest weight within one spacing of `level` of a place.
    pub(crate) fn around(&self, place: Place, level: u8) -> f64 {
        let level = usize::from(level).min(self.levels.len() - 1);
        let squares = &self.levels[level];
        let side = squares.len().isqrt();
        let step = STEPS >> level;
        let beside = |along: u32| {
            let [from, to] = [along.saturating_sub(step) / step, (along + step).div_ceil(step)];
            from as usize..(to as usize).min(side)
        };
        let (columns, rows) = (beside(place[0]), beside(place[1]));
        let of_row = |row: usize| squares[row * side..][columns.clone()].iter().copied();
        rows.flat_map(of_row).fold(0.0, f64::max)
    }
}

/// The largest error of the lines within one spacing of each node, on a raster: `nodes` are the places and
/// levels of nodes, each with the error of its line.
pub(crate) fn errors_of_lines(
    nodes: impl Iterator<Item = (Place, u8, f64)>,
    [rows, columns]: [usize; 2],
) -> Image {
    let mut errors = Image::zeros(rows, columns);
    for (place, level, error) in nodes {
        let half_width = unit(spacing(level));
        let cells = |along: u32, cells: usize| {
            let [from, to] = [-half_width, half_width]
                .map(|beside| ((unit(along) + beside) * cells as f64).clamp(0.0, cells as f64));
            crate::cell::whole(from.floor())..crate::cell::whole(to.ceil())
        };
        let of_row = cells(place[0], columns);
        for row in cells(place[1], rows) {
            for cell in &mut errors.row_mut(row)[of_row.clone()] {
                *cell = cell.max(error);
            }
        }
    }
    errors
}

#[cfg(test)]
mod tests;
