//! Sums of parts that are each a Gaussian in space times a spectrum: exact cubes.

use super::spectrum::Spectrum;
use crate::means;
use emitree::{Cube, EnergyAxis, Image};

/// A Gaussian along the axes of the unit cube, of one spectrum throughout:
/// g = `amplitude` · exp(−Σ ((rᵢ − `centre`ᵢ)/`widths`ᵢ)²) · `spectrum`(E).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// g at the centre where the spectrum is 1.
    pub amplitude: f64,
    /// The brightest point.
    pub centre: [f64; 3],
    /// How far from it along each axis g has fallen to 1/e.
    pub widths: [f64; 3],
    /// The spectrum.
    pub spectrum: Spectrum,
}

impl Part {
    fn rate(&self, position: [f64; 3], energy: f64) -> f64 {
        let square: f64 =
            (0..3).map(|i| ((position[i] - self.centre[i]) / self.widths[i]).powi(2)).sum();
        self.amplitude * (-square).exp() * self.spectrum.at(energy)
    }

    /// The means of the Gaussian along axis `i` over `count` equal parts of \[0, 1\].
    fn means(&self, i: usize, count: usize) -> Vec<f64> {
        let border = |part: usize| part as f64 / count as f64;
        let a = self.widths[i].powi(-2);
        let mean = |part| means::gaussian(a, self.centre[i], border(part), border(part + 1));
        (0..count).map(mean).collect()
    }

    fn image(&self, [height, width]: [usize; 2]) -> Image {
        let (columns, rows) = (self.means(0, width), self.means(1, height));
        let depth: f64 = self.means(2, 1).iter().sum();
        let pixels = rows.iter().flat_map(|row| {
            columns.iter().map(move |column| self.amplitude * depth * row * column)
        });
        Image::from_pixels(height, width, pixels.collect())
    }
}

/// The rate of the sum of all parts at a point and an energy.
///
/// ```
/// use emitree_problems::cubes::parts::{self, Part};
/// use emitree_problems::cubes::spectrum::Spectrum;
///
/// let spectrum = Spectrum::PowerLaw { index: 1.0 };
/// let part = Part { amplitude: 3.0, centre: [0.5; 3], widths: [0.1; 3], spectrum };
/// assert_eq!(parts::rate(&[part, part], [0.5; 3], 2.0), 3.0);
/// ```
pub fn rate(parts: &[Part], position: [f64; 3], energy: f64) -> f64 {
    parts.iter().map(|part| part.rate(position, energy)).sum()
}

/// The exact cube of `shape` = \[height, width\] pixels and the bins of `axis`.
pub fn exact(parts: &[Part], shape: [usize; 2], axis: &EnergyAxis) -> Cube {
    let images: Vec<(Image, Spectrum)> =
        parts.iter().map(|part| (part.image(shape), part.spectrum)).collect();
    cube_of(&images, shape, axis)
}

/// The cube of images that each have one spectrum.
pub(super) fn cube_of(
    images: &[(Image, Spectrum)],
    [height, width]: [usize; 2],
    axis: &EnergyAxis,
) -> Cube {
    let band = |edges: &[f64]| {
        let mut band = Image::zeros(height, width);
        for (image, spectrum) in images {
            let mean = spectrum.mean(edges[0], edges[1]);
            for (voxel, pixel) in band.pixels_mut().iter_mut().zip(image.pixels()) {
                *voxel += mean * pixel;
            }
        }
        band
    };
    Cube::from_bands(axis.edges().windows(2).map(band).collect())
}
