//! Brute force for the tests: pixels by tensor Gauss–Legendre quadrature of the rate alone.

use crate::gauss::Gauss;

/// The mean of ∫ rate dz over pixel \[row, column\] of `shape`: `across` nodes along each side of
/// the pixel, 40 panels of 10 nodes along z.
pub(crate) fn pixel(
    rate: impl Fn([f64; 3]) -> f64,
    shape: [usize; 2],
    at: [usize; 2],
    across: usize,
) -> f64 {
    let depth = Gauss::new(10);
    mean(shape, at, &Gauss::new(across), |x, y| {
        depth.integrate_panels([0.0, 1.0], 40, |z| rate([x, y, z]))
    })
}

/// The mean of `line(x, y)` over pixel \[row, column\] of `shape`.
pub(crate) fn mean(
    [height, width]: [usize; 2],
    [row, column]: [usize; 2],
    rule: &Gauss,
    line: impl Fn(f64, f64) -> f64,
) -> f64 {
    let (rows, columns) = (height as f64, width as f64);
    let (y, x) = (row as f64, column as f64);
    let integral = rule.integrate(y / rows, (y + 1.0) / rows, |at| {
        rule.integrate(x / columns, (x + 1.0) / columns, |x_at| line(x_at, at))
    });
    integral * rows * columns
}
