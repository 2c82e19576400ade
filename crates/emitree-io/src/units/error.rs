//! Units that can't be read or converted.

use super::Dimension;

/// A unit that is not one, or that measures another quantity than the one needed.
///
/// ```
/// use emitree_io::units::Unit;
///
/// let [length, time] = [Unit::parse("km")?, Unit::parse("h")?];
/// assert_eq!(
///     length.factor_to(&time).unwrap_err().to_string(),
///     "no conversion from `km` (length) to `h` (time): expected units of the same dimension"
/// );
/// # Ok::<(), emitree_io::units::UnitError>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UnitError {
    /// A name that is in no table.
    #[error(
        "unit `{text}`: unknown name `{name}` at character {position}: {}",
        suggestion.as_ref().map_or_else(
            || "expected a unit such as cm, R_E, s, sr, ph, keV or R".to_owned(),
            |known| format!("did you mean `{known}`?"),
        )
    )]
    UnknownName {
        /// The unit as it was written.
        text: String,
        /// Where the name starts, the first character being 1.
        position: usize,
        /// The name.
        name: String,
        /// A similar name that is known.
        suggestion: Option<String>,
    },
    /// Text that does not follow the grammar.
    #[error("unit `{text}`: {found} at character {position}: expected {expected}")]
    Syntax {
        /// The unit as it was written.
        text: String,
        /// Where it goes wrong, the first character being 1.
        position: usize,
        /// What is there.
        found: String,
        /// What would be accepted there.
        expected: &'static str,
    },
    /// A conversion between different kinds of quantities.
    #[error(
        "no conversion from `{from}` ({from_dimension}) to `{to}` ({to_dimension}): \
         expected {expected}"
    )]
    Incompatible {
        /// The unit converted from.
        from: String,
        /// What it measures.
        from_dimension: Dimension,
        /// The unit converted to.
        to: String,
        /// What that one measures.
        to_dimension: Dimension,
        /// What was expected.
        expected: &'static str,
    },
    /// A length unit was needed, and this measures something else.
    #[error("unit `{unit}` is of {dimension}: expected a length")]
    NotALength {
        /// The unit.
        unit: String,
        /// What it measures.
        dimension: Dimension,
    },
    /// A unit of energy was needed, and this measures something else.
    #[error("unit `{unit}` is of {dimension}: expected an energy")]
    NotAnEnergy {
        /// The unit.
        unit: String,
        /// What it measures.
        dimension: Dimension,
    },
    /// A factor of zero or infinity as a 64-bit float.
    #[error("the factor from `{from}` to `{to}` is {factor:e}: expected one from 1e-300 to 1e300")]
    OutOfRange {
        /// The unit converted from.
        from: String,
        /// The unit converted to.
        to: String,
        /// The factor.
        factor: f64,
    },
    /// A photon without a positive, finite energy.
    #[error("a photon energy of {0} J: expected a positive, finite number")]
    PhotonEnergy(f64),
}
