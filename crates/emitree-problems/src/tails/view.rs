//! Cameras with far = ∞.

use super::line::Line;
use crate::family::generator::Generator;
use core::f64::consts::FRAC_PI_3;
use emitree::projection::GeometryError;
use emitree::{Orthographic, Perspective, Projection, Viewpoint};

/// A square view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum View {
    /// A pinhole, and the tangent of half its field of view.
    Pinhole { place: Place, half: f64, is_inside: bool },
    /// Parallel lines from `near` on, and half the edge of the image.
    Parallel { place: Place, half: f64, near: f64 },
}

/// Where the observer is, and which way is what: forward, right, up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    position: [f64; 3],
    /// The distance of the target, on which depth is resolved.
    distance: f64,
    axes: [[f64; 3]; 3],
}

impl Place {
    /// At a distance from a point near the origin that is in the middle of the view.
    fn draw(generator: &mut Generator, distance: f64) -> Self {
        let [forward, right, up] = generator.axes();
        // Axes are right-handed: right × up = −forward is a camera's, so one changes its sign.
        let up = up.map(|x| -x);
        let target: [f64; 3] = core::array::from_fn(|_| generator.between(-0.7, 0.7));
        let position = core::array::from_fn(|i| target[i] - distance * forward[i]);
        Self { position, distance, axes: [forward, right, up] }
    }

    fn viewpoint(&self) -> Viewpoint {
        let [forward, _, up] = self.axes;
        let target = core::array::from_fn(|i| self.position[i] + self.distance * forward[i]);
        Viewpoint { position: self.position, target, up }
    }
}

impl View {
    pub(super) fn draw(kind: u64, generator: &mut Generator) -> Self {
        let is_inside = kind == 1;
        if kind <= 1 {
            let [from, to] = if is_inside { [0.4, 1.5] } else { [4.0, 8.0] };
            let distance = generator.between(from, to);
            let half = libm::tan(0.5 * FRAC_PI_3 * generator.between(0.7, 1.2));
            Self::Pinhole { place: Place::draw(generator, distance), half, is_inside }
        } else {
            let distance = generator.between(0.5, 3.0);
            let half = generator.between(2.0, 4.0);
            let near = if kind == 2 { f64::NEG_INFINITY } else { 0.0 };
            Self::Parallel { place: Place::draw(generator, distance), half, near }
        }
    }

    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Pinhole { is_inside: false, .. } => "from outside",
            Self::Pinhole { is_inside: true, .. } => "from inside",
            Self::Parallel { near, .. } if near.is_finite() => "from a plane",
            Self::Parallel { .. } => "from infinity",
        }
    }

    pub(super) fn camera(&self) -> Result<Box<dyn Projection>, GeometryError> {
        Ok(match self {
            Self::Pinhole { place, half, .. } => {
                let fov_rad = [2.0 * half.atan(); 2];
                Box::new(Perspective::new(place.viewpoint(), fov_rad, [0.0, f64::INFINITY])?)
            }
            Self::Parallel { place, half, near } => {
                let extent = [2.0 * half; 2];
                Box::new(Orthographic::new(place.viewpoint(), extent, [*near, f64::INFINITY])?)
            }
        })
    }

    /// The line of sight at (x, y) of the image, and the solid angle or area there up to a factor.
    pub(super) fn line(&self, xy: [f64; 2]) -> (Line, f64) {
        let (place, half) = match self {
            Self::Pinhole { place, half, .. } | Self::Parallel { place, half, .. } => (place, half),
        };
        let [forward, right, up] = place.axes;
        let [x, y] = xy.map(|t| half * (2.0 * t - 1.0));
        let aside: [f64; 3] = core::array::from_fn(|i| x * right[i] + y * up[i]);
        match self {
            Self::Pinhole { .. } => {
                let length = (1.0 + x * x + y * y).sqrt();
                let direction = core::array::from_fn(|i| (forward[i] + aside[i]) / length);
                (Line { origin: place.position, direction, near: 0.0 }, length.powi(-3))
            }
            Self::Parallel { near, .. } => {
                let origin = core::array::from_fn(|i| place.position[i] + aside[i]);
                (Line { origin, direction: forward, near: *near }, 1.0)
            }
        }
    }
}
