//! Cubes with sharp surfaces seen by cameras of all kinds, by number: the emission of [`crate::cubes::jumps`] from the
//! cameras of [`crate::jumps`], with their opaque spheres and bounds.
//!
//! The kinds of cameras change with every fifth seed, and those of spectra with every seed, except `place`, whose
//! voxels are not products of means over lines and over bins. Every seed is a scene for ever: [`random_sky_cube`] must
//! not change.

use crate::cubes::jumps::{CubeReference, JumpCube, random_jump_cube};
use crate::jumps::{Jump, random_jump};
use emitree::{EnergyAxis, Projection};

/// A cube and the camera that sees it.
#[derive(Debug)]
pub struct SkyCube {
    view: Jump,
    scene: JumpCube,
}

/// The scene of a seed.
///
/// ```
/// let scene = emitree_problems::cubes::skies::random_sky_cube(5);
/// assert!(scene.name().contains("equirectangular"));
/// ```
pub fn random_sky_cube(seed: u64) -> SkyCube {
    /// The number of kinds of shapes, each of them a seed of a kind of spectrum in turn; of all kinds of spectra; and of those
    /// that are taken.
    const SHAPES: u64 = 5;
    const SPECTRA: u64 = 5;
    const TAKEN: u64 = 4;
    let of_scene = SHAPES * SPECTRA * seed + SHAPES * (seed % TAKEN) + seed % SHAPES;
    SkyCube { view: random_jump(seed), scene: random_jump_cube(of_scene) }
}

impl SkyCube {
    /// What it is called in tables: the cube, and the camera.
    pub fn name(&self) -> String {
        let (_, camera) = self.view.name().split_once('-').unwrap_or_default();
        format!("{} {camera}", self.scene.name())
    }

    /// The camera.
    pub fn camera(&self) -> &(dyn Projection + Send) {
        self.view.camera()
    }

    /// Height and width of the image in pixels.
    pub fn pixels(&self) -> [usize; 2] {
        self.view.pixels()
    }

    /// The emission rate at a point, per unit of energy; NaN inside the body.
    pub fn rate(&self, position: [f64; 3], energy: f64) -> f64 {
        if self.view.is_in_body(position) { f64::NAN } else { self.scene.rate(position, energy) }
    }

    /// The band in `bins` bins.
    ///
    /// # Errors
    ///
    /// Those of [`JumpCube::axis`].
    pub fn axis(&self, bins: usize) -> Result<EnergyAxis, emitree::energy::EnergyError> {
        self.scene.axis(bins)
    }

    /// The reference cube: means of 48 × 48 lines, weighted with solid angle; NaN without an image.
    pub fn reference(&self, axis: &EnergyAxis) -> CubeReference {
        self.scene.reference_of(axis, |shape| self.view.image_of(shape))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Voxels against sums over points of the lines in the middle of a pixel and over energies, in pixels in which both
    /// are smooth: the difference is that between the line in the middle and the mean.
    #[test]
    fn voxels_are_near_the_sums_of_their_middle_lines() {
        const POINTS: usize = 2000;
        const ENERGIES: usize = 10;
        // One camera of each kind.
        for seed in (1..25).step_by(5) {
            let scene = random_sky_cube(seed);
            let axis = scene.axis(1).unwrap_or_else(|_| unreachable!());
            let reference = scene.reference(&axis);
            let band = &reference.cube.bands()[0];
            let [height, width] = scene.pixels();
            let middle = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
            let line = |row: usize, column: usize| {
                let energies = (0..ENERGIES).map(|k| 0.5 + 1.5 * middle(k, ENERGIES));
                let of_energy = |energy: f64| {
                    let of_point = |k: usize| {
                        let u = [middle(column, width), middle(row, height), middle(k, POINTS)];
                        let at = scene.camera().world_from_canonical(u);
                        scene.rate(at.position, energy) * at.path_per_depth
                    };
                    (0..POINTS).map(of_point).sum::<f64>() / POINTS as f64
                };
                energies.map(of_energy).sum::<f64>() / ENERGIES as f64
            };
            let largest = band.min_max().1;
            let places = (0..6).map(|k| [height * (2 * k + 1) / 12, width * (k + 2) / 9]);
            let far = places.filter(|[row, column]| {
                let value = band.row(*row)[*column];
                !value.is_nan() && (value - line(*row, *column)).abs() > 0.15 * largest
            });
            // A limb or a border may cross some of them.
            assert!(far.count() <= 1, "{}", scene.name());
        }
    }
}
