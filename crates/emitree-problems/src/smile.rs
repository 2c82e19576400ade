//! Random views of the soft X-rays of the magnetosheath, by number.
//!
//! The emission is that of [`Cmem`] or [`Jorgensen`] in a random solar wind: it jumps at the magnetopause,
//! with its indentations at the cusps, and at the bow shock. The Earth is opaque. Cameras are orthographic,
//! perspective and equirectangular in turn, at 15 to 40 Earth radii from a target on the dayside, in random
//! directions. The emission ends where the depths of the camera do. Every seed is a scene for ever:
//! [`random_smile`] must not change.

use crate::family::Reference;
use crate::family::generator::Generator;
use crate::gauss::Gauss;
use crate::solids::{reference, weighted_means};
use emitree::projection::{Ellipsoid, GeometryError};
use emitree::{Equirectangular, Orthographic, Perspective, Projection, Viewpoint};
use emitree_models::models::{Cmem, Jorgensen};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The lines in a pixel of the reference image, along each axis.
const LINES: usize = 16;
/// Equal panels of a line. A panel whose ends differ by more than `JUMP` of the larger is searched for a jump.
const PANELS: usize = 160;
const JUMP: f64 = 0.05;
const HALVINGS: usize = 36;

/// The emission.
#[derive(Debug)]
enum Model {
    Cmem(Cmem),
    Jorgensen(Jorgensen),
}

/// A model with a camera.
#[derive(Debug)]
pub struct RandomSmile {
    seed: u64,
    model: Model,
    camera: Arc<dyn Projection + Send>,
    /// The camera without the Earth.
    bare: Arc<dyn Projection + Send>,
    /// The length of all lines of sight.
    length: f64,
    gauss: Gauss,
}

/// The scene of a seed.
///
/// ```
/// let scene = emitree_problems::smile::random_smile(3);
/// assert_eq!(scene.name(), "smile-jorgensen-3");
/// ```
///
/// # Panics
///
/// Never: every seed makes a camera that the library accepts.
pub fn random_smile(seed: u64) -> RandomSmile {
    // Another stream than those of the other families.
    let mut generator = Generator::new(seed ^ 0x5314_e000_0000_0000);
    loop {
        if let Some(scene) = draw(seed, &mut generator) {
            return scene;
        }
    }
}

fn draw(seed: u64, generator: &mut Generator) -> Option<RandomSmile> {
    let wind = [
        ("density", generator.between(3.0, 12.0)),
        ("velocity", generator.between(350.0, 600.0)),
        ("bz", generator.between(-5.0, 5.0)),
    ];
    let wind: BTreeMap<String, f64> = wind.map(|(name, value)| (name.to_owned(), value)).into();
    let model = if seed % 4 == 3 {
        Model::Jorgensen(Jorgensen::new(&wind).ok()?)
    } else {
        Model::Cmem(Cmem::new(&wind).ok()?)
    };
    let [towards, _, up] = generator.axes();
    let target =
        [generator.between(2.0, 9.0), generator.between(-3.0, 3.0), generator.between(-3.0, 3.0)];
    let distance = generator.between(15.0, 40.0);
    let position = core::array::from_fn(|k| target[k] + distance * towards[k]);
    let viewpoint = Viewpoint { position, target, up };
    let extent = [generator.between(10.0, 24.0), generator.between(10.0, 24.0)];
    let earth = Ellipsoid::new([0.0; 3], [1.0; 3]).ok()?;
    let length = 2.0 * distance;
    let camera = |bodies| camera(seed, viewpoint, extent, length, bodies);
    let (bare, camera) = (camera(Vec::new()).ok()?, camera(vec![earth]).ok()?);
    Some(RandomSmile { seed, model, camera, bare, length, gauss: Gauss::new(3) })
}

fn camera(
    seed: u64,
    viewpoint: Viewpoint,
    extent: [f64; 2],
    length: f64,
    bodies: Vec<Ellipsoid>,
) -> Result<Arc<dyn Projection + Send>, GeometryError> {
    let depth = [0.0, length];
    let fov_rad = extent.map(|along| 2.0 * (along / length).atan());
    Ok(match seed % 3 {
        0 => Arc::new(Orthographic::new(viewpoint, extent, depth)?.with_occulters(bodies)?),
        1 => Arc::new(Perspective::new(viewpoint, fov_rad, depth)?.with_occulters(bodies)?),
        _ => Arc::new(Equirectangular::new(viewpoint, fov_rad, depth)?.with_occulters(bodies)?),
    })
}

