//! Random cubes with sharp surfaces, by number: a shape of [`crate::shapes`] with one spectrum in it and another
//! one around it.
//!
//! The kinds are, five seeds of each in turn:
//!
//! | kind | in the shape | around it |
//! | --- | --- | --- |
//! | `continua` | a power law | an exponential |
//! | `line` | a continuum and a line, 1 to 10 % of the band wide | the same continuum |
//! | `edge` | a power law with an absorption edge | a power law |
//! | `vanishing` | a power law | an exponential that is equal to it at one energy of the band |
//! | `place` | exp(−E (1 + a y)) | the same, fainter |
//!
//! In half of the scenes a second shape, which may overlap the first one, adds a line that no other part has. Energies
//! are from 0.5 to 2. Every voxel is a sum of products of means over lines, of closed form, and means over bins, of closed
//! form. Every seed is a scene for ever: [`random_jump_cube`] must not change.

use crate::cubes::spectrum::{Spectrum, exponential_mean};
use crate::family::Reference;
use crate::family::generator::Generator;
use crate::shapes::{Shape, random_shape};
use crate::solids::mean_of_lines;
use emitree::energy::EnergyError;
use emitree::{Cube, EnergyAxis, EnergyScale, Image};

/// The kinds of scenes.
const KINDS: [&str; 5] = ["continua", "line", "edge", "vanishing", "place"];
/// The band.
pub(super) const BAND: [f64; 2] = [0.5, 2.0];

/// How a part depends on the energy.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Dependence {
    /// A spectrum times a factor.
    Everywhere(f64, Spectrum),
    /// exp(−E (1 + `slope` y)).
    Place { slope: f64 },
}

impl Dependence {
    fn at(&self, y: f64, energy: f64) -> f64 {
        match self {
            Self::Everywhere(factor, spectrum) => factor * spectrum.at(energy),
            Self::Place { slope } => (-energy * (1.0 + slope * y)).exp(),
        }
    }

    fn mean(&self, y: f64, [from, to]: [f64; 2]) -> f64 {
        match self {
            Self::Everywhere(factor, spectrum) => factor * spectrum.mean(from, to),
            Self::Place { slope } => exponential_mean(1.0 + slope * y, from, to),
        }
    }
}

/// One scene of the family.
#[derive(Clone, Debug)]
pub struct JumpCube {
    name: String,
    parts: Vec<(Shape, Dependence)>,
}

/// A cube with an estimate of its error.
#[derive(Clone, Debug)]
pub struct CubeReference {
    /// The voxels: means of ∫ g dz over a pixel and a bin.
    pub cube: Cube,
    /// An estimate of the largest error of a voxel, relative to the largest voxel: the difference to means over a
    /// quarter of the lines.
    pub error: f64,
}

