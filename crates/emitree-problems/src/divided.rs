//! Gaussian balls divided by planes on which g jumps or has a kink, by number.
//!
//! [`random_divided`] makes the scene of a seed: one to four balls exp(−|r − c|²/w²), w from 0.3 to 0.8, times a factor
//! for each plane. Even seeds have one or two planes with a jump, 1 on one side and 0 to 0.7 on the other; odd
//! seeds have one with a kink, 1 + b |s| with the distance s from it. The angle between the normal of a plane and the
//! line of sight in the middle of the view is at most 72°. The camera is half of the seed modulo 3: parallel lines in
//! spherical bounds, parallel lines without, and a pinhole. Every seed is a scene for ever: [`random_divided`] must not
//! change.
//!
//! # The reference image
//!
//! Integrals along lines are closed forms: error functions between the planes. Across the image panels carry
//! polynomials, as in [`family`](crate::family); the error is the difference to a coarser rule.

use crate::family::Reference;
use crate::family::generator::Generator;
use crate::panels::{self, PanelAxis};
use core::f64::consts::PI;
use emitree::projection::{Bounds, Edge, Ellipsoid, GeometryError};
use emitree::{Image, Orthographic, Perspective, Projection, Viewpoint};
use std::sync::Arc;

/// Panels along each axis of the image, and their nodes, coarse and fine. The image has a kink on the line in which two
/// planes cross.
const PANELS: usize = 64;
const NODES: [usize; 2] = [6, 9];
/// The distance of the observer, or of the plane at which parallel lines begin, from the target.
const DISTANCE: f64 = 8.0;
/// Half of the edge of the image at the target.
const HALF: f64 = 2.0;
/// The radius of the bounds: balls are below 1e-20 beyond.
const BOUNDS: f64 = 6.5;

/// A scene of the family.
#[derive(Clone, Debug)]
pub struct Divided {
    seed: u64,
    balls: Vec<Ball>,
    walls: Vec<Wall>,
    /// Forward, right and up.
    axes: [[f64; 3]; 3],
}

#[derive(Clone, Copy, Debug)]
struct Ball {
    centre: [f64; 3],
    width: f64,
    height: f64,
}

/// A plane and what g is multiplied with.
#[derive(Clone, Copy, Debug)]
struct Wall {
    position: [f64; 3],
    normal: [f64; 3],
    factor: Factor,
}

#[derive(Clone, Copy, Debug)]
enum Factor {
    /// On the side of the normal; 1 on the other one.
    Jump(f64),
    /// 1 + b |s|.
    Kink(f64),
}

/// The scene of a seed.
///
/// ```
/// let scene = emitree_problems::divided::random_divided(3);
/// assert_eq!(scene.name(), "kink in parallel lines, 3");
/// ```
pub fn random_divided(seed: u64) -> Divided {
    // Another stream than those of the other families.
    let mut generator = Generator::new(seed ^ 0xd171_0000_0000_0000);
    let [forward, right, up] = generator.axes();
    let axes = [forward, right, up.map(|along| -along)];
    let point = |generator: &mut Generator, reach: f64| {
        core::array::from_fn::<f64, 3, _>(|_| generator.between(-reach, reach))
    };
    let balls = (0..generator.whole(1..=4))
        .map(|_| {
            let centre = point(&mut generator, 0.7);
            let [width, height] = [generator.between(0.3, 0.8), generator.between(0.3, 1.0)];
            Ball { centre, width, height }
        })
        .collect();
    let is_jump = seed.is_multiple_of(2);
    let count = if is_jump { generator.whole(1..=2) } else { 1 };
    let walls = (0..count)
        .map(|_| {
            let position = point(&mut generator, 0.4);
            let (tilt, azimuth) =
                (generator.between(0.0, 0.4 * PI), generator.between(0.0, 2.0 * PI));
            let turn = if generator.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
            let (sin, cos) = tilt.sin_cos();
            let normal = core::array::from_fn(|i| {
                let aside = azimuth.cos() * axes[1][i] + azimuth.sin() * axes[2][i];
                turn * (cos * axes[0][i] + sin * aside)
            });
            let factor = match is_jump {
                true => Factor::Jump(generator.between(0.0, 0.7)),
                false => Factor::Kink(generator.between(0.5, 2.0)),
            };
            Wall { position, normal, factor }
        })
        .collect();
    Divided { seed, balls, walls, axes }
}

impl Divided {
    /// The kind, the camera and the seed.
    pub fn name(&self) -> String {
        let kind = if self.seed.is_multiple_of(2) { "jump" } else { "kink" };
        let camera = ["bounds", "parallel lines", "a pinhole"][self.camera_number()];
        format!("{kind} in {camera}, {}", self.seed)
    }

