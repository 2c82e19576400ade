//! [`Coordinates`]: what the three axes of a grid are.

use crate::elementary::atan2;
use core::f64::consts::TAU;
use multiversion::multiversion;

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
    #[inline(always)]
    pub fn of(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let in_plane = x * x + y * y;
        match self {
            Self::Cartesian => [x, y, z],
            Self::Cylindrical => [in_plane.sqrt(), atan2(y, x), z],
            Self::Spherical => [(in_plane + z * z).sqrt(), atan2(in_plane.sqrt(), z), atan2(y, x)],
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

/// The coordinates of many positions, those of each in the three columns, with φ in the turn that starts at `first`.
///
/// The same bits as of one position after the other, in vector instructions.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn of_all(
    coordinates: Coordinates,
    first: f64,
    positions: &[[f64; 3]],
    columns: [&mut [f64]; 3],
) {
    match coordinates {
        Coordinates::Cartesian => fill(positions, columns, |position| position),
        Coordinates::Cylindrical => fill(positions, columns, |position| {
            let [rho, phi, z] = Coordinates::Cylindrical.of(position);
            [rho, in_turn_from(first, phi), z]
        }),
        Coordinates::Spherical => fill(positions, columns, |position| {
            let [r, theta, phi] = Coordinates::Spherical.of(position);
            [r, theta, in_turn_from(first, phi)]
        }),
    }
}

#[inline(always)]
fn fill(
    positions: &[[f64; 3]],
    [a, b, c]: [&mut [f64]; 3],
    coordinates_of: impl Fn([f64; 3]) -> [f64; 3],
) {
    for (((&position, a), b), c) in positions.iter().zip(a).zip(b).zip(c) {
        [*a, *b, *c] = coordinates_of(position);
    }
}

/// An azimuth between −π and π in the turn that starts at `first`, which is between −π and π too.
#[inline(always)]
pub(super) fn in_turn_from(first: f64, azimuth: f64) -> f64 {
    if azimuth < first { azimuth + TAU } else { azimuth }
}
