//! The spectral cube: an image for each energy bin.

use crate::energy::EnergyAxis;
use crate::image::Image;

/// A cube of voxels, one image a bin.
///
/// # Axis order
///
/// A cube is an array of shape (bins, height, width): the lowest energies first, each band in the
/// [orientation of all images](crate::Image).
///
/// ```
/// use emitree::{Cube, EnergyAxis, EnergyScale, Image};
///
/// let bands = vec![Image::from_pixels(1, 2, vec![1.0, 2.0]), Image::from_pixels(1, 2, vec![3.0, 4.0])];
/// let cube = Cube::from_bands(bands);
/// assert_eq!(cube.shape(), [2, 1, 2]);
/// // The sum over energy: each bin is 5 wide here.
/// let axis = EnergyAxis::new(0.0, 10.0, 2, EnergyScale::Linear)?;
/// assert_eq!(cube.sum_over_energy(&axis).pixels(), [20.0, 30.0]);
/// # Ok::<(), emitree::energy::EnergyError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Cube {
    bands: Vec<Image>,
}

impl Cube {
    /// A cube from its bands, the lowest energies first.
    ///
    /// # Panics
    ///
    /// If their shapes differ.
    pub fn from_bands(bands: Vec<Image>) -> Self {
        let shape = |band: &Image| (band.height(), band.width());
        assert!(
            bands.windows(2).all(|pair| shape(&pair[0]) == shape(&pair[1])),
            "bands of one shape"
        );
        Self { bands }
    }

    /// Bins, height and width.
    pub fn shape(&self) -> [usize; 3] {
        let [height, width] = self.bands.first().map_or([0, 0], |b| [b.height(), b.width()]);
        [self.bands.len(), height, width]
    }

    /// The bands, the lowest energies first.
    pub fn bands(&self) -> &[Image] {
        &self.bands
    }

    /// Cubes of equal width and bins one above the other, the lowest first.
    pub(crate) fn stacked(cubes: &[&Self]) -> Self {
        let bins = cubes.first().map_or(0, |cube| cube.bands.len());
        let band = |bin: usize| Image::stacked(cubes.iter().map(|cube| &cube.bands[bin]));
        Self::from_bands((0..bins).map(band).collect())
    }

    /// Whether all voxels are the same, bit by bit.
    pub(crate) fn has_bits_of(&self, other: &Self) -> bool {
        self.shape() == other.shape()
            && self.voxels().zip(other.voxels()).all(|(a, b)| a.to_bits() == b.to_bits())
    }

    /// The band of the lowest energies.
    pub(crate) fn into_first(self) -> Image {
        self.bands.into_iter().next().unwrap_or_else(|| Image::zeros(0, 0))
    }

    /// The bands, to be changed.
    pub fn bands_mut(&mut self) -> &mut [Image] {
        &mut self.bands
    }

    /// All voxels, band after band.
    pub fn voxels(&self) -> impl Iterator<Item = f64> + '_ {
        self.bands.iter().flat_map(|band| band.pixels().iter().copied())
    }

    /// The largest |voxel|, voxels that are not numbers left out.
    pub fn largest(&self) -> f64 {
        self.bands.iter().map(Image::largest).fold(0.0, f64::max)
    }

    /// The smallest and the largest voxel, voxels that are not numbers left out; (∞, −∞) if there
    /// are none.
    pub fn min_max(&self) -> (f64, f64) {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        self.bands
            .iter()
            .map(Image::min_max)
            .fold(start, |(low, high), (min, max)| (low.min(min), high.max(max)))
    }

    /// The largest |difference| to another cube of the same shape.
    ///
    /// # Panics
    ///
    /// If the shapes differ.
    pub fn max_difference(&self, other: &Self) -> f64 {
        assert_eq!(self.shape(), other.shape(), "same shape");
        let pairs = self.bands.iter().zip(&other.bands);
        pairs.map(|(a, b)| a.max_difference(b)).fold(0.0, f64::max)
    }

    /// The image of the whole band: ∫ dE, each voxel times the width of its bin. Of a cube of errors
    /// it is a bound for the error of that image.
    ///
    /// # Panics
    ///
    /// If the axis has another number of bins.
    pub fn sum_over_energy(&self, axis: &EnergyAxis) -> Image {
        assert_eq!(self.bands.len(), axis.bins(), "one band for each bin");
        let [_, height, width] = self.shape();
        let mut sum = Image::zeros(height, width);
        for (bin, band) in self.bands.iter().enumerate() {
            let width = axis.width(bin);
            for (sum, voxel) in sum.pixels_mut().iter_mut().zip(band.pixels()) {
                *sum += width * voxel;
            }
        }
        sum
    }
}
