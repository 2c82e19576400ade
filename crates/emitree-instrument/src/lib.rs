//! The response of an X-ray-like camera: from a spectral cube of radiance to counts.
//!
//! [`Instrument::expected_counts`] takes the steps in the order in which they happen, and gives the sum
//! over all pixels at each ([`StepSum`]); [`draw_counts`] then draws whole numbers with a seed:
//!
//! ```
//! use emitree::{Cube, EnergyAxis, EnergyScale, Image};
//! use emitree_instrument::{Background, EffectiveArea, Instrument, Psf, Step, draw_counts};
//!
//! // 10 photons s⁻¹ cm⁻² sr⁻¹ keV⁻¹ in a pixel at two energies, in an image of 9 x 9 pixels.
//! let mut band = Image::zeros(9, 9);
//! band[(4, 4)] = 10.0;
//! let radiance = Cube::from_bands(vec![band.clone(), band]);
//! let energies = EnergyAxis::new(0.5, 1.5, 2, EnergyScale::Linear)?;
//! let solid_angles_sr = Image::from_pixels(9, 9, vec![1e-4; 81]);
//!
//! let camera = Instrument {
//!     area: Some(EffectiveArea::from_points(&[0.2, 2.0], &[50.0, 50.0])?),
//!     redistribution: None,
//!     psf: Some(Psf::gaussian([1.5, 1.5])?),
//!     exposure_s: 1e4,
//!     background: Some(Background::per_pixel(1e-5)?),
//! };
//! let observation = camera.expected_counts(&radiance, &energies, 1.0, &solid_angles_sr)?;
//! for sum in &observation.steps {
//!     assert!(sum.imbalance() < 1e-12, "{sum:?}");
//! }
//! // 10 · 1e-4 sr · 1 keV · 1e4 s · 50 cm², and 1e-5 · 1e4 s · 81 pixels · 2 channels.
//! let after = |step| observation.steps.iter().find(|sum| sum.step == step).map(|sum| sum.after);
//! assert!((after(Step::Area).unwrap() - 500.0).abs() < 1e-9);
//! assert!((after(Step::Background).unwrap() - 516.2).abs() < 1e-4);
//!
//! let counts = draw_counts(&observation.counts, 1)?;
//! assert!(counts.voxels().all(|count| count.fract() == 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The modules, in the order in which data pass through them:
//!
//! * [`observe`]: the camera, and its expected counts; [`step`]: the sums to check each step by;
//! * [`effective_area`], [`area_table`]: the area against energy, in bins or points; its text files;
//! * [`psf`]: the point-spread function, a Gaussian or an image;
//! * [`redistribution`]: the matrix from energies to channels;
//! * [`background`]: counts that are not the scene's;
//! * [`poisson`]: counts drawn from expected counts;
//! * [`ogip`]: areas and matrices from the FITS files of missions (ARF, RMF, RSP).
//!
//! Energies are in keV, areas in cm², solid angles in sr and times in s. Cubes and images are those of
//! [`emitree`], NaN outside of the field of view.

mod cell;
mod energy_bins;
mod field;
mod units;

pub mod observe;
pub mod step;
pub mod effective_area;
pub mod area_table;
pub mod psf;
pub mod redistribution;
pub mod background;
pub mod poisson;
pub mod ogip;

pub use area_table::{AreaFileDefect, AreaFileError};
pub use background::{Background, BackgroundError};
pub use cell::WrongCell;
pub use effective_area::{AreaError, EffectiveArea};
pub use observe::{Instrument, Observation, ObservationError};
pub use ogip::{ResponseFileDefect, ResponseFileError};
pub use poisson::{PoissonError, draw_counts};
pub use psf::{Blurred, KernelFileDefect, KernelFileError, Psf, PsfError};
pub use redistribution::{
    Channel, FoldedResponse, Group, Redistributed, Redistribution, RedistributionError, ResponseRow,
};
pub use step::{Step, StepSum};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
