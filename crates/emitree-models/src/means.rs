//! Means of functions of one variable over an interval, in closed form: exact pixels are products of
//! them.

use core::f64::consts::PI;

/// The mean of exp(−a (t − c)²) over \[`from`, `to`\], from < to; a > 0.
///
/// ```
/// let mean = emitree_models::means::gaussian(1.0, 0.0, -20.0, 20.0);
/// assert!((mean - std::f64::consts::PI.sqrt() / 40.0).abs() < 1e-16);
/// ```
pub fn gaussian(a: f64, c: f64, from: f64, to: f64) -> f64 {
    let root = a.sqrt();
    let (low, high) = (root * (from - c), root * (to - c));
    // Far out on one side, erf is 1 up to rounding and its difference is lost: use erfc there.
    let difference = if low > 0.5 {
        libm::erfc(low) - libm::erfc(high)
    } else if high < -0.5 {
        libm::erfc(-high) - libm::erfc(-low)
    } else {
        libm::erf(high) - libm::erf(low)
    };
    difference * PI.sqrt() / (2.0 * root * (to - from))
}

/// The mean of sin²(k t) over \[`from`, `to`\], from < to; k ≠ 0.
///
/// ```
/// let mean = emitree_models::means::sine_squared(std::f64::consts::PI, 0.0, 1.0);
/// assert!((mean - 0.5).abs() < 1e-15);
/// ```
pub fn sine_squared(k: f64, from: f64, to: f64) -> f64 {
    let primitive = |t: f64| t / 2.0 - (2.0 * k * t).sin() / (4.0 * k);
    (primitive(to) - primitive(from)) / (to - from)
}
