//! How two images, two cubes or two skies differ: by how much, where, and beside their error maps.

mod components;
mod healpix;
#[cfg(feature = "figure")]
mod picture;
mod stored;

pub use stored::StoredImage;

use crate::grid::GridReadError;
use crate::units::Unit;
use std::path::PathBuf;

/// Two images that can't be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ComparisonError {
    /// The ending of the name is that of no format with numbers.
    #[error("{}: expected an image with numbers, .fits, .fit or .npy", path.display())]
    Ending {
        /// The file.
        path: PathBuf,
    },
    /// A file can't be read.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        #[source]
        cause: GridReadError,
    },
    /// An array is no image and no cube.
    #[error("{}: an array of shape {shape:?}: expected 1 to 3 axes with numbers", path.display())]
    Axes {
        /// The file.
        path: PathBuf,
        /// The length of each axis.
        shape: Vec<usize>,
    },
    /// The shapes differ.
    #[error(
        "{first} has {} and {second} {}: expected as many in both",
        size_text(*first_shape), size_text(*second_shape)
    )]
    Shapes {
        /// The name of the first image.
        first: String,
        /// Its bands, rows and columns.
        first_shape: [usize; 3],
        /// The name of the second image.
        second: String,
        /// Its bands, rows and columns.
        second_shape: [usize; 3],
    },
    /// One unit is not a multiple of the other.
    #[error(
        "{first} is in `{first_unit}` and {second} in `{second_unit}`: expected units of one dimension"
    )]
    Units {
        /// The name of the first image.
        first: String,
        /// Its unit.
        first_unit: String,
        /// The name of the second image.
        second: String,
        /// Its unit.
        second_unit: String,
    },
}

/// The size of an image or a cube, for people: "64 x 32 pixels (width x height), 3 bands".
fn size_text([bands, height, width]: [usize; 3]) -> String {
    let of_bands = if bands == 1 { String::new() } else { format!(", {bands} bands") };
    format!("{width} x {height} pixels (width x height){of_bands}")
}

/// How a second image differs from a first one, in the unit of the first.
///
/// ```
/// use emitree_io::{Comparison, StoredImage};
///
/// let first = StoredImage::new("a", [1, 2, 2], vec![1.0, 2.0, 3.0, 4.0]).unwrap();
/// let second = StoredImage::new("b", [1, 2, 2], vec![1.0, 2.0, 3.5, 4.0]).unwrap();
/// let found = Comparison::of(&first, &second)?;
/// let largest = found.largest.unwrap();
/// assert_eq!((largest.place, largest.first, largest.second), ([0, 1, 0], 3.0, 3.5));
/// assert_eq!(found.relative(largest.amount()), 0.125); // of the largest pixel
/// assert_eq!((found.rms, found.mean), (0.25, 0.125));
/// # Ok::<(), emitree_io::ComparisonError>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Comparison {
    /// Bands, rows and columns; a sky has one row, of pixels in nested order.
    pub shape: [usize; 3],
    /// Whether the pixels are those of `HEALPix`.
    pub is_sky: bool,
    /// The unit, in the grammar of FITS, or empty.
    pub unit: String,
    /// What the second image was multiplied with for that unit.
    pub factor: f64,
    /// The largest |pixel| of the first image; of the second one if the first is 0 everywhere.
    pub scale: f64,
    /// Where the images differ most; none if no pixel is a number in both.
    pub largest: Option<Difference>,
    /// The root of the mean squared difference.
    pub rms: f64,
    /// The mean difference, second minus first.
    pub mean: f64,
    /// How many pixels are finite numbers in both images.
    pub compared: usize,
    /// How many pixels are a finite number in one image only, or infinite with two signs.
    pub in_one_only: usize,
    /// The first of these.
    pub first_in_one_only: Option<[usize; 3]>,
    /// The differences beside the error maps, if there are some.
    pub beside_errors: Option<BesideErrors>,
    differences: Vec<f64>,
}

/// A pixel of two images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Band, row (0 is the lowest) and column.
    pub place: [usize; 3],
    /// The value in the first image.
    pub first: f64,
    /// The value in the second image, in the unit of the first.
    pub second: f64,
}

impl Difference {
    /// The |difference|.
    pub fn amount(self) -> f64 {
        (self.second - self.first).abs()
    }
}

/// Differences in terms of estimated errors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BesideErrors {
    /// How many of the images have an error map, 1 or 2.
    pub maps: usize,
    /// The largest |difference| over the sum of the errors there; infinite where the errors are 0.
    pub largest: f64,
    /// Where.
    pub place: [usize; 3],
    /// How many differences are above the sum of the errors.
    pub above: usize,
}