/// The scene of a seed.
///
/// ```
/// let scene = emitree_problems::cubes::jumps::random_jump_cube(7);
/// assert!(scene.rate([0.5; 3], 1.0) >= 0.0);
/// ```
pub fn random_jump_cube(seed: u64) -> JumpCube {
    // Another stream than those of the other families.
    let mut generator = Generator::new(seed ^ 0xc0de_0000_ba11_0000);
    let kind = usize::try_from(seed / 5 % 5).unwrap_or(0);
    let shape = random_shape(seed);
    let [inside, outside] = shape.inside_and_outside();
    let index = generator.between(0.5, 2.5);
    let power = Spectrum::PowerLaw { index };
    let mut parts = match kind {
        0 => {
            let scale = generator.between(0.3, 1.5);
            vec![
                (inside, Dependence::Everywhere(1.0, power)),
                (outside, Dependence::Everywhere(2.0, Spectrum::Exponential { scale })),
            ]
        }
        1 => {
            let line =
                Dependence::Everywhere(generator.between(0.5, 5.0), line(&mut generator, 0.01));
            let continuum = Dependence::Everywhere(1.0, power);
            vec![(inside.clone(), continuum), (outside, continuum), (inside, line)]
        }
        2 => {
            let (energy, drop) = (generator.between(0.7, 1.8), generator.between(0.1, 0.6));
            vec![
                (inside, Dependence::Everywhere(1.0, Spectrum::Edge { index, energy, drop })),
                (outside, Dependence::Everywhere(1.0, power)),
            ]
        }
        3 => {
            // Around the shape the constant rate is that in its middle, so that both are equal at one energy.
            let (energy, scale) = (generator.between(0.6, 1.9), generator.between(0.3, 1.0));
            let exponential = Spectrum::Exponential { scale };
            let factor = shape.inside_rate() * power.at(energy) / exponential.at(energy);
            vec![
                (inside, Dependence::Everywhere(1.0, power)),
                (shape.around(factor), Dependence::Everywhere(1.0, exponential)),
            ]
        }
        _ => {
            let place = Dependence::Place { slope: generator.between(-0.4, 0.8) };
            vec![(inside, place), (outside, place)]
        }
    };
    if generator.whole(0..=1) == 1 {
        let [second, _] = random_shape(seed + 1_000_003).inside_and_outside();
        parts.push((
            second,
            Dependence::Everywhere(generator.between(0.3, 2.0), line(&mut generator, 0.01)),
        ));
    }
    let second = if parts.len() > 2 && kind != 1 || parts.len() > 3 { "+line" } else { "" };
    JumpCube { name: format!("{}-{}{second}-{seed}", KINDS[kind], shape.kind()), parts }
}

/// A line whose width is from the share `least` of the band to a tenth of it.
pub(super) fn line(generator: &mut Generator, least: f64) -> Spectrum {
    let [from, to] = BAND;
    let width = (to - from) * generator.log_between(least, 0.1);
    Spectrum::Line { energy: generator.between(from, to), width }
}

impl JumpCube {
    /// What it is called in tables.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The emission rate at a point of the unit cube, per unit of energy.
    pub fn rate(&self, position: [f64; 3], energy: f64) -> f64 {
        let of_part =
            |(shape, of): &(Shape, Dependence)| shape.rate(position) * of.at(position[1], energy);
        self.parts.iter().map(of_part).sum()
    }

    /// The band in `bins` bins.
    ///
    /// # Errors
    ///
    /// [`EnergyError::Bins`]: no bins or more than 65 536.
    pub fn axis(&self, bins: usize) -> Result<EnergyAxis, EnergyError> {
        EnergyAxis::new(BAND[0], BAND[1], bins, EnergyScale::Linear)
    }

    /// The cube of `shape` = \[height, width\] pixels in the canonical projection: the means of 32 × 32 lines for each
    /// pixel.
    pub fn reference(&self, shape: [usize; 2], axis: &EnergyAxis) -> CubeReference {
        let edges = axis.edges();
        let mut sum = Sum::default();
        for (of_shape, dependence) in &self.parts {
            let means = |weight: &(dyn Fn(f64) -> f64 + Sync)| {
                mean_of_lines(shape, |[x, y]| weight(y) * of_shape.line_integral([x, y]))
            };
            match dependence {
                Dependence::Everywhere(..) => sum.add_product(&means(&|_| 1.0), dependence, &edges),
                Dependence::Place { .. } => {
                    for (bin, ends) in edges.windows(2).enumerate() {
                        let of_bin = means(&|y| dependence.mean(y, [ends[0], ends[1]]));
                        let factors = (0..axis.bins()).map(|k| f64::from(u8::from(k == bin)));
                        sum.add(&of_bin, factors);
                    }
                }
            }
        }
        sum.reference()
    }

    /// The cube of a camera, given the images of shapes; without parts whose spectra depend on the place.
    pub(crate) fn reference_of(
        &self,
        axis: &EnergyAxis,
        image_of: impl Fn(&Shape) -> Reference,
    ) -> CubeReference {
        let mut sum = Sum::default();
        for (shape, dependence) in &self.parts {
            sum.add_product(&image_of(shape), dependence, &axis.edges());
        }
        sum.reference()
    }
}

