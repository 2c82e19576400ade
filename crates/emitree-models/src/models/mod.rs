//! The published models: one file each, and what they share.
//!
//! To add one, write its file with a description (the table of its parameters is all that scenes
//! need to know of it) and name it in the [catalogue](mod@crate::catalogue).

mod cmem;
mod holmstrom;
mod jorgensen;
mod lin;
mod magnetosheath;
mod shue;
mod solar_wind;
mod sun_angles;

pub use cmem::Cmem;
pub use holmstrom::Holmstrom;
pub use jorgensen::Jorgensen;

pub(crate) use cmem::DESCRIPTION as CMEM;
pub(crate) use holmstrom::DESCRIPTION as HOLMSTROM;
pub(crate) use jorgensen::DESCRIPTION as JORGENSEN;

use emitree::Samples;

/// Writes `g` at every position to `rates`, for models that shine alike in all directions.
fn fill_rates(samples: &Samples<'_>, rates: &mut [f64], g: impl Fn([f64; 3]) -> f64) {
    for (rate, &position) in rates.iter_mut().zip(samples.positions()) {
        *rate = g(position);
    }
}
