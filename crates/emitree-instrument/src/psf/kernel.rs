//! Kernels: the pixels of a point-spread function.

use super::{Psf, PsfError};
use core::f64::consts::{LN_2, SQRT_2};
use emitree::Image;
use fits_well::io::HduKind;
use fits_well::{FitsError, FitsReader};
use std::path::{Path, PathBuf};

/// The widest Gaussian, in pixels: more than any image has.
pub(super) const WIDEST: f64 = 1e5;
/// How many standard deviations of a Gaussian are kept.
const REACH: f64 = 6.0;

/// A point-spread function on as many pixels as it needs.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Profile {
    /// The pixel means along x and along y, of sum 1, the middle one at the source.
    Gaussian([Vec<f64>; 2]),
    /// An image of sum 1, and its sum before.
    Kernel(Image, f64),
}

/// The part of a kernel that moves photons within a field.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Kernel {
    pub(super) image: Image,
    /// The row and column of the source.
    pub(super) origin: [usize; 2],
    /// The part of the whole kernel that reaches too far for any pixel.
    pub(super) beyond: f64,
}

/// The rows or columns of a kernel that are kept, and where the source is among them.
struct Kept {
    first: usize,
    count: usize,
    origin: usize,
}

impl Kept {
    /// Of `length` with the source at `origin`, those that stay in a field of `field` pixels from
    /// some pixel of it.
    fn new(length: usize, origin: usize, field: usize) -> Self {
        let reach = field - 1;
        let first = origin.saturating_sub(reach);
        let end = length.min(origin + reach + 1);
        Self { first, count: end - first, origin: origin - first }
    }
}

impl Profile {
    pub(super) fn gaussian(fwhm_pixels: [f64; 2]) -> Result<Self, PsfError> {
        for (axis, value) in ['x', 'y'].into_iter().zip(fwhm_pixels) {
            if !(0.0..=WIDEST).contains(&value) {
                return Err(PsfError::Width { axis, value });
            }
        }
        Ok(Self::Gaussian(fwhm_pixels.map(pixel_means)))
    }

    pub(super) fn kernel(kernel: &Image) -> Result<Self, PsfError> {
        let (height, width) = (kernel.height(), kernel.width());
        let counts = |value: &f64| *value >= 0.0 && value.is_finite();
        if let Some(at) = kernel.pixels().iter().position(|value| !counts(value)) {
            let (row, column, value) = (at / width, at % width, kernel.pixels()[at]);
            return Err(PsfError::Kernel { row, column, value });
        }
        let sum: f64 = kernel.pixels().iter().sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return Err(PsfError::KernelSum { height, width, sum });
        }
        let pixels = kernel.pixels().iter().map(|value| value / sum).collect();
        Ok(Self::Kernel(Image::from_pixels(height, width, pixels), sum))
    }

    pub(super) fn given_sum(&self) -> f64 {
        match self {
            Self::Gaussian(_) => 1.0,
            Self::Kernel(_, sum) => *sum,
        }
    }

    /// The kernel for a field of `[height, width]` pixels, at least one each.
    pub(super) fn within(&self, [height, width]: [usize; 2]) -> Kernel {
        let (rows, columns) = match self {
            Self::Gaussian([x, y]) => (y.len(), x.len()),
            Self::Kernel(image, _) => (image.height(), image.width()),
        };
        let value = |row: usize, column: usize| match self {
            Self::Gaussian([x, y]) => y[row] * x[column],
            Self::Kernel(image, _) => image[(row, column)],
        };
        let kept_rows = Kept::new(rows, rows / 2, height);
        let kept_columns = Kept::new(columns, columns / 2, width);
        let mut image = Image::zeros(kept_rows.count, kept_columns.count);
        for row in 0..kept_rows.count {
            for column in 0..kept_columns.count {
                image[(row, column)] = value(kept_rows.first + row, kept_columns.first + column);
            }
        }
        let cut = kept_rows.count < rows || kept_columns.count < columns;
        let beyond = if cut { 1.0 - image.pixels().iter().sum::<f64>() } else { 0.0 };
        Kernel { image, origin: [kept_rows.origin, kept_columns.origin], beyond }
    }
}

