//! Distances from a centre, and the parameters of models that are made of them.

use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
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
pub(super) fn centre(values: &Values) -> [f64; 3] {
    [CENTRE_X, CENTRE_Y, CENTRE_Z].map(|parameter| values.of(parameter.name))
}

/// r of a position about the origin.
pub(super) fn radius([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// The distance of a position from a centre.
pub(super) fn distance(position: [f64; 3], centre: [f64; 3]) -> f64 {
    radius([0, 1, 2].map(|axis| position[axis] - centre[axis]))
}

/// The distances of all positions from a centre.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn distances(positions: &[[f64; 3]], centre: [f64; 3], distances: &mut [f64]) {
    for (distance, position) in distances.iter_mut().zip(positions) {
        let [x, y, z] = [0, 1, 2].map(|axis| position[axis] - centre[axis]);
        *distance = (x * x + y * y + z * z).sqrt();
    }
}
