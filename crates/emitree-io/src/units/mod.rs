//! Units of emission rates, lengths and images, by name and at run time.
//!
//! A [`Unit`] is read from text in the grammar of the FITS standard 4.0, section 4.3, as astropy
//! has it too: products by a space, `*`, `.` or `·`, quotients by `/`, powers as `cm-3`, `cm**-3`,
//! `cm^-3` or `cm(-3)`, and a number in front. Dimensions are whole powers of length, mass, time,
//! angle, photons and counts, so that a solid angle is an angle squared, and an image in photons is
//! not one in energies.
//!
//! The names are in one [table], each with its factor to SI and where that comes from. What
//! an image needs on top of conversion is in [`conversion`]: the unit of a line-of-sight integral,
//! rayleighs, photons and energies.
//!
//! ```
//! use emitree_io::units::{Unit, image_unit};
//!
//! let rate = Unit::parse("keV cm-3 s-1 sr-1")?;
//! let (unit, factor) = image_unit(&rate, &Unit::parse("R_E")?)?;
//! assert_eq!(unit.to_string(), "keV cm-2 s-1 sr-1");
//! assert_eq!(factor, 6.371e8);
//!
//! let error = Unit::parse("keV cm-2 sec-1").unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "unit `keV cm-2 sec-1`: unknown name `sec` at character 10: did you mean `s`?"
//! );
//! # Ok::<(), emitree_io::units::UnitError>(())
//! ```

pub mod conversion;
mod dimension;
mod error;
mod magnitude;
mod parser;
pub mod table;
mod unit;

pub use conversion::{band_unit, image_unit};
pub use dimension::Dimension;
pub use error::UnitError;
pub use unit::Unit;

#[cfg(test)]
mod tests;
