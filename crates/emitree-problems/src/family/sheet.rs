//! A thin sheet: tilted, bent, and faint towards its rim.

use super::Resolution;
use super::frame::Frame;
use super::generator::Generator;
use crate::gauss::Gauss;
use crate::panels::{self, PanelAxis};
use emitree::Image;

/// exp(−(t − b u²)²/w² − (u² + v²)/e²): a Gaussian across the surface t = b u² under a Gaussian
/// envelope along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sheet {
    frame: Frame,
    bend: f64,
    width: f64,
    envelope: f64,
}

impl Sheet {
    pub(super) fn draw(generator: &mut Generator) -> Self {
        Self {
            frame: Frame::draw(generator),
            bend: generator.between(-1.0, 1.0),
            width: generator.log_between(0.03, 0.15),
            envelope: generator.log_between(0.2, 0.6),
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
        let across = (t - self.bend * u * u) / self.width;
        (-across * across - (u * u + v * v) / (self.envelope * self.envelope)).exp()
    }

    pub(super) fn image(&self, [height, width]: [usize; 2], resolution: Resolution) -> Image {
        let [along_u, along_v, along_t] = self.frame.axes;
        // Slices along an axis are as narrow as the slope of the surface at u = e makes them.
        let width_along = |axis: usize| {
            let slope =
                along_t[axis].abs() + 2.0 * (self.bend * self.envelope * along_u[axis]).abs();
            let envelope = along_u[axis].hypot(along_v[axis]) / self.envelope;
            1.0 / ((slope / self.width).powi(2) + envelope * envelope).sqrt()
        };
        let axis = |i, pixels| PanelAxis::uniform(width_along(i), resolution.across, pixels);
        let (depth, panels) = (Gauss::new(resolution.along), panels::count(1.0, width_along(2)));
        panels::image(&axis(0, width), &axis(1, height), |x, y| {
            depth.integrate_panels([0.0, 1.0], panels, |z| self.rate([x, y, z]))
        })
    }
}
