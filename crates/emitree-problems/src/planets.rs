//! Random shapes with sharp surfaces around an opaque planet, by number.
//!
//! The emission is [`random_shape`] in and around the unit cube. The planet is a sphere or an ellipsoid
//! whose semi-axes are 0.06 to 0.25 and whose centre is in the cube, so that it is in front of the shape,
//! behind it or within it. g is NaN inside the planet: no method may evaluate it there. Half of the
//! cameras are orthographic, half are perspective, in random directions. The emission ends where the
//! depths of the camera do. Every seed is a scene for ever: [`random_planet`] must not change.

use crate::family::Reference;
use crate::family::generator::Generator;
use crate::shapes::{Line, Shape, random_shape};
use crate::solids::{LINES, reference, weighted_means};
use emitree::projection::{Ellipsoid, GeometryError};
use emitree::{Orthographic, Perspective, Projection, Viewpoint};
use std::sync::Arc;

/// The width of the orthographic views.
const WIDTH: f64 = 1.2;
/// A point on the surface is not in the planet, whatever rounding does.
const ROUNDING: f64 = 1e-9;

/// A shape with a planet, and a camera.
#[derive(Debug)]
pub struct RandomPlanet {
    seed: u64,
    shape: Shape,
    camera: Arc<dyn Projection + Send>,
    /// The camera without the planet.
    bare: Arc<dyn Projection + Send>,
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
    semi_axes: [f64; 3],
    /// The length of all lines of sight.
    length: f64,
}

/// The scene of a seed; its shape is that of [`random_shape`].
///
/// ```
/// let scene = emitree_problems::planets::random_planet(3);
/// assert_eq!(scene.name(), "planet-union-3");
/// ```
///
/// # Panics
///
/// Never: every seed makes a camera that the library accepts.
pub fn random_planet(seed: u64) -> RandomPlanet {
    // Another stream than those of the other families.
    let mut generator = Generator::new(seed ^ 0x91a2_e700_0000_0000);
    loop {
        if let Ok(scene) = draw(seed, &mut generator) {
            return scene;
        }
    }
}

fn draw(seed: u64, generator: &mut Generator) -> Result<RandomPlanet, GeometryError> {
    let centre = core::array::from_fn(|_| generator.between(0.1, 0.9));
    let axes = generator.axes();
    let radius = generator.log_between(0.06, 0.25);
    let is_sphere = generator.whole(0..=1) == 0;
    let semi_axes = core::array::from_fn(|_| {
        let share = generator.between(0.6, 1.0);
        if is_sphere { radius } else { share * radius }
    });
    let [towards, _, up] = generator.axes();
    let target = core::array::from_fn(|_| generator.between(0.4, 0.6));
    let distance = generator.between(1.2, 3.0);
    let position = core::array::from_fn(|k| target[k] + distance * towards[k]);
    let viewpoint = Viewpoint { position, target, up };
    let planet = Ellipsoid::new(centre, semi_axes)?.oriented(axes[2], axes[0])?;
    let length = 2.0 * distance;
    let fov_rad = 2.0 * (0.5 * WIDTH / distance).atan();
    let camera = |bodies: Vec<Ellipsoid>| -> Result<Arc<dyn Projection + Send>, GeometryError> {
        let depth = [0.0, length];
        Ok(if seed.is_multiple_of(2) {
            let camera = Orthographic::new(viewpoint, [WIDTH; 2], depth)?;
            Arc::new(camera.with_occulters(bodies)?)
        } else {
            let camera = Perspective::new(viewpoint, [fov_rad; 2], depth)?;
            Arc::new(camera.with_occulters(bodies)?)
        })
    };
    let (bare, camera) = (camera(Vec::new())?, camera(vec![planet])?);
    let shape = random_shape(seed);
    Ok(RandomPlanet { seed, shape, camera, bare, centre, axes, semi_axes, length })
}

impl RandomPlanet {
    /// The kind of the shape and the seed.
    pub fn name(&self) -> String {
        format!("planet-{}-{}", self.shape.kind(), self.seed)
    }

    /// The camera.
    pub fn camera(&self) -> Arc<dyn Projection + Send> {
        self.camera.clone()
    }

    /// The emission rate at a point; NaN inside the planet.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let from = self.scaled(core::array::from_fn(|k| position[k] - self.centre[k]));
        let square: f64 = from.iter().map(|x| x * x).sum();
        if square < 1.0 - ROUNDING { f64::NAN } else { self.shape.rate(position) }
    }

    /// A direction along the axes of the planet, in units of its semi-axes.
    fn scaled(&self, direction: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| {
            let along: f64 = (0..3).map(|k| self.axes[i][k] * direction[k]).sum();
            along / self.semi_axes[i]
        })
    }

    /// The radiance of the line of sight at canonical (x, y), in closed form.
    pub fn line_integral(&self, [x, y]: [f64; 2]) -> f64 {
        let first = self.bare.world_from_canonical([x, y, 0.0]);
        let (origin, direction) = (first.position, first.direction.map(|along| -along));
        let from = self.scaled(core::array::from_fn(|k| origin[k] - self.centre[k]));
        let step = self.scaled(direction);
        let product = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let (square, half) = (product(step, step), product(from, step));
        let discriminant = half * half - square * (product(from, from) - 1.0);
        let enter = (-half - discriminant.max(0.0).sqrt()) / square;
        let is_hit = discriminant > 0.0 && (0.0..self.length).contains(&enter);
        let end = if is_hit { enter } else { self.length };
        self.shape.integral_along(&Line { origin, direction, ends: [0.0, end] })
    }

    /// The image of `shape` = \[height, width\] pixels: means of 32 × 32 lines, weighted with solid
    /// angle. Its error is the difference to 16 × 16.
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        let density = |xy| self.bare.solid_angle_density(xy);
        let mean =
            |lines: usize| weighted_means(shape, lines, &density, &|xy| self.line_integral(xy));
        reference(mean(LINES), &mean(LINES / 2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute::check_line_integrals;

    /// A line crosses up to five surfaces, and ends at the planet.
    #[test]
    fn line_integrals_agree_with_many_samples_of_the_rate() {
        for seed in 0..30 {
            let scene = random_planet(seed);
            let rate = |u| scene.length * scene.rate(scene.bare.world_from_canonical(u).position);
            let integral = |line| scene.line_integral(line);
            check_line_integrals(&scene.name(), rate, integral, 6.0, 1.5 * scene.length);
        }
    }

    /// The planet is in the image of nearly all seeds.
    #[test]
    fn planets_change_the_image() {
        let changes = |seed: u64| {
            let scene = random_planet(seed);
            let is_cut = |k: u32| {
                let at = [f64::from(k % 40) + 0.5, f64::from(k / 40) + 0.5].map(|x| x / 40.0);
                let last =
                    |camera: &dyn Projection| camera.world_from_canonical([at[0], at[1], 1.0]);
                last(&*scene.camera) != last(&*scene.bare)
            };
            (0..1600).any(is_cut)
        };
        assert!((0..60).filter(|seed| changes(*seed)).count() >= 55);
    }
}
