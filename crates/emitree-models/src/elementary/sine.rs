//! sin and cos from one polynomial: the angle less a multiple of π, and the parity of that.

use super::ROUNDER;
use core::f64::consts::FRAC_1_PI;

/// The largest angle that is reduced here: what π in 127 bits leaves of it has all its bits, however
/// near it is to a multiple of π.
pub(super) const LARGEST_ANGLE: f64 = 1e5;

/// π in three parts; the first two have 37 bits, so that halves of them times 16 bits are exact.
const PI: [f64; 3] =
    [3.141_592_653_584_666_6, 5.126_688_303_167_911_6e-12, 2.112_599_813_397_485_5e-23];

/// (sin r − r)/r³ in powers of r² up to r = π/2, to 8.6·10⁻¹⁹ of sin r
/// (`tests/reference/elementary.py`).
const TAIL: [f64; 8] = [
    -0.166_666_666_666_666_66,
    0.008_333_333_333_333_201,
    -0.000_198_412_698_412_124_9,
    2.755_731_921_194_555e-6,
    -2.505_210_696_837_646_4e-8,
    1.605_894_542_054_429_4e-10,
    -7.643_159_373_354_255e-13,
    2.723_103_749_541_231e-15,
];

/// sin x for |x| up to [`LARGEST_ANGLE`], or NaN: within 1.6 units in the last place.
#[inline(always)]
pub(super) fn sin(x: f64) -> f64 {
    // Of |x|, so that the sign of 0 is kept.
    let shifted = x.abs() * FRAC_1_PI + ROUNDER;
    let reduced = sine_of_remainder(x.abs(), shifted - ROUNDER);
    let sign = x.to_bits() & SIGN;
    f64::from_bits(reduced.to_bits() ^ (shifted.to_bits() << 63) ^ sign)
}

/// cos x for |x| up to [`LARGEST_ANGLE`], or NaN: −(−1)ⁿ sin(x − (n + ½)π), within 1.6 units in the
/// last place.
#[inline(always)]
pub(super) fn cos(x: f64) -> f64 {
    let shifted = (x.abs() * FRAC_1_PI - 0.5) + ROUNDER;
    let reduced = sine_of_remainder(x.abs(), (shifted - ROUNDER) + 0.5);
    f64::from_bits(reduced.to_bits() ^ (shifted.to_bits() << 63) ^ SIGN)
}

const SIGN: u64 = 1 << 63;

/// sin(x − nπ) where that angle is at most π/2.
#[inline(always)]
fn sine_of_remainder(x: f64, n: f64) -> f64 {
    let r = ((x - n * PI[0]) - n * PI[1]) - n * PI[2];
    let square = r * r;
    let fourth = square * square;
    // Even and odd powers of r² apart: two short chains instead of a long one.
    let even = TAIL[0] + fourth * (TAIL[2] + fourth * (TAIL[4] + fourth * TAIL[6]));
    let odd = TAIL[1] + fourth * (TAIL[3] + fourth * (TAIL[5] + fourth * TAIL[7]));
    r + r * square * (even + square * odd)
}
