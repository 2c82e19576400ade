//! Vectors of three components.

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| a[i] - b[i])
}

/// `origin` + `distance` · `direction`.
pub(crate) fn along(origin: [f64; 3], distance: f64, direction: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| origin[i] + distance * direction[i])
}

/// The vector of length 1 along `a`; none if `a` is zero or not finite.
pub(crate) fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(a);
    (length > 0.0 && length.is_finite()).then(|| a.map(|component| component / length))
}

/// The part of `a` across the unit vector `axis`, made a unit vector; none if less than 1e-10 of `a`
/// is across, which leaves no significant digit of its direction.
pub(crate) fn unit_across(a: [f64; 3], axis: [f64; 3]) -> Option<[f64; 3]> {
    let across = along(a, -dot(a, axis), axis);
    if norm(across) <= 1e-10 * norm(a) { None } else { unit(across) }
}
