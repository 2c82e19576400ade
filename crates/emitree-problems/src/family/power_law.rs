//! A power-law core: as the β model, of any whole power.

use super::Resolution;
use super::frame;
use super::generator::Generator;
use crate::beta_model::BetaModel;
use emitree::Image;

/// (1 + r²/a²)^(−p/2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Core(BetaModel);

impl Core {
    pub(super) fn draw(generator: &mut Generator) -> Self {
        Self(BetaModel {
            centre: frame::centre(generator),
            core_radius: generator.log_between(0.02, 0.2),
            six_beta: [2, 3, 4, 5, 6][generator.whole(0..=4) as usize],
        })
    }

    pub(super) fn moved(self, by: [f64; 3]) -> Self {
        let centre = core::array::from_fn(|i| self.0.centre[i] + by[i]);
        Self(BetaModel { centre, ..self.0 })
    }

    pub(super) fn length(&self) -> f64 {
        self.0.core_radius
    }

    pub(super) fn rate(&self, position: [f64; 3]) -> f64 {
        self.0.rate(position)
    }

    pub(super) fn image(&self, shape: [usize; 2], resolution: Resolution) -> Image {
        self.0.image(shape, resolution.across)
    }
}
