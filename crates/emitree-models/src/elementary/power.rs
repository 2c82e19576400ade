//! xʸ = e^(y ln x) for x ≥ 0, with the logarithm in two doubles: an error of ln x is multiplied by up
//! to 700.
//!
//! ln(1 + f) = ⅔ s (3 + s² + r) with s = f/(2 + f), each factor in two parts, the first of so few bits
//! that their product is exact: the scheme of Sun's fdlibm (2004), with a polynomial of our own.

use super::exponential::exp_of_sum;
use super::logarithm::{LN_2, split};

/// ⅔ in two parts, the first of 21 bits.
const TWO_THIRDS: [f64; 2] = [0.666_666_507_720_947_3, 1.589_457_194_010_416_6e-7];

/// r/s⁴ in powers of s² up to s = (√2 − 1)/(√2 + 1), to 6.3·10⁻²¹ of the logarithm
/// (`tests/reference/elementary.py`).
const TAIL: [f64; 8] = [
    0.6,
    0.428_571_428_571_440_5,
    0.333_333_333_324_843_4,
    0.272_727_275_029_739_54,
    0.230_768_924_560_919_13,
    0.200_022_063_710_052_57,
    0.175_593_724_453_607_27,
    0.175_845_803_699_974_2,
];

/// The largest exponent that is taken here; beyond it nearly all powers are 0 or ∞.
const LARGEST_EXPONENT: f64 = 1e20;

/// Whether [`pow`] computes this power; all others are special cases of the standard.
#[inline(always)]
pub(super) fn is_ordinary(x: f64, y: f64) -> bool {
    // −0 is above all of them.
    (x.to_bits() < f64::INFINITY.to_bits()) & (y.abs() < LARGEST_EXPONENT)
}

/// xʸ where it [is ordinary](is_ordinary), within 1 unit in the last place.
#[inline(always)]
pub(super) fn pow(x: f64, y: f64) -> f64 {
    let [high, low] = ln(x);
    let y_high = short(y);
    let value = exp_of_sum(y_high * high, (y - y_high) * high + y * low);
    if x > 0.0 { value } else { power_of_zero(y) }
}

#[inline(always)]
fn power_of_zero(y: f64) -> f64 {
    let not_negative = if y > 0.0 { 0.0 } else { 1.0 };
    if y < 0.0 { f64::INFINITY } else { not_negative }
}

/// ln x in two parts, the first of 21 bits.
#[inline(always)]
fn ln(x: f64) -> [f64; 2] {
    let (k, f) = split(x);
    // s = f/(2 + f), and 2 + f has more bits than a double.
    let below = 2.0 + f;
    let below_high = short(below);
    let below_low = f - (below_high - 2.0);
    let inverse = 1.0 / below;
    let s = f * inverse;
    let s_high = short(s);
    let s_low = ((f - s_high * below_high) - s_high * below_low) * inverse;

    let square = s * s;
    let fourth = square * square;
    let even = TAIL[0] + fourth * (TAIL[2] + fourth * (TAIL[4] + fourth * TAIL[6]));
    let odd = TAIL[1] + fourth * (TAIL[3] + fourth * (TAIL[5] + fourth * TAIL[7]));
    // s² less the square of its first part goes with the rest.
    let square_high = s_high * s_high;
    let rest = fourth * (even + square * odd) + s_low * (s_high + s);
    let factor = 3.0 + square_high + rest;
    let factor_high = short(factor);
    let factor_low = rest - ((factor_high - 3.0) - square_high);

    let (product, remainder) = (s_high * factor_high, s_low * factor_high + factor_low * s);
    let product_high = short(product + remainder);
    let product_low = remainder - (product_high - product);
    let fraction = TWO_THIRDS[0] * product_high;
    let fraction_low = TWO_THIRDS[1] * product_high + product_low * (TWO_THIRDS[0] + TWO_THIRDS[1]);

    let whole = k * LN_2[0];
    let small = k * LN_2[1] + fraction_low;
    let high = short((fraction + small) + whole);
    [high, small - ((high - whole) - fraction)]
}

/// The first 21 bits.
#[inline(always)]
fn short(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !u64::from(u32::MAX))
}
