//! The order of an array's axes.

use super::AXES;
use std::fmt;
use std::str::FromStr;

/// The order of an array's axes, the one that varies slowest in a C array first: the order in which
/// `numpy` writes its indices.
///
/// ```
/// use emitree_io::grid::ArrayOrder;
///
/// assert_eq!("zyx".parse(), Ok(ArrayOrder::ZYX)); // array[z, y, x]
/// assert_eq!(ArrayOrder::XYZ.to_string(), "xyz");
/// assert!("xyy".parse::<ArrayOrder>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ArrayOrder([usize; 3]);

impl ArrayOrder {
    /// `array[z, y, x]`: the default.
    pub const ZYX: Self = Self([2, 1, 0]);
    /// `array[x, y, z]`.
    pub const XYZ: Self = Self([0, 1, 2]);

    /// The place among the array's axes of the axis x (0), y (1) or z (2).
    pub(super) fn place_of(self, axis: usize) -> usize {
        self.0.iter().position(|&other| other == axis).unwrap_or_default()
    }

    /// The order of axes with these names, if each of x, y and z is there, in either case.
    pub(super) fn from_names(names: &[String]) -> Option<Self> {
        names.concat().parse().ok().filter(|_| names.len() == 3)
    }
}

/// A text that is no order of x, y and z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected the letters x, y and z in the order of the array's axes, as in \"zyx\"")]
pub struct NotAnOrder;

impl FromStr for ArrayOrder {
    type Err = NotAnOrder;

    fn from_str(text: &str) -> Result<Self, NotAnOrder> {
        let axis = |letter: char| AXES.iter().position(|&axis| letter.eq_ignore_ascii_case(&axis));
        let axes: Vec<usize> = text.chars().map(axis).collect::<Option<_>>().ok_or(NotAnOrder)?;
        let axes: [usize; 3] = axes.try_into().map_err(|_| NotAnOrder)?;
        if (0..3).all(|axis| axes.contains(&axis)) { Ok(Self(axes)) } else { Err(NotAnOrder) }
    }
}

impl fmt::Display for ArrayOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|&axis| write!(f, "{}", AXES[axis]))
    }
}
