//! Standing waves in three oblique directions, under a smooth envelope.

use super::Resolution;
use super::frame::Frame;
use super::generator::Generator;
use crate::gauss::Gauss;
use crate::panels::{self, PanelAxis};
use core::f64::consts::TAU;
use emitree::Image;

/// (1 + s)/2 exp(−r²/w²), where s is the product or the mean of sin(kᵢ tᵢ + φᵢ), tᵢ the coordinates
/// along three axes: between 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wave {
    frame: Frame,
    wave_numbers: [f64; 3],
    phases: [f64; 3],
    product: bool,
    width: f64,
}

impl Wave {
    pub(super) fn draw(generator: &mut Generator) -> Self {
        Self {
            frame: Frame::draw(generator),
            wave_numbers: core::array::from_fn(|_| generator.log_between(3.0, 25.0)),
            phases: core::array::from_fn(|_| generator.between(0.0, TAU)),
            product: generator.whole(0..=1) == 1,
            width: generator.log_between(0.2, 0.8),
        }
    }

    pub(super) fn moved(self, by: [f64; 3]) -> Self {
        Self { frame: self.frame.moved(by), ..self }
    }

    pub(super) fn length(&self) -> f64 {
        self.wave_numbers.iter().fold(self.width, |length, k| length.min(1.0 / k))
    }

    pub(super) fn rate(&self, position: [f64; 3]) -> f64 {
        let local = self.frame.local_from_canonical(position);
        let sine = |i: usize| (self.wave_numbers[i] * local[i] + self.phases[i]).sin();
        let sines = [sine(0), sine(1), sine(2)];
        let wave = if self.product {
            sines[0] * sines[1] * sines[2]
        } else {
            (sines[0] + sines[1] + sines[2]) / 3.0
        };
        let square: f64 = local.iter().map(|t| t * t).sum();
        0.5 * (1.0 + wave) * (-square / (self.width * self.width)).exp()
    }

    pub(super) fn image(&self, [height, width]: [usize; 2], resolution: Resolution) -> Image {
        // The largest wave number along a canonical axis; a panel of 12 radians needs as many nodes
        // as one of 4 widths of a Gaussian, and where both meet their numbers add.
        let width_along = |axis: usize| {
            let waves = (0..3).map(|i| (self.wave_numbers[i] * self.frame.axes[i][axis]).abs());
            let waves: Vec<f64> = waves.collect();
            let number = if self.product {
                waves.iter().sum::<f64>()
            } else {
                waves.iter().copied().fold(0.0, f64::max)
            };
            1.0 / (1.0 / self.width + number / 3.0)
        };
        let axis = |i, pixels| PanelAxis::uniform(width_along(i), resolution.across, pixels);
        let (depth, panels) = (Gauss::new(resolution.along), panels::count(1.0, width_along(2)));
        panels::image(&axis(0, width), &axis(1, height), |x, y| {
            depth.integrate_panels([0.0, 1.0], panels, |z| self.rate([x, y, z]))
        })
    }
}