/// The means over pixels of a Gaussian with its middle in the middle of a pixel, and of sum 1.
fn pixel_means(fwhm: f64) -> Vec<f64> {
    let deviation = fwhm / (8.0 * LN_2).sqrt();
    if deviation == 0.0 {
        return vec![1.0];
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 1 to six times the widest"
    )]
    let reach = (REACH * deviation).ceil() as usize;
    // Complements of the error function keep the digits of the wings.
    let above = |border: f64| 0.5 * libm::erfc(border / (SQRT_2 * deviation));
    let mean = |distance: usize| match distance {
        0 => 1.0 - 2.0 * above(0.5),
        _ => above(distance as f64 - 0.5) - above(distance as f64 + 0.5),
    };
    let mut means: Vec<f64> = (0..=2 * reach).map(|at| mean(at.abs_diff(reach))).collect();
    let sum: f64 = means.iter().sum();
    means.iter_mut().for_each(|mean| *mean /= sum);
    means
}

/// A file that no kernel could be read from.
#[derive(Debug, thiserror::Error)]
#[error("the point-spread function {}: {cause}", path.display())]
#[non_exhaustive]
pub struct KernelFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub cause: KernelFileDefect,
}

/// What is wrong with the file of a kernel.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum KernelFileDefect {
    /// The file can't be read.
    #[error("it can't be read: {0}")]
    Unreadable(#[source] std::io::Error),
    /// The bytes are no FITS.
    #[error("it can't be read as FITS: {0}")]
    Fits(#[source] Box<FitsError>),
    /// There is no image in it.
    #[error("it has no image: expected one of two axes")]
    NoImage,
    /// Its image can't be read as it is stored.
    #[error(
        "its image is compressed by tiles (ZIMAGE = T): expected one that is not, as `funpack` makes it"
    )]
    Compressed,
    /// The image is no kernel.
    #[error("its first image has the axes {shape:?} (NAXIS1 first): expected two")]
    Axes {
        /// The length of each axis.
        shape: Vec<usize>,
    },
    /// The pixels make no kernel.
    #[error(transparent)]
    Psf(#[from] PsfError),
}

impl Psf {
    /// Reads a [kernel](Self::from_kernel) from the first image of the FITS file at `path`.
    ///
    /// # Errors
    ///
    /// [`KernelFileError`] names the file and what is wrong with it.
    pub fn read_kernel(path: impl AsRef<Path>) -> Result<Self, KernelFileError> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(KernelFileDefect::Unreadable);
        let psf = bytes.and_then(|bytes| Ok(Self::from_kernel(&first_image(&bytes)?)?));
        psf.map_err(|cause| KernelFileError { path: path.to_owned(), cause })
    }
}

fn first_image(bytes: &[u8]) -> Result<Image, KernelFileDefect> {
    let fits = |source| KernelFileDefect::Fits(Box::new(source));
    let mut reader = FitsReader::from_bytes(bytes).map_err(fits)?;
    let Some(index) = reader.images().next().map(|hdu| hdu.index) else {
        let is_compressed = reader.hdus().iter().any(|hdu| hdu.kind == HduKind::CompressedImage);
        return Err(if is_compressed {
            KernelFileDefect::Compressed
        } else {
            KernelFileDefect::NoImage
        });
    };
    let mut image = reader.image(index).map_err(fits)?;
    let shape = image.metadata().shape.to_vec();
    let &[width, height] = &*shape else { return Err(KernelFileDefect::Axes { shape }) };
    let mut pixels = Vec::new();
    image.physical_into(.., &mut pixels).map_err(fits)?;
    Ok(Image::from_pixels(height, width, pixels))
}
