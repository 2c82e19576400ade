//! [`Coordinates`]: what the three axes of a grid are.

use core::f64::consts::TAU;

/// How far an angle may be from a pole or a full turn to be one \[rad\]: numbers of 32 bits in degrees are.
pub(super) const ANGLE_ROUNDING: f64 = 1e-5;

/// The coordinates along the axes of a grid, from a position (x, y, z) in the world. Lengths are in the
/// length unit of the scene and angles in radians.
///
/// ```
/// use emitree_models::grid::Coordinates;
///
/// assert_eq!(Coordinates::Spherical.names(), ["r", "theta", "phi"]);
/// let [r, theta, phi] = Coordinates::Spherical.of([0.0, 2.0, 0.0]);
/// assert_eq!([r, theta.to_degrees(), phi.to_degrees()], [2.0, 90.0, 90.0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Coordinates {
    /// x, y and z.
    #[default]
    Cartesian,
    /// ρ = √(x² + y²), the azimuth φ from the x axis towards the y axis, and z.
    Cylindrical,
    /// r = √(x² + y² + z²), the colatitude θ from the z axis, 0 to π, and the azimuth φ from the x
    /// axis towards the y axis.
    Spherical,
}

impl Coordinates {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Cartesian, Self::Cylindrical, Self::Spherical];

    /// The names of the three axes, in the order of nodes and shapes.
    pub fn names(self) -> [&'static str; 3] {
        match self {
            Self::Cartesian => ["x", "y", "z"],
            Self::Cylindrical => ["rho", "phi", "z"],
            Self::Spherical => ["r", "theta", "phi"],
        }
    }

    /// Which of the axes are angles.
    pub fn are_angles(self) -> [bool; 3] {
        self.names().map(|name| matches!(name, "theta" | "phi"))
    }

    /// The coordinates of a position, φ from −π to π.
    pub fn of(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let in_plane = x * x + y * y;
        match self {
            Self::Cartesian => [x, y, z],
            Self::Cylindrical => [in_plane.sqrt(), y.atan2(x), z],
            Self::Spherical => [(in_plane + z * z).sqrt(), in_plane.sqrt().atan2(z), y.atan2(x)],
        }
    }

    /// The place of φ among the axes.
    pub(super) fn azimuth(self) -> Option<usize> {
        self.names().iter().position(|&name| name == "phi")
    }

    /// The axis at an end of which all azimuths meet, and which of its coordinates do so: θ at both
    /// poles, ρ on the z axis.
    pub(super) fn meeting(self) -> Option<(usize, &'static [f64])> {
        match self {
            Self::Cartesian => None,
            Self::Cylindrical => Some((0, &[0.0])),
            Self::Spherical => Some((1, &[0.0, core::f64::consts::PI])),
        }
    }
}

/// An azimuth between −π and π in the turn that starts at `first`, which is between −π and π too.
#[inline(always)]
pub(super) fn in_turn_from(first: f64, azimuth: f64) -> f64 {
    if azimuth < first { azimuth + TAU } else { azimuth }
}
