//! Problems with an energy axis, and their exact spectral cubes.
//!
//! | name | g | exact by |
//! | --- | --- | --- |
//! | `separable` | eq. (8) of the paper times one power law | closed forms |
//! | `mixture` | three Gaussians: two continua and a line, 2 % of the band wide | closed forms |
//! | `narrow-line` | the same with a line 0.2 % of the band wide | closed forms |
//! | `edge` | two Gaussians whose spectra jump at an energy | closed forms |
//! | `bremsstrahlung` | a β model with a temperature gradient | quadrature |
//! | `ena-ring` | charge exchange in a tilted ring of ions | quadrature |
//! | `doppler` | a rotating disc, its line shifted by the velocity | quadrature |
//!
//! Each voxel is the mean of ∫ g dz over a pixel and an energy bin, g being a rate per unit of energy.

pub mod bremsstrahlung;
#[cfg(test)]
mod checks;
pub mod doppler;
pub mod edge;
pub mod ena_ring;
pub mod jumps;
mod local;
pub mod mixture;
pub mod mixtures;
pub mod parts;
mod ring;
pub mod separable;
pub mod skies;
pub mod spectrum;

use emitree::energy::EnergyError;
use emitree::{Cube, EnergyAxis, EnergyScale};
use parts::Part;

/// A bound on the error of cubes from closed forms alone: rounding.
const CLOSED_FORM: f64 = 1e-13;

type Rate = Box<dyn Fn([f64; 3], f64) -> f64 + Send + Sync>;
type Exact = Box<dyn Fn([usize; 2], &EnergyAxis) -> Cube + Send + Sync>;

/// An emission on the unit cube and its exact spectral cube in the canonical projection.
pub struct CubeProblem {
    /// What it is called in tables.
    pub name: &'static str,
    /// Whether g is smooth: without jumps.
    pub smooth: bool,
    /// A bound on the largest error of a voxel of the exact cube, relative to the largest voxel.
    pub cube_error: f64,
    band: [f64; 2],
    scale: EnergyScale,
    rate: Rate,
    exact: Exact,
}

impl CubeProblem {
    /// The emission rate at a point of the unit cube, per unit of energy.
    pub fn rate(&self, position: [f64; 3], energy: f64) -> f64 {
        (self.rate)(position, energy)
    }

    /// The exact cube of `shape` = \[height, width\] pixels and the bins of `axis`, any part of the
    /// energies of [`default_axis`](Self::default_axis) on any scale.
    pub fn exact(&self, shape: [usize; 2], axis: &EnergyAxis) -> Cube {
        (self.exact)(shape, axis)
    }

    /// The energies that the problem is meant for, in `bins` bins.
    ///
    /// # Errors
    ///
    /// [`EnergyError::Bins`]: no bins or more than 65 536.
    pub fn default_axis(&self, bins: usize) -> Result<EnergyAxis, EnergyError> {
        EnergyAxis::new(self.band[0], self.band[1], bins, self.scale)
    }

    fn closed(
        name: &'static str,
        (band, scale): ([f64; 2], EnergyScale),
        parts: impl Into<Vec<Part>>,
    ) -> Self {
        let parts = parts.into();
        let same = parts.clone();
        Self {
            name,
            smooth: true,
            cube_error: CLOSED_FORM,
            band,
            scale,
            rate: Box::new(move |position, energy| parts::rate(&parts, position, energy)),
            exact: Box::new(move |shape, axis| parts::exact(&same, shape, axis)),
        }
    }

    fn new(
        name: &'static str,
        (band, scale, cube_error): ([f64; 2], EnergyScale, f64),
        rate: fn([f64; 3], f64) -> f64,
        exact: fn([usize; 2], &EnergyAxis) -> Cube,
    ) -> Self {
        let (rate, exact) = (Box::new(rate), Box::new(exact));
        Self { name, smooth: true, cube_error, band, scale, rate, exact }
    }
}

impl core::fmt::Debug for CubeProblem {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("CubeProblem")
            .field("name", &self.name)
            .field("smooth", &self.smooth)
            .field("cube_error", &self.cube_error)
            .field("band", &self.band)
            .field("scale", &self.scale)
            .finish_non_exhaustive()
    }
}

/// All problems of the [table](self).
///
/// ```
/// use emitree_problems::cubes::problems;
///
/// for problem in problems() {
///     let axis = problem.default_axis(3)?;
///     let cube = problem.exact([4, 2], &axis);
///     assert_eq!(cube.shape(), [3, 4, 2]);
///     assert!(cube.largest() > 0.0, "{} is dark", problem.name);
/// }
/// # Ok::<(), emitree::energy::EnergyError>(())
/// ```
pub fn problems() -> Vec<CubeProblem> {
    let (linear, log) = (EnergyScale::Linear, EnergyScale::Log);
    let band_width = mixture::BAND[1] - mixture::BAND[0];
    vec![
        CubeProblem::new(
            "separable",
            (separable::BAND, log, CLOSED_FORM),
            separable::rate,
            separable::exact,
        ),
        CubeProblem::closed("mixture", (mixture::BAND, linear), mixture::parts(0.02 * band_width)),
        CubeProblem::closed(
            "narrow-line",
            (mixture::BAND, linear),
            mixture::parts(0.002 * band_width),
        ),
        CubeProblem {
            smooth: false,
            ..CubeProblem::closed("edge", (edge::BAND, log), edge::parts())
        },
        CubeProblem::new(
            "bremsstrahlung",
            (bremsstrahlung::BAND, log, bremsstrahlung::CUBE_ERROR),
            bremsstrahlung::rate,
            bremsstrahlung::exact,
        ),
        CubeProblem::new(
            "ena-ring",
            (ena_ring::BAND, log, ena_ring::CUBE_ERROR),
            ena_ring::rate,
            ena_ring::exact,
        ),
        CubeProblem::new(
            "doppler",
            (doppler::BAND, linear, doppler::CUBE_ERROR),
            doppler::rate,
            doppler::exact,
        ),
    ]
}

/// The problem of this name, if there is one.
///
/// ```
/// use emitree_problems::cubes::problem;
///
/// assert!(!problem("edge").unwrap().smooth);
/// assert!(problem("shock").is_none());
/// ```
pub fn problem(name: &str) -> Option<CubeProblem> {
    problems().into_iter().find(|problem| problem.name == name)
}

#[cfg(test)]
mod tests;