impl RandomSmile {
    /// The model and the seed.
    pub fn name(&self) -> String {
        let model = match self.model {
            Model::Cmem(_) => "cmem",
            Model::Jorgensen(_) => "jorgensen",
        };
        format!("smile-{model}-{}", self.seed)
    }

    /// The camera.
    pub fn camera(&self) -> Arc<dyn Projection + Send> {
        self.camera.clone()
    }

    /// The emission rate at a point.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        match &self.model {
            Model::Cmem(model) => model.emissivity(position),
            Model::Jorgensen(model) => model.emissivity(position),
        }
    }

    /// The radiance of the line of sight at canonical (x, y): Gauss's rule with 3 points on equal panels,
    /// which are divided at jumps.
    fn line_integral(&self, [x, y]: [f64; 2], panels: usize) -> f64 {
        let first = self.bare.world_from_canonical([x, y, 0.0]);
        let (origin, direction) = (first.position, first.direction.map(|along| -along));
        // Where the line enters the Earth, of radius 1 at the origin.
        let product = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let half = product(origin, direction);
        let discriminant = half * half - (product(origin, origin) - 1.0);
        let enter = -half - discriminant.max(0.0).sqrt();
        let is_hit = discriminant > 0.0 && (0.0..self.length).contains(&enter);
        let end = if is_hit { enter } else { self.length };
        let rate = |t: f64| self.rate(core::array::from_fn(|k| origin[k] + t * direction[k]));
        let panel = |from: f64, to: f64| self.gauss.integrate(from, to, rate);
        let differs = |[a, b]: [f64; 2]| (b - a).abs() > JUMP * a.abs().max(b.abs());
        let mut sum = 0.0;
        let mut before = rate(0.0);
        for k in 0..panels {
            let [from, to] = [k, k + 1].map(|k| end * k as f64 / panels as f64);
            let after = rate(to);
            if differs([before, after]) {
                let (mut low, mut high, mut ends) = (from, to, [before, after]);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    let at = rate(middle);
                    if (at - ends[0]).abs() > (at - ends[1]).abs() {
                        (high, ends[1]) = (middle, at);
                    } else {
                        (low, ends[0]) = (middle, at);
                    }
                }
                sum += panel(from, low) + panel(high, to);
            } else {
                sum += panel(from, to);
            }
            before = after;
        }
        sum
    }

    /// The image of `shape` = \[height, width\] pixels: means of 16 × 16 lines, weighted with solid angle.
    /// Its error is the difference to 8 × 8 lines of fewer panels.
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        let density = |xy| self.bare.solid_angle_density(xy);
        let mean = |lines: usize, panels: usize| {
            weighted_means(shape, lines, &density, &|xy| self.line_integral(xy, panels))
        };
        let (image, coarser) = (mean(LINES, PANELS), mean(LINES / 2, PANELS * 3 / 4));
        reference(image, &coarser)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute::check_line_integrals;

    #[test]
    fn line_integrals_agree_with_many_samples_of_the_rate() {
        for seed in [0, 3, 8] {
            let scene = random_smile(seed);
            // A line ends at the Earth.
            let rate = |u| {
                let at = scene.bare.world_from_canonical(u).position;
                let square: f64 = at.iter().map(|along| along * along).sum();
                if square < 1.0 { f64::NAN } else { scene.length * scene.rate(at) }
            };
            let integral = |xy| scene.line_integral(xy, PANELS);
            let places = (0..8000).map(|k| [k % 20, k * 7 % 20, k / 20]);
            let places = places
                .map(|[x, y, z]| [f64::from(x) / 20.0, f64::from(y) / 20.0, f64::from(z) / 400.0]);
            let scale = places.map(rate).fold(0.0, f64::max);
            check_line_integrals(&scene.name(), rate, integral, 6.0, scale);
        }
    }
}
