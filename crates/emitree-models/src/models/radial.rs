//! Distances from a centre, and the parameters of models that are made of them.

use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::scalar::Scalar;
use multiversion::multiversion;

pub(super) const AMPLITUDE: ParameterDescription = ParameterDescription {
    name: "amplitude",
    unit: "1",
    default: ParameterDefault::Value(1.0),
    meaning: "scale of the rate",
    range: AcceptedRange::NonNegative,
};
pub(super) const CENTRE_X: ParameterDescription = ParameterDescription {
    name: "centre_x",
    unit: "1",
    default: ParameterDefault::Value(0.0),
    meaning: "x of the centre, in the length unit of the scene",
    range: AcceptedRange::Finite,
};
pub(super) const CENTRE_Y: ParameterDescription = ParameterDescription {
    name: "centre_y",
    meaning: "y of the centre, in the length unit of the scene",
    ..CENTRE_X
};
pub(super) const CENTRE_Z: ParameterDescription = ParameterDescription {
    name: "centre_z",
    meaning: "z of the centre, in the length unit of the scene",
    ..CENTRE_X
};

/// The values of [`CENTRE_X`], [`CENTRE_Y`] and [`CENTRE_Z`].
pub(super) fn centre<T: Scalar>(values: &Values<T>) -> [T; 3] {
    [CENTRE_X, CENTRE_Y, CENTRE_Z].map(|parameter| values.of(parameter.name))
}

/// r of a position about the origin.
pub(super) fn radius([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// The distance of a position from a centre.
#[inline(always)]
pub(super) fn distance<T: Scalar>(position: [f64; 3], centre: [T; 3]) -> T {
    let [x, y, z] = [0, 1, 2].map(|axis| T::of(position[axis]) - centre[axis]);
    (x * x + y * y + z * z).sqrt()
}

/// The distances of all positions from a centre.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn distances<T: Scalar>(positions: &[[f64; 3]], centre: [T; 3], distances: &mut [T]) {
    for (found, &position) in distances.iter_mut().zip(positions) {
        *found = distance(position, centre);
    }
}