    fn camera_number(&self) -> usize {
        (self.seed / 2 % 3) as usize
    }

    /// The emission rate.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let balls = self.balls.iter().map(|ball| {
            let square: f64 = (0..3).map(|i| (position[i] - ball.centre[i]).powi(2)).sum();
            ball.height * (-square / ball.width.powi(2)).exp()
        });
        let walls = self.walls.iter().map(|wall| {
            let height = wall.height(position);
            match wall.factor {
                Factor::Jump(factor) if height > 0.0 => factor,
                Factor::Jump(_) => 1.0,
                Factor::Kink(slope) => 1.0 + slope * height.abs(),
            }
        });
        balls.sum::<f64>() * walls.product::<f64>()
    }

    /// The camera, to which the planes are declared.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] never, for the numbers that are drawn.
    pub fn camera(&self) -> Result<Arc<dyn Projection + Send>, GeometryError> {
        let [forward, _, up] = self.axes;
        let position = forward.map(|along| -DISTANCE * along);
        let viewpoint = Viewpoint { position, target: [0.0; 3], up };
        let planes = self.walls.iter().map(|wall| Edge::plane(wall.position, wall.normal));
        let planes = planes.collect::<Result<Vec<_>, _>>()?;
        let depths = [0.0, 2.0 * DISTANCE];
        Ok(match self.camera_number() {
            0 => {
                let bounds = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], BOUNDS)?);
                let camera = Orthographic::new(viewpoint, [2.0 * HALF; 2], depths)?;
                Arc::new(camera.with_bounds(bounds).with_edges(planes))
            }
            1 => {
                Arc::new(Orthographic::new(viewpoint, [2.0 * HALF; 2], depths)?.with_edges(planes))
            }
            _ => {
                let fov_rad = [2.0 * (HALF / DISTANCE).atan(); 2];
                Arc::new(Perspective::new(viewpoint, fov_rad, depths)?.with_edges(planes))
            }
        })
    }

    /// The image of `shape` = \[height, width\] pixels, and its error.
    ///
    /// ```
    /// let reference = emitree_problems::divided::random_divided(0).reference_image([6, 4]);
    /// assert!(reference.error < 1e-4);
    /// ```
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        let [coarse, fine] = NODES.map(|nodes| self.image(shape, nodes));
        let error = fine.max_difference(&coarse) / fine.min_max().1;
        Reference { image: fine, error }
    }

    fn image(&self, [height, width]: [usize; 2], nodes: usize) -> Image {
        let borders: Vec<f64> = (0..=PANELS).map(|i| i as f64 / PANELS as f64).collect();
        let axis = |pixels| PanelAxis::new(&borders, nodes, pixels);
        // A pixel is the mean over its solid angle.
        let bands = panels::images(&axis(width), &axis(height), 2, |x, y, values| {
            let (origin, direction, weight) = self.line([x, y]);
            values[0] = weight * self.radiance(origin, direction);
            values[1] = weight;
        });
        let pairs = bands[0].pixels().iter().zip(bands[1].pixels());
        Image::from_pixels(height, width, pairs.map(|(sum, weight)| sum / weight).collect())
    }

    /// The line of sight at (x, y) of the image: a point, the unit direction, and the solid angle up to a factor.
    fn line(&self, xy: [f64; 2]) -> ([f64; 3], [f64; 3], f64) {
        let [forward, right, up] = self.axes;
        let [x, y] = xy.map(|along| HALF * (2.0 * along - 1.0));
        let aside: [f64; 3] = core::array::from_fn(|i| x * right[i] + y * up[i]);
        let observer = forward.map(|along| -DISTANCE * along);
        if self.camera_number() < 2 {
            return (core::array::from_fn(|i| observer[i] + aside[i]), forward, 1.0);
        }
        let towards: [f64; 3] = core::array::from_fn(|i| DISTANCE * forward[i] + aside[i]);
        let length = towards.iter().map(|along| along * along).sum::<f64>().sqrt();
        (observer, towards.map(|along| along / length), length.powi(-3))
    }

    /// ∫ g ds along a whole line.
    fn radiance(&self, origin: [f64; 3], direction: [f64; 3]) -> f64 {
        let crossing = |wall: &Wall| {
            -wall.height(origin) / (0..3).map(|i| wall.normal[i] * direction[i]).sum::<f64>()
        };
        let mut ends: Vec<f64> = self.walls.iter().map(crossing).collect();
        ends.sort_by(f64::total_cmp);
        ends.insert(0, f64::NEG_INFINITY);
        ends.push(f64::INFINITY);
        let part = |ends: &[f64]| {
            let [from, to] = [ends[0], ends[1]];
            let inside = match (from.is_finite(), to.is_finite()) {
                (true, true) => 0.5 * (from + to),
                (true, false) => from + 1.0,
                _ => to - 1.0,
            };
            let position = core::array::from_fn(|i| origin[i] + inside * direction[i]);
            // The factor is a polynomial of the distance along the line.
            let [constant, slope] = self.factor(position, direction, inside);
            let balls = self.balls.iter().map(|ball| ball.moments(origin, direction, [from, to]));
            balls.map(|[zeroth, first]| constant * zeroth + slope * first).sum::<f64>()
        };
        ends.windows(2).map(part).sum()
    }

    /// The factor of all planes around a position at a distance of a line: a constant and a slope along the line.
    fn factor(&self, position: [f64; 3], direction: [f64; 3], distance: f64) -> [f64; 2] {
        self.walls.iter().fold([1.0, 0.0], |[constant, slope], wall| {
            let height = wall.height(position);
            match wall.factor {
                Factor::Jump(factor) if height > 0.0 => [factor * constant, factor * slope],
                Factor::Jump(_) => [constant, slope],
                // Alone.
                Factor::Kink(bend) => {
                    let along: f64 = (0..3).map(|i| wall.normal[i] * direction[i]).sum();
                    let bend = bend * height.signum();
                    [1.0 + bend * (height - along * distance), bend * along]
                }
            }
        })
    }
}

