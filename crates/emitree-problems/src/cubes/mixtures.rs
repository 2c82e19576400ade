//! Random smooth cubes, by number: two emissions of one view, each with a spectrum of its own.
//!
//! The emissions are a random scene of [`crate::family`] with another one, seen in the canonical projection, or a random
//! view of [`crate::views`] with the same view of other parameters, so that there are bodies, bounds and edges.
//!
//! | kind | spectra |
//! | --- | --- |
//! | `continua` | a power law and an exponential |
//! | `line` | a power law and a line, 0.5 to 10 % of the band wide |
//! | `edge` | a power law with an absorption edge and an exponential |
//! | `lines` | two lines |
//!
//! The kind changes with every seed. Energies are from 0.5 to 2. Every voxel is a sum of two products of a pixel, by the
//! quadrature of the family, and a mean over a bin, of closed form. Every seed is a scene for ever:
//! [`random_mixture`] must not change.

use crate::cubes::jumps::{BAND, CubeReference, line};
use crate::cubes::spectrum::Spectrum;
use crate::family::generator::Generator;
use crate::family::{RandomScene, Reference, random_scene};
use crate::views::{RandomView, random_view};
use emitree::energy::EnergyError;
use emitree::{Canonical, Cube, EnergyAxis, EnergyScale, Image, Projection};

/// The kinds of spectra.
const KINDS: [&str; 4] = ["continua", "line", "edge", "lines"];
/// Height and width in pixels of the canonical projection.
const SHAPE: [usize; 2] = [32, 32];
/// By how much the parameters of the second emission of a view differ, as a fraction.
const CHANGE: f64 = 0.5;

#[derive(Debug)]
enum Emissions {
    Scenes(Box<[RandomScene; 2]>),
    Views(Box<[RandomView; 2]>),
}

/// A cube of two emissions.
#[derive(Debug)]
pub struct MixtureCube {
    name: String,
    emissions: Emissions,
    spectra: [Spectrum; 2],
}

/// The cube of a seed, in the canonical projection, or with `has_camera` in a random view.
///
/// ```
/// let cube = emitree_problems::cubes::mixtures::random_mixture(0, false);
/// assert!(cube.rate([0.5; 3], 1.0) > 0.0);
/// ```
pub fn random_mixture(seed: u64, has_camera: bool) -> MixtureCube {
    // Another stream than those of the other families.
    let mut generator = Generator::new(seed ^ 0x0050_ec72_a000_0000);
    let kind = usize::try_from(seed % KINDS.len() as u64).unwrap_or(0);
    let power = Spectrum::PowerLaw { index: generator.between(0.5, 2.5) };
    let exponential = Spectrum::Exponential { scale: generator.between(0.3, 1.5) };
    let spectra = match kind {
        0 => [power, exponential],
        1 => [power, line(&mut generator, 0.005)],
        2 => {
            let (energy, drop) = (generator.between(0.7, 1.8), generator.between(0.1, 0.6));
            [Spectrum::Edge { index: generator.between(0.5, 2.5), energy, drop }, exponential]
        }
        _ => [line(&mut generator, 0.005), line(&mut generator, 0.005)],
    };
    let (emissions, of_view) = if has_camera {
        let [first, second] = [random_view(seed), random_view(seed).changed(CHANGE)];
        let name = first.name();
        (Emissions::Views(Box::new([first, second])), name)
    } else {
        let pair = [2 * seed, 2 * seed + 1].map(random_scene);
        let name = pair.each_ref().map(RandomScene::name).join("+");
        (Emissions::Scenes(Box::new(pair)), name)
    };
    MixtureCube { name: format!("{} {of_view}", KINDS[kind]), emissions, spectra }
}

impl MixtureCube {
    /// What it is called in tables.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The camera.
    pub fn camera(&self) -> &dyn Projection {
        match &self.emissions {
            Emissions::Scenes(_) => &Canonical,
            Emissions::Views(views) => views[0].camera(),
        }
    }

