//! eˣ = 2ⁿ eʳ with n = x/ln 2, rounded, and |r| ≤ ln 2 / 2.

use super::ROUNDER;
use super::logarithm::LN_2;
use core::f64::consts::LOG2_E;

/// (eʳ − 1 − r)/r² in powers of r, to 3.4·10⁻¹⁹ of eʳ (`tests/reference/elementary.py`).
const TAIL: [f64; 11] = [
    0.5,
    0.166_666_666_666_666_7,
    0.041_666_666_666_666_67,
    0.008_333_333_333_326_141,
    0.001_388_888_888_888_375_2,
    0.000_198_412_698_748_006_94,
    2.480_158_732_553_351e-5,
    2.755_725_542_549_107e-6,
    2.755_727_366_116_628e-7,
    2.510_520_648_025_936_5e-8,
    2.091_467_945_249_519_3e-9,
];

/// eˣ of all numbers, within 0.8 units in the last place.
#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    // -0 and not 0: the compiler may leave it out.
    exp_of_sum(x, -0.0)
}

/// e^(x + low), where |low| is below 2⁻²⁰ of |x|.
#[inline(always)]
pub(super) fn exp_of_sum(x: f64, low: f64) -> f64 {
    // Beyond these it is ∞ or 0 anyway; a NaN stays.
    let low = if x.abs() < 800.0 { low } else { -0.0 };
    let x = if x > 800.0 { 800.0 } else { x };
    let x = if x < -800.0 { -800.0 } else { x };
    let shifted = x * LOG2_E + ROUNDER;
    let n = shifted - ROUNDER;
    let r = ((x - n * LN_2[0]) - n * LN_2[1]) + low;
    let square = r * r;
    // Even and odd powers apart: two short chains instead of a long one.
    let even = TAIL[8] + square * TAIL[10];
    let even = TAIL[4] + square * (TAIL[6] + square * even);
    let even = TAIL[0] + square * (TAIL[2] + square * even);
    let odd = TAIL[5] + square * (TAIL[7] + square * TAIL[9]);
    let odd = TAIL[1] + square * (TAIL[3] + square * odd);
    let mantissa = 1.0 + (r + square * (even + r * odd));
    // In two steps, since 2ⁿ itself may be no normal number. The lowest bits of `shifted` are n.
    let bits = shifted.to_bits();
    let half = bits >> 1;
    mantissa * power_of_two(half) * power_of_two(bits.wrapping_sub(half))
}

/// 2ⁿ from the lowest bits of n.
#[inline(always)]
fn power_of_two(n: u64) -> f64 {
    f64::from_bits(n.wrapping_add(1023) << 52)
}