impl Wall {
    /// The distance of a position from the plane, above 0 on the side of the normal.
    fn height(&self, position: [f64; 3]) -> f64 {
        (0..3).map(|i| (position[i] - self.position[i]) * self.normal[i]).sum()
    }
}

impl Ball {
    /// ∫ g ds and ∫ s g ds along a part of a line.
    fn moments(&self, origin: [f64; 3], direction: [f64; 3], ends: [f64; 2]) -> [f64; 2] {
        let offset: [f64; 3] = core::array::from_fn(|i| self.centre[i] - origin[i]);
        let nearest: f64 = (0..3).map(|i| offset[i] * direction[i]).sum();
        let square = offset.iter().map(|along| along * along).sum::<f64>() - nearest * nearest;
        let peak = self.height * (-square / self.width.powi(2)).exp();
        let [low, high] = ends.map(|end| (end - nearest) / self.width);
        let zeroth = peak * self.width * 0.5 * PI.sqrt() * (libm::erf(high) - libm::erf(low));
        let about = peak * self.width.powi(2) * 0.5 * ((-low * low).exp() - (-high * high).exp());
        [zeroth, nearest * zeroth + about]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauss::Gauss;

    #[test]
    fn radiances_are_those_of_quadrature_between_the_planes() {
        let rule = Gauss::new(20);
        for seed in 0..24 {
            let scene = random_divided(seed);
            for xy in [[0.5, 0.5], [0.31, 0.62], [0.77, 0.4]] {
                let (origin, direction, _) = scene.line(xy);
                let along = |wall: &Wall| -> f64 {
                    let slope: f64 = (0..3).map(|i| wall.normal[i] * direction[i]).sum();
                    (-wall.height(origin) / slope).clamp(0.0, 2.0 * DISTANCE)
                };
                let mut ends: Vec<f64> = scene.walls.iter().map(along).collect();
                ends.extend([0.0, 2.0 * DISTANCE]);
                ends.sort_by(f64::total_cmp);
                let at =
                    |s: f64| scene.rate(core::array::from_fn(|i| origin[i] + s * direction[i]));
                let parts = ends.windows(2);
                let sum: f64 =
                    parts.map(|ends| rule.integrate_panels([ends[0], ends[1]], 40, at)).sum();
                let exact = scene.radiance(origin, direction);
                assert!((sum - exact).abs() < 1e-12 * exact.max(1e-3), "{seed}: {sum} {exact}");
            }
        }
    }

    #[test]
    fn references_are_known_to_a_twentieth_of_the_tightest_tolerance() {
        for seed in 0..24 {
            let error = random_divided(seed).reference_image([64, 64]).error;
            assert!(error < 5e-5, "{seed}: {error:.1e}");
        }
    }

    #[test]
    fn cameras_have_the_lines_of_the_reference() {
        for seed in 0..6 {
            let scene = random_divided(seed);
            let camera = scene.camera().unwrap();
            for xy in [[0.5, 0.5], [0.2, 0.9]] {
                let point = camera.world_from_canonical([xy[0], xy[1], 0.5]);
                let (origin, direction, _) = scene.line(xy);
                let offset: [f64; 3] = core::array::from_fn(|i| point.position[i] - origin[i]);
                let along: f64 = (0..3).map(|i| offset[i] * direction[i]).sum();
                let beside =
                    (0..3).map(|i| (offset[i] - along * direction[i]).powi(2)).sum::<f64>();
                assert!(beside < 1e-20, "{seed}: {beside:e}");
            }
        }
    }
}