/// A sum of images times factors for each bin.
#[derive(Default)]
struct Sum {
    bands: Vec<Image>,
    errors: Vec<f64>,
}

impl Sum {
    /// Adds an image times the means of a spectrum over bins.
    fn add_product(&mut self, image: &Reference, dependence: &Dependence, edges: &[f64]) {
        let factors = edges.windows(2).map(|ends| dependence.mean(0.0, [ends[0], ends[1]]));
        self.add(image, factors);
    }

    fn add(&mut self, image: &Reference, factors: impl Iterator<Item = f64>) {
        let largest = image.image.min_max().1;
        for (bin, factor) in factors.enumerate() {
            if self.bands.len() == bin {
                self.bands.push(Image::zeros(image.image.height(), image.image.width()));
                self.errors.push(0.0);
            }
            let pixels = self.bands[bin].pixels_mut().iter_mut().zip(image.image.pixels());
            pixels.for_each(|(sum, pixel)| *sum += factor * pixel);
            // What no line sees has no error.
            if largest > 0.0 {
                self.errors[bin] += factor * image.error * largest;
            }
        }
    }

    fn reference(self) -> CubeReference {
        let cube = Cube::from_bands(self.bands);
        let largest = self.errors.iter().copied().fold(0.0, f64::max);
        let error = if largest > 0.0 { largest / cube.largest() } else { 0.0 };
        CubeReference { cube, error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every kind against sums over many points and energies.
    #[test]
    fn voxels_agree_with_many_samples_of_the_rate() {
        for seed in [0, 6, 12, 18, 24, 31, 37] {
            let scene = random_jump_cube(seed);
            let axis = scene.axis(2).unwrap_or_else(|_| unreachable!());
            let reference = scene.reference([2, 2], &axis);
            const POINTS: usize = 64;
            const ENERGIES: usize = 400;
            let middle = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
            let (mut sums, share) = ([[0.0; 4]; 2], 1.0 / (POINTS.pow(3) * ENERGIES) as f64);
            let energies: Vec<f64> =
                (0..ENERGIES).map(|k| 0.5 + 1.5 * middle(k, ENERGIES)).collect();
            for (shape, dependence) in &scene.parts {
                for k in 0..POINTS.pow(3) {
                    let at = [k % POINTS, k / POINTS % POINTS, k / POINTS.pow(2)]
                        .map(|k| middle(k, POINTS));
                    let rate = shape.rate(at);
                    if rate == 0.0 {
                        continue;
                    }
                    let pixel = usize::from(at[0] > 0.5) + 2 * usize::from(at[1] > 0.5);
                    let step = match dependence {
                        Dependence::Everywhere(..) => 1,
                        Dependence::Place { .. } => 8,
                    };
                    for energy in energies.iter().step_by(step) {
                        let bin = usize::from(*energy > 1.25);
                        sums[bin][pixel] +=
                            8.0 * step as f64 * share * rate * dependence.at(at[1], *energy);
                    }
                }
            }
            for (bin, band) in reference.cube.bands().iter().enumerate() {
                for (pixel, (value, sum)) in band.pixels().iter().zip(sums[bin]).enumerate() {
                    let far = (value - sum).abs() / reference.cube.largest();
                    assert!(far < 0.02, "{} {bin} {pixel}: {value} {sum}", scene.name());
                }
            }
        }
    }

    #[test]
    fn every_kind_is_there_with_a_small_error() {
        for seed in (0..50).step_by(5) {
            let scene = random_jump_cube(seed);
            assert!(scene.name().starts_with(KINDS[(seed / 5 % 5) as usize]), "{}", scene.name());
        }
        let scene = random_jump_cube(1);
        let axis = scene.axis(3).unwrap_or_else(|_| unreachable!());
        assert!(scene.reference([32, 32], &axis).error < 5e-3);
    }
}
