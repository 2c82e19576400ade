//! Brute force for the tests: pixels by tensor Gauss–Legendre quadrature of the rate alone.

use crate::gauss::Gauss;

/// The steps of [`check_line_integrals`].
const STEPS: u32 = 4000;

/// Compares the integrals over the depths of 20 lines, `integral(line)`, with midpoint sums of
/// `rate([x, y, z])` up to where it is NaN. The rule is wrong by at most a step for each of `crossings`
/// of a surface, at which the rate jumps by no more than `most`.
pub(crate) fn check_line_integrals(
    name: &str,
    rate: impl Fn([f64; 3]) -> f64,
    integral: impl Fn([f64; 2]) -> f64,
    crossings: f64,
    most: f64,
) {
    for k in 0..20 {
        let line = [f64::from(k) / 20.0, f64::from(k * 7 % 20) / 20.0];
        let z = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
        let rates = (0..STEPS).map(|i| rate([line[0], line[1], z(i)]));
        let sum: f64 = rates.take_while(|rate| !rate.is_nan()).sum();
        let difference = (sum / f64::from(STEPS) - integral(line)).abs();
        assert!(difference < crossings * most / f64::from(STEPS), "{name} {line:?}: {difference}");
    }
}

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