impl Comparison {
    /// Compares two images of one shape, pixel by pixel.
    ///
    /// # Errors
    ///
    /// [`ComparisonError`]: other shapes, or units of another dimension.
    #[expect(clippy::float_cmp, reason = "infinities of one sign are the same")]
    pub fn of(first: &StoredImage, second: &StoredImage) -> Result<Self, ComparisonError> {
        if first.shape != second.shape {
            return Err(ComparisonError::Shapes {
                first: first.name.clone(),
                first_shape: first.shape,
                second: second.name.clone(),
                second_shape: second.shape,
            });
        }
        let factor = factor(first, second)?;
        let shape = first.shape;
        let of_second = || second.values.iter().map(|value| value * factor);
        let pairs = || first.values.iter().copied().zip(of_second());
        let is_compared = |(a, b): &(f64, f64)| a.is_finite() && b.is_finite();
        let is_same = |(a, b): &(f64, f64)| a == b || (a.is_nan() && b.is_nan());
        let differs = |pair: &(f64, f64)| !is_compared(pair) && !is_same(pair);
        let compared: Vec<(usize, f64, f64)> = pairs()
            .enumerate()
            .filter(|(_, pair)| is_compared(pair))
            .map(|(at, (a, b))| (at, a, b))
            .collect();
        let larger = |most: Option<(usize, f64, f64)>, next: (usize, f64, f64)| match most {
            Some(most) if (most.2 - most.1).abs() >= (next.2 - next.1).abs() => Some(most),
            _ => Some(next),
        };
        let largest = compared.iter().copied().fold(None, larger);
        let largest = largest.map(|(at, first, second)| {
            let place = place(shape, at);
            Difference { place, first, second }
        });
        let count = compared.len().max(1) as f64;
        let scale = [first.largest(), factor.abs() * second.largest()];
        let differences = pairs().map(|(a, b)| if a == b { 0.0 } else { b - a }).collect();
        Ok(Self {
            shape,
            is_sky: first.is_sky || second.is_sky,
            unit: first.unit.clone().or_else(|| second.unit.clone()).unwrap_or_default(),
            factor,
            scale: scale.into_iter().find(|&scale| scale > 0.0).unwrap_or(0.0),
            largest,
            rms: (compared.iter().map(|(_, a, b)| (b - a).powi(2)).sum::<f64>() / count).sqrt(),
            mean: compared.iter().map(|(_, a, b)| b - a).sum::<f64>() / count,
            compared: compared.len(),
            in_one_only: pairs().filter(|pair| differs(pair)).count(),
            first_in_one_only: pairs().position(|pair| differs(&pair)).map(|at| place(shape, at)),
            beside_errors: beside_errors(first, second, factor, &compared),
            differences,
        })
    }

    /// Second minus first, in the order of the values; 0 where both are the same infinity, and NaN where one is no
    /// number.
    pub fn differences(&self) -> &[f64] {
        &self.differences
    }

    /// An amount relative to the largest |pixel| of the first image.
    pub fn relative(&self, amount: f64) -> f64 {
        if amount == 0.0 { 0.0 } else { amount / self.scale }
    }

    /// Whether all pixels that are numbers are so in both images, and differ by at most `tolerance` times the
    /// largest |pixel| of the first.
    pub fn is_within(&self, tolerance: f64) -> bool {
        let amount = self.largest.map_or(0.0, Difference::amount);
        self.in_one_only == 0 && self.relative(amount) <= tolerance
    }
}

/// What the second image is multiplied with to be in the unit of the first.
fn factor(first: &StoredImage, second: &StoredImage) -> Result<f64, ComparisonError> {
    let (Some(to), Some(from)) = (&first.unit, &second.unit) else { return Ok(1.0) };
    if to == from {
        return Ok(1.0);
    }
    let factor = Unit::parse(from).and_then(|from| from.factor_to(&Unit::parse(to)?));
    factor.map_err(|_| ComparisonError::Units {
        first: first.name.clone(),
        first_unit: to.clone(),
        second: second.name.clone(),
        second_unit: from.clone(),
    })
}

/// Band, row and column of a pixel.
fn place([_, height, width]: [usize; 3], at: usize) -> [usize; 3] {
    [at / (height * width), at / width % height, at % width]
}

fn beside_errors(
    first: &StoredImage,
    second: &StoredImage,
    factor: f64,
    compared: &[(usize, f64, f64)],
) -> Option<BesideErrors> {
    let maps = [(&first.error, 1.0), (&second.error, factor.abs())];
    let given: Vec<(&Vec<f64>, f64)> =
        maps.into_iter().filter_map(|(map, factor)| Some((map.as_ref()?, factor))).collect();
    if given.is_empty() {
        return None;
    }
    let share = |&(at, a, b): &(usize, f64, f64)| {
        let difference: f64 = (b - a).abs();
        let allowed: f64 = given.iter().map(|(map, factor)| map[at] * factor).sum();
        if difference == 0.0 { 0.0 } else { difference / allowed }
    };
    let mut found = BesideErrors { maps: given.len(), largest: 0.0, place: [0; 3], above: 0 };
    for pixel in compared {
        let share = share(pixel);
        found.above += usize::from(share > 1.0);
        if share > found.largest {
            (found.largest, found.place) = (share, place(first.shape, pixel.0));
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests;
