//! Peaks: one rotated, anisotropic Gaussian that is narrow along one axis, on a broad one and a background.
//!
//! Neither way of method `vol` is at its best here: the ridge lies across all axes of the view, so that
//! the rank is high, and it is so small that most lines miss it.

use super::component::Component;
use super::ellipsoid::Ellipsoid;
use super::generator::Generator;
use super::{Kind, RandomScene};

/// Seeds of peaks are those of streams from here on, none of which [`super::random_scene`] is drawn from.
const FIRST_STREAM: u64 = 1 << 32;
/// The widths of the narrow Gaussian along its axes, at which it has fallen to 1/e.
const NARROW: [[f64; 2]; 3] = [[0.02, 0.04], [0.07, 0.15], [0.15, 0.3]];
/// Those of the broad one…
const BROAD: [[f64; 2]; 3] = [[0.3, 0.6]; 3];
/// …and its amplitude next to 1 for the narrow one.
const BROAD_AMPLITUDE: f64 = 0.3;
/// The amplitude of the background.
const BACKGROUND: [f64; 2] = [0.01, 0.05];

/// The peak of a seed: exp(−Σ (tᵢ/wᵢ)²) + 0.3 exp(−Σ (sᵢ/vᵢ)²) + b, t and s coordinates along rotated axes
/// from two places, w from 0.02 × 0.07 × 0.15 to 0.04 × 0.15 × 0.3, v from 0.3 to 0.6, b from 0.01 to 0.05.
///
/// ```
/// use emitree_problems::family::random_peak;
///
/// let scene = random_peak(1);
/// assert_eq!(scene.name(), "peak-1");
/// assert!(scene.rate([0.0; 3]) > 0.01 && scene.shortest_length() < 0.04);
/// ```
pub fn random_peak(seed: u64) -> RandomScene {
    let mut generator = Generator::new(FIRST_STREAM + seed);
    let narrow = Ellipsoid::draw_within(&mut generator, NARROW);
    let broad = Ellipsoid::draw_within(&mut generator, BROAD);
    let [from, to] = BACKGROUND;
    let parts = vec![
        (1.0, Component::Ellipsoid(narrow)),
        (BROAD_AMPLITUDE, Component::Ellipsoid(broad)),
        (generator.between(from, to), Component::Constant),
    ];
    RandomScene { seed, kind: Kind::Peak, parts }
}
