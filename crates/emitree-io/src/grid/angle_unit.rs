//! The unit of angles in files and scenes.

use std::f64::consts::TAU;
use std::fmt;

/// A unit of angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AngleUnit {
    /// Degrees.
    Degrees,
    /// Radians.
    Radians,
}

impl AngleUnit {
    /// The units by the names that scenes have for them.
    pub const NAMES: [(&'static str, Self); 2] = [("deg", Self::Degrees), ("rad", Self::Radians)];

    /// The unit in an attribute of a file, such as `degrees_north`.
    ///
    /// ```
    /// use emitree_io::grid::AngleUnit;
    ///
    /// assert_eq!(AngleUnit::from_attribute("degrees_north"), Some(AngleUnit::Degrees));
    /// assert_eq!(AngleUnit::from_attribute("radian"), Some(AngleUnit::Radians));
    /// assert_eq!(AngleUnit::from_attribute("km"), None);
    /// ```
    pub fn from_attribute(text: &str) -> Option<Self> {
        let text = text.trim().to_lowercase();
        match text.split('_').next() {
            Some("deg" | "degree" | "degrees" | "°") => Some(Self::Degrees),
            Some("rad" | "radian" | "radians") => Some(Self::Radians),
            _ => None,
        }
    }

    /// A full turn.
    pub(super) fn turn(self) -> f64 {
        match self {
            Self::Degrees => 360.0,
            Self::Radians => TAU,
        }
    }
}

impl fmt::Display for AngleUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Degrees => "deg",
            Self::Radians => "rad",
        })
    }
}
