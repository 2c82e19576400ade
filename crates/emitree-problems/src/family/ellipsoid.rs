//! A rotated Gaussian with three widths.

use super::Resolution;
use super::frame::Frame;
use super::generator::Generator;
use crate::means;
use crate::panels::{self, PanelAxis};
use emitree::Image;

/// exp(−Σ (tᵢ/wᵢ)²), tᵢ the coordinates along three axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipsoid {
    frame: Frame,
    widths: [f64; 3],
}

impl Ellipsoid {
    pub(super) fn draw(generator: &mut Generator) -> Self {
        Self::draw_within(generator, [[0.02, 0.5]; 3])
    }

    /// Each width is between the two given for it.
    pub(super) fn draw_within(generator: &mut Generator, widths: [[f64; 2]; 3]) -> Self {
        let frame = Frame::draw(generator);
        Self { frame, widths: widths.map(|[from, to]| generator.log_between(from, to)) }
    }

    pub(super) fn moved(self, by: [f64; 3]) -> Self {
        Self { frame: self.frame.moved(by), ..self }
    }

    pub(super) fn length(&self) -> f64 {
        self.widths.iter().copied().fold(f64::INFINITY, f64::min)
    }

    pub(super) fn rate(&self, position: [f64; 3]) -> f64 {
        let local = self.frame.local_from_canonical(position);
        let square: f64 = (0..3).map(|i| (local[i] / self.widths[i]).powi(2)).sum();
        (-square).exp()
    }

    /// Closed along z: with d = r − centre and g = exp(−dᵀ M d), completing the square leaves
    /// exp(−m (z − z₀)²), m the element zz of M, times a Gaussian of x and y.
    pub(super) fn image(&self, [height, width]: [usize; 2], resolution: Resolution) -> Image {
        let matrix = |i: usize, j: usize| -> f64 {
            let axes = self.frame.axes.iter().zip(&self.widths);
            axes.map(|(axis, width)| axis[i] * axis[j] / (width * width)).sum()
        };
        let [cx, cy, cz] = self.frame.centre;
        let (xx, xy, yy) = (matrix(0, 0), matrix(0, 1), matrix(1, 1));
        let (xz, yz, zz) = (matrix(0, 2), matrix(1, 2), matrix(2, 2));
        let line = |x: f64, y: f64| {
            let (dx, dy) = (x - cx, y - cy);
            let lean = (xz * dx + yz * dy) / zz;
            let square = xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy - zz * lean * lean;
            (-square).exp() * means::gaussian(zz, cz - lean, 0.0, 1.0)
        };
        // A slice along an axis is a Gaussian of this width.
        let axis = |square: f64, pixels| {
            PanelAxis::uniform(1.0 / square.sqrt(), resolution.across, pixels)
        };
        panels::image(&axis(xx, width), &axis(yy, height), line)
    }
}
