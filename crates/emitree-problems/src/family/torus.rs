//! A tilted ring with a Gaussian cross-section.

use super::Resolution;
use super::frame::Frame;
use super::generator::Generator;
use crate::gauss::Gauss;
use crate::panels::{self, PanelAxis};
use emitree::Image;

/// g is below exp(−36), less than rounding, this many widths beyond the ring.
const REACH: f64 = 6.0;

/// exp(−(p² + t²)/w²), t the distance from the plane of the ring and
/// p = (ρ² − R²)/(2R) the distance from it in that plane, but for a relative p/(2R) that keeps g
/// smooth on the axis ρ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Torus {
    frame: Frame,
    radius: f64,
    width: f64,
}

impl Torus {
    pub(super) fn draw(generator: &mut Generator) -> Self {
        Self {
            frame: Frame::draw(generator),
            radius: generator.between(0.15, 0.35),
            width: generator.log_between(0.03, 0.1),
        }
    }

    pub(super) fn moved(self, by: [f64; 3]) -> Self {
        Self { frame: self.frame.moved(by), ..self }
    }

    pub(super) fn length(&self) -> f64 {
        self.width
    }

    pub(super) fn rate(&self, position: [f64; 3]) -> f64 {
        let [u, v, t] = self.frame.local_from_canonical(position);
        let p = (u * u + v * v - self.radius * self.radius) / (2.0 * self.radius);
        (-(p * p + t * t) / (self.width * self.width)).exp()
    }

    /// Along z, only the chord through the sphere around the ring is integrated.
    pub(super) fn image(&self, [height, width]: [usize; 2], resolution: Resolution) -> Image {
        let axis = |pixels| PanelAxis::uniform(self.width, resolution.across, pixels);
        let depth = Gauss::new(resolution.along);
        let [cx, cy, cz] = self.frame.centre;
        let reach = self.radius + REACH * self.width;
        panels::image(&axis(width), &axis(height), |x, y| {
            let square = reach * reach - (x - cx).powi(2) - (y - cy).powi(2);
            let half = square.max(0.0).sqrt();
            let (from, to) = ((cz - half).max(0.0), (cz + half).min(1.0));
            if square <= 0.0 || from >= to {
                return 0.0;
            }
            let panels = panels::count(to - from, self.width);
            depth.integrate_panels([from, to], panels, |z| self.rate([x, y, z]))
        })
    }
}
