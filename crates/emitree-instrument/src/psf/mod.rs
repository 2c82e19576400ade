//! The point-spread function: where the photons of a pixel are detected.
//!
//! It is the same everywhere in the field, in pixels, and for all energies: a Gaussian or an image of a
//! point source, always of sum 1. A blurred band is the convolution of the band with it. Nothing wraps
//! around: photons that are blurred beyond the borders of the image, or into pixels outside of the
//! field (NaN), are lost, and their sum is returned, so that inside and lost together are what there
//! was before. Such pixels have no photons before, and are NaN after.

mod convolution;
mod kernel;

pub use kernel::{KernelFileDefect, KernelFileError};

use convolution::Convolver;
use emitree::{Cube, Image};
use kernel::Profile;
use rayon::prelude::*;

/// A point-spread function that can't be, or can't be applied.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PsfError {
    /// A width that can't be.
    #[error(
        "the full width at half maximum along {axis} is {value} pixels: expected 0 to {}",
        kernel::WIDEST
    )]
    Width {
        /// The axis: `x` along rows or `y` along columns.
        axis: char,
        /// The width.
        value: f64,
    },
    /// A pixel that spans nothing.
    #[error("a pixel is {value} rad along {axis}: expected a finite number above 0")]
    PixelSize {
        /// The axis: `x` along rows or `y` along columns.
        axis: char,
        /// The size of a pixel.
        value: f64,
    },
    /// A pixel of a kernel that can't be.
    #[error(
        "the kernel is {value} at row {row}, column {column}: expected a finite number, 0 or more"
    )]
    Kernel {
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
        /// The value there.
        value: f64,
    },
    /// A kernel whose pixels have no sum to be divided by.
    #[error(
        "the {height} x {width} pixels (height x width) of the kernel have the sum {sum}: expected a \
         finite number above 0"
    )]
    KernelSum {
        /// The rows.
        height: usize,
        /// The columns.
        width: usize,
        /// The sum of the pixels.
        sum: f64,
    },
    /// A pixel that is infinite.
    #[error(
        "the photons in bin {bin} at row {row}, column {column} are {value}: expected a finite \
         number, or NaN outside of the field"
    )]
    Photons {
        /// The band of the cube, from 0.
        bin: usize,
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
        /// The value there.
        value: f64,
    },
    /// The Fourier transform refused its input.
    #[error("the Fourier transform failed: {0}")]
    Transform(String),
}

/// A point-spread function.
///
/// ```
/// use emitree::{Cube, Image};
/// use emitree_instrument::Psf;
///
/// let mut point = Image::zeros(9, 9);
/// point[(4, 4)] = 100.0;
/// let blurred = Psf::gaussian([2.0, 2.0])?.blur(Cube::from_bands(vec![point]))?;
/// let inside: f64 = blurred.photons.voxels().sum();
/// assert!((inside + blurred.lost[0] - 100.0).abs() < 1e-10);
/// # Ok::<(), emitree_instrument::PsfError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Psf {
    profile: Profile,
}

/// A blurred cube, and what the field has lost.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Blurred {
    /// The photons of each bin and pixel.
    pub photons: Cube,
    /// For each bin the photons that were blurred out of the field.
    pub lost: Vec<f64>,
}

impl Psf {
    /// A Gaussian of full widths at half maximum along \[x, y\], in pixels, each 0 or more. Its pixels
    /// are means over pixels, of a source in the middle of one, out to six standard deviations, beyond
    /// which is 4·10⁻⁹ of it; then they are divided by their sum. All photons of a pixel count as from
    /// its middle, so that a scene that varies slowly is blurred a little more than by the Gaussian, by
    /// 1/12 pixel² of variance along each axis.
    ///
    /// # Errors
    ///
    /// [`PsfError::Width`].
    pub fn gaussian(fwhm_pixels: [f64; 2]) -> Result<Self, PsfError> {
        Ok(Self { profile: Profile::gaussian(fwhm_pixels)? })
    }

    /// A round [Gaussian](Self::gaussian) of full width at half maximum `fwhm_rad` for pixels that are
    /// `pixel_rad` along \[x, y\].
    ///
    /// # Errors
    ///
    /// [`PsfError::Width`], [`PsfError::PixelSize`].
    pub fn gaussian_angular(fwhm_rad: f64, pixel_rad: [f64; 2]) -> Result<Self, PsfError> {
        for (axis, value) in ['x', 'y'].into_iter().zip(pixel_rad) {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PsfError::PixelSize { axis, value });
            }
        }
        Self::gaussian(pixel_rad.map(|size| fwhm_rad / size))
    }

    /// The image of a point source, in pixels of the camera and in the orientation of all images. The
    /// source is in the middle of the pixel at row `height / 2`, column `width / 2`, from 0 and rounded
    /// down. The kernel is divided by its sum, which [`kernel_sum`](Self::kernel_sum) returns.
    ///
    /// # Errors
    ///
    /// [`PsfError::Kernel`], [`PsfError::KernelSum`].
    pub fn from_kernel(kernel: &Image) -> Result<Self, PsfError> {
        Ok(Self { profile: Profile::kernel(kernel)? })
    }

    /// The sum of the kernel as it was given; 1 for a Gaussian.
    pub fn kernel_sum(&self) -> f64 {
        self.profile.given_sum()
    }

    /// Blurs each band. Where a band has no negative pixels, none are made: those that rounding makes
    /// are set to 0.
    ///
    /// # Errors
    ///
    /// [`PsfError::Photons`] if a pixel is infinite.
    pub fn blur(&self, photons: Cube) -> Result<Blurred, PsfError> {
        let [_, height, width] = photons.shape();
        let mut blurred = Blurred { photons, lost: Vec::new() };
        if height * width == 0 {
            blurred.lost = vec![0.0; blurred.photons.bands().len()];
            return Ok(blurred);
        }
        check_finite(&blurred.photons)?;
        let convolver = Convolver::new(&self.profile.within([height, width]), [height, width])?;
        let bands = blurred.photons.bands_mut().par_iter_mut();
        blurred.lost = bands.map(|band| convolver.blur(band)).collect::<Result<_, _>>()?;
        Ok(blurred)
    }
}

fn check_finite(photons: &Cube) -> Result<(), PsfError> {
    for (bin, band) in photons.bands().iter().enumerate() {
        if let Some(at) = band.pixels().iter().position(|pixel| pixel.is_infinite()) {
            let (row, column) = (at / band.width(), at % band.width());
            return Err(PsfError::Photons { bin, row, column, value: band.pixels()[at] });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
