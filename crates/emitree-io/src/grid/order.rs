//! The order of an array's axes, and the names of axes.

use emitree_models::grid::Coordinates;
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
/// assert_eq!("phi, theta, r".parse::<ArrayOrder>()?.to_string(), "phi theta r");
/// assert!("xyy".parse::<ArrayOrder>().is_err());
/// # Ok::<(), emitree_io::grid::NotAnOrder>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ArrayOrder {
    coordinates: Coordinates,
    axes: [usize; 3],
}

impl ArrayOrder {
    /// `array[z, y, x]`: the default.
    pub const ZYX: Self = Self { coordinates: Coordinates::Cartesian, axes: [2, 1, 0] };
    /// `array[x, y, z]`.
    pub const XYZ: Self = Self { coordinates: Coordinates::Cartesian, axes: [0, 1, 2] };

    /// The first axis last, as in `array[z, y, x]` and `array[phi, theta, r]`: the default of these coordinates.
    pub(super) fn reversed(coordinates: Coordinates) -> Self {
        Self { coordinates, axes: [2, 1, 0] }
    }

    /// The coordinates along the axes.
    pub fn coordinates(self) -> Coordinates {
        self.coordinates
    }

    /// The place among the array's axes of the axis x (0), y (1) or z (2), or of the other coordinates.
    pub(super) fn place_of(self, axis: usize) -> usize {
        self.axes.iter().position(|&other| other == axis).unwrap_or_default()
    }

    /// The order of axes with these names, if each of the axes of these coordinates is there.
    pub(super) fn from_names<T: AsRef<str>>(coordinates: Coordinates, names: &[T]) -> Option<Self> {
        let axis = |name: &T| {
            let name = name.as_ref().to_lowercase();
            (0..3).find(|&axis| names_of(coordinates, axis).contains(&name.as_str()))
        };
        let axes: Vec<usize> = names.iter().map(axis).collect::<Option<_>>()?;
        let axes: [usize; 3] = axes.try_into().ok()?;
        (0..3).all(|axis| axes.contains(&axis)).then_some(Self { coordinates, axes })
    }
}

/// The names that an axis of these coordinates has in files, its own first, in lower case.
pub(super) fn names_of(coordinates: Coordinates, axis: usize) -> &'static [&'static str] {
    match coordinates.names()[axis] {
        "x" => &["x"],
        "y" => &["y"],
        "z" => &["z"],
        "rho" => &["rho"],
        "r" => &["r", "radius"],
        "theta" => &["theta", "colatitude", "colat", "latitude", "lat"],
        _ => &["phi", "azimuth", "longitude", "lon"],
    }
}

/// Whether an axis of this name has latitudes.
pub(super) fn is_latitude(name: &str) -> bool {
    ["latitude", "lat"].iter().any(|latitude| name.eq_ignore_ascii_case(latitude))
}

/// A text that is no order of the axes of any coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected the names of the three axes in the order of the array's, as in \"zyx\" or \"phi theta r\""
)]
pub struct NotAnOrder;

impl FromStr for ArrayOrder {
    type Err = NotAnOrder;

    fn from_str(text: &str) -> Result<Self, NotAnOrder> {
        let is_separator = |c: char| c == ',' || c.is_whitespace();
        let mut names: Vec<String> =
            text.split(is_separator).filter(|name| !name.is_empty()).map(str::to_owned).collect();
        if let [letters] = names.as_slice() {
            names = letters.chars().map(String::from).collect();
        }
        let order = |coordinates| Self::from_names(coordinates, &names);
        Coordinates::ALL.into_iter().find_map(order).ok_or(NotAnOrder)
    }
}

impl fmt::Display for ArrayOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.axes.map(|axis| self.coordinates.names()[axis]);
        let between = if self.coordinates == Coordinates::Cartesian { "" } else { " " };
        f.write_str(&names.join(between))
    }
}
