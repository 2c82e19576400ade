//! ln x and log₁₀ x from x = 2ᵏ (1 + f) with √½ ≤ 1 + f < √2, and of 1 + f with s = f/(2 + f): the
//! reduction of Sun's fdlibm (K. C. Ng 1993), with a polynomial of our own.

/// ln 2 in two parts; the first has 42 bits, so that integers of 11 bits times it are exact.
pub(super) const LN_2: [f64; 2] = [0.693_147_180_559_890_3, 5.497_923_018_708_371e-14];
/// log₁₀ 2, likewise.
const LOG10_2: [f64; 2] = [0.301_029_995_663_952_83, 2.836_339_455_104_496_4e-14];
/// 1/ln 10 in two parts, the first of 32 bits.
const LOG10_E: [f64; 2] = [0.434_294_481_878_168_9, 2.508_294_671_164_527_5e-11];

/// (ln((1 + s)/(1 − s)) − 2s)/s³ in powers of s² up to s = (√2 − 1)/(√2 + 1), to 4.3·10⁻¹⁸ of the
/// logarithm (`tests/reference/elementary.py`).
const TAIL: [f64; 7] = [
    0.666_666_666_666_667,
    0.399_999_999_998_995_05,
    0.285_714_286_259_760_4,
    0.222_222_111_347_043_9,
    0.181_828_891_318_693_06,
    0.153_317_213_809_210_12,
    0.146_164_523_998_264_4,
];

const SQRT_HALF_BITS: u64 = core::f64::consts::FRAC_1_SQRT_2.to_bits();
const EXPONENT_OF_1: u64 = 1023;
const MANTISSA: u64 = (1 << 52) - 1;
/// 2⁵²: a number below it, written into its lowest bits, is added.
const TWO_52: f64 = 4_503_599_627_370_496.0;
const TWO_54: f64 = 18_014_398_509_481_984.0;

/// The parts of a logarithm.
struct Parts {
    /// The power of two.
    k: f64,
    f: f64,
    /// ln(1 + f) = f − f²/2 + this.
    rest: f64,
}

/// k and f of x = 2ᵏ (1 + f), where x is a positive number.
#[inline(always)]
pub(super) fn split(x: f64) -> (f64, f64) {
    let subnormal = x < f64::MIN_POSITIVE;
    let x = if subnormal { x * TWO_54 } else { x };
    let scale = if subnormal { 54.0 } else { 0.0 };
    let from_sqrt_half = x.to_bits().wrapping_sub(SQRT_HALF_BITS).wrapping_add(EXPONENT_OF_1 << 52);
    let biased = f64::from_bits((from_sqrt_half >> 52) | TWO_52.to_bits());
    let k = biased - (TWO_52 + 1023.0) - scale;
    let f = f64::from_bits((from_sqrt_half & MANTISSA) + SQRT_HALF_BITS) - 1.0;
    (k, f)
}

#[inline(always)]
fn parts(x: f64) -> Parts {
    let (k, f) = split(x);
    let s = f / (2.0 + f);
    let square = s * s;
    let fourth = square * square;
    let even = TAIL[0] + fourth * (TAIL[2] + fourth * (TAIL[4] + fourth * TAIL[6]));
    let odd = TAIL[1] + fourth * (TAIL[3] + fourth * TAIL[5]);
    let tail = square * (even + square * odd);
    Parts { k, f, rest: s * (0.5 * f * f + tail) }
}

/// ln x of all numbers, within 0.9 units in the last place.
#[inline(always)]
pub(super) fn ln(x: f64) -> f64 {
    let Parts { k, f, rest } = parts(x);
    let half_square = 0.5 * f * f;
    let value = k * LN_2[0] - ((half_square - (rest + k * LN_2[1])) - f);
    at_the_borders(x, value)
}

/// log₁₀ x of all numbers, within 0.9 units in the last place, and exact at powers of ten.
#[inline(always)]
pub(super) fn log10(x: f64) -> f64 {
    let Parts { k, f, rest } = parts(x);
    let half_square = 0.5 * f * f;
    // ln(1 + f) in two parts, the first of 21 bits: its product with the first of 1/ln 10 is exact.
    let high = f64::from_bits((f - half_square).to_bits() & !u64::from(u32::MAX));
    let low = ((f - high) - half_square) + rest;
    let (product, whole) = (high * LOG10_E[0], k * LOG10_2[0]);
    let sum = whole + product;
    let below = k * LOG10_2[1] + (low + high) * LOG10_E[1] + low * LOG10_E[0];
    at_the_borders(x, (below + ((whole - sum) + product)) + sum)
}

/// The logarithm where the formula does not hold: of 0, ∞ and what has none.
#[inline(always)]
fn at_the_borders(x: f64, value: f64) -> f64 {
    let value = if x < f64::INFINITY { value } else { x };
    let value = if x > 0.0 { value } else { f64::NAN };
    if x.abs() > 0.0 || x.is_nan() { value } else { f64::NEG_INFINITY }
}
