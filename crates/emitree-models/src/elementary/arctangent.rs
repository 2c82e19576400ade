//! The angle of a point of the plane: the ratio of its coordinates, or that of their difference and sum, whichever
//! is an angle below π/8, and one polynomial for both.

/// (atan t − t)/t³ in powers of t² up to t = tan π/8, to 6.6·10⁻¹⁸ of the angle
/// (`tests/reference/elementary.py`).
const TAIL: [f64; 11] = [
    -0.333_333_333_333_333_3,
    0.199_999_999_999_955_2,
    -0.142_857_142_846_665_26,
    0.111_111_110_152_549_75,
    -0.090_909_045_780_675_68,
    0.076_921_831_895_173_67,
    -0.066_645_114_289_473_03,
    0.058_581_487_526_600_855,
    -0.050_854_488_999_189_21,
    0.039_231_634_085_502_22,
    -0.019_176_857_469_608_11,
];

/// tan π/8.
const TAN_PI_8: f64 = 0.414_213_562_373_095_03;

/// π/4 in two parts; the first has 51 bits, so that multiples of it up to 4 are exact.
const PI_4: [f64; 2] = [core::f64::consts::FRAC_PI_4, 3.061_616_997_868_383e-17];

/// The angle of the point (x, y) from the x axis, with the sign of y, within 2 units in the last place; NaN where
/// a coordinate is NaN or both are infinite. Coordinates are below half of the largest number.
#[inline(always)]
pub(super) fn atan2(y: f64, x: f64) -> f64 {
    let (across, along) = (y.abs(), x.abs());
    let is_beyond_diagonal = across > along;
    let (small, large) = if is_beyond_diagonal { (along, across) } else { (across, along) };
    // Between π/8 and π/4 the angle from the diagonal.
    let is_near_diagonal = small > TAN_PI_8 * large;
    let of_point = if is_near_diagonal { small - large } else { small };
    let length = if is_near_diagonal { small + large } else { large };
    // At the origin the angle is 0.
    let t = of_point / if length <= 0.0 { 1.0 } else { length };
    let square = t * t;
    let fourth = square * square;
    let even = TAIL[0]
        + fourth
            * (TAIL[2]
                + fourth * (TAIL[4] + fourth * (TAIL[6] + fourth * (TAIL[8] + fourth * TAIL[10]))));
    let odd =
        TAIL[1] + fourth * (TAIL[3] + fourth * (TAIL[5] + fourth * (TAIL[7] + fourth * TAIL[9])));
    let angle = t + t * square * (even + square * odd);
    // Less by reflections in the diagonal and in the y axis from multiples of π/4.
    let eighths = if is_near_diagonal { 1.0 } else { 0.0 };
    let (eighths, angle) =
        if is_beyond_diagonal { (2.0 - eighths, -angle) } else { (eighths, angle) };
    let (eighths, angle) =
        if x.is_sign_negative() { (4.0 - eighths, -angle) } else { (eighths, angle) };
    (eighths * PI_4[0] + (eighths * PI_4[1] + angle)).copysign(y)
}