    /// Height and width of the image in pixels.
    pub fn pixels(&self) -> [usize; 2] {
        match &self.emissions {
            Emissions::Scenes(_) => SHAPE,
            Emissions::Views(views) => views[0].shape(),
        }
    }

    /// The emission rate at a point, per unit of energy; NaN inside a body.
    pub fn rate(&self, position: [f64; 3], energy: f64) -> f64 {
        let rates = match &self.emissions {
            Emissions::Scenes(scenes) => scenes.each_ref().map(|of| of.rate(position)),
            Emissions::Views(views) => views.each_ref().map(|of| of.rate(position)),
        };
        rates.iter().zip(&self.spectra).map(|(rate, spectrum)| rate * spectrum.at(energy)).sum()
    }

    /// The band in `bins` bins.
    ///
    /// # Errors
    ///
    /// [`EnergyError::Bins`]: no bins or more than 65 536.
    pub fn axis(&self, bins: usize) -> Result<EnergyAxis, EnergyError> {
        EnergyAxis::new(BAND[0], BAND[1], bins, EnergyScale::Linear)
    }

    /// The reference cube; NaN without an image.
    pub fn reference(&self, axis: &EnergyAxis) -> CubeReference {
        let shape @ [height, width] = self.pixels();
        let references: [Reference; 2] = match &self.emissions {
            Emissions::Scenes(scenes) => scenes.each_ref().map(|of| of.reference_image(shape)),
            Emissions::Views(views) => views.each_ref().map(RandomView::reference),
        };
        let (edges, mut bands, mut worst) = (axis.edges(), Vec::new(), 0.0_f64);
        for ends in edges.windows(2) {
            let mut band = Image::zeros(height, width);
            let mut error = 0.0;
            for (of, spectrum) in references.iter().zip(&self.spectra) {
                let mean = spectrum.mean(ends[0], ends[1]);
                let pixels = band.pixels_mut().iter_mut().zip(of.image.pixels());
                pixels.for_each(|(sum, pixel)| *sum += mean * pixel);
                error += mean.abs() * of.error * of.image.min_max().1;
            }
            bands.push(band);
            worst = worst.max(error);
        }
        let cube = Cube::from_bands(bands);
        let error = worst / cube.largest();
        CubeReference { cube, error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Voxels against sums over points of the line in the middle of a pixel and over energies: the difference is that
    /// between this line and the mean.
    #[test]
    fn voxels_are_near_the_sums_of_their_middle_lines() {
        const POINTS: usize = 1000;
        const ENERGIES: usize = 200;
        let middle = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
        for (seed, has_camera) in [(0, false), (1, false), (3, true), (2, true)] {
            let scene = random_mixture(seed, has_camera);
            let axis = scene.axis(2).unwrap_or_else(|_| unreachable!());
            let reference = scene.reference(&axis);
            let largest = reference.cube.largest();
            let [height, width] = scene.pixels();
            let (row, column) = (2 * height / 5, width / 3);
            let of_point = |k: usize| {
                let u = [middle(column, width), middle(row, height), middle(k, POINTS)];
                scene.camera().world_from_canonical(u)
            };
            let points: Vec<_> = (0..POINTS).map(of_point).collect();
            for (bin, ends) in axis.edges().windows(2).enumerate() {
                let of_energy = |k: usize| {
                    let energy = ends[0] + (ends[1] - ends[0]) * middle(k, ENERGIES);
                    let visible = points.iter().filter(|at| at.path_per_depth > 0.0);
                    let rates =
                        visible.map(|at| scene.rate(at.position, energy) * at.path_per_depth);
                    rates.sum::<f64>() / POINTS as f64
                };
                let sum = (0..ENERGIES).map(of_energy).sum::<f64>() / ENERGIES as f64;
                let voxel = reference.cube.bands()[bin].row(row)[column];
                let difference = (voxel - sum).abs() / largest;
                assert!(difference < 0.02, "{} {bin}: {difference}", scene.name());
            }
        }
    }
}
