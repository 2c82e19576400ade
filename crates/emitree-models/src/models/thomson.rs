//! Sunlight scattered by free electrons near the Sun: the coefficients of van de Hulst 1950.

/// The coefficients A to D of van de Hulst 1950 (Bull. Astron. Inst. Neth. 11, 135) at one distance
/// from the Sun's centre. With w = asin(1/r) the Sun's half-width as seen from there, r in `R_sun`,
///
/// A = cos w sin² w,
/// B = −⅛ \[1 − 3 sin² w − (cos² w/sin w)(1 + 3 sin² w) ln((1 + sin w)/cos w)\],
/// C = 4/3 − cos w − ⅓ cos³ w,
/// D = ⅛ \[5 + sin² w − (cos² w/sin w)(5 − sin² w) ln((1 + sin w)/cos w)\]
///
/// All of them tend to a multiple of sin² w far away, where these formulas cancel. Here they are
/// written with T = (atanh(s)/s − 1)/s² for s = sin w, as ln((1 + s)/cos w) = atanh s:
///
/// B = ⅛ s² \[5 − 3s² + cos² w (1 + 3s²) T\], D = ⅛ s² \[7 − s² − cos² w (5 − s²) T\],
/// C = q (2 − q + ⅓ q²) with q = 1 − cos w = s²/(1 + cos w).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VanDeHulst {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
    pub(super) d: f64,
}

impl VanDeHulst {
    /// The coefficients at a distance r ≥ 1 \[`R_sun`\].
    pub(super) fn new(r: f64) -> Self {
        let sin2 = 1.0 / (r * r);
        // 1 − sin² w, without its cancellation at the limb.
        let cos2 = (r - 1.0) / r * ((r + 1.0) / r);
        let cos = cos2.sqrt();
        let cos2_tail = if cos2 > 0.0 { cos2 * tail(r, sin2) } else { 0.0 };
        let q = sin2 / (1.0 + cos);
        Self {
            a: cos * sin2,
            b: 0.125 * sin2 * (5.0 - 3.0 * sin2 + (1.0 + 3.0 * sin2) * cos2_tail),
            c: q * (2.0 - q + q * q / 3.0),
            d: 0.125 * sin2 * (7.0 - sin2 - (5.0 - sin2) * cos2_tail),
        }
    }
}

/// T = (atanh(s)/s − 1)/s² for s = 1/r, r > 1.
fn tail(r: f64, sin2: f64) -> f64 {
    if sin2 < SERIES_LIMIT { tail_series(sin2) } else { tail_closed(r, sin2) }
}

/// Below it, beyond r = 3.2, the series has converged with [`SERIES_TERMS`].
const SERIES_LIMIT: f64 = 0.1;
const SERIES_TERMS: u32 = 16;

/// Σ s²ᵏ/(2k + 3)
fn tail_series(sin2: f64) -> f64 {
    (0..SERIES_TERMS).rev().fold(0.0, |sum, k| sum * sin2 + 1.0 / f64::from(2 * k + 3))
}

/// atanh(1/r) = ½ ln(1 + 2/(r − 1))
fn tail_closed(r: f64, sin2: f64) -> f64 {
    (0.5 * r * (2.0 / (r - 1.0)).ln_1p() - 1.0) / sin2
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE: &str = include_str!("../../tests/reference/van_de_hulst.csv");

    #[test]
    fn agrees_with_the_published_forms_in_fifty_digits() {
        let mut checked = 0;
        for line in REFERENCE.lines().skip(1) {
            let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
            let [r, expected @ ..] = numbers.as_slice() else { panic!("{line}") };
            let at = VanDeHulst::new(*r);
            for (found, expected) in [at.a, at.b, at.c, at.d].into_iter().zip(expected) {
                let error = (found - expected).abs();
                assert!(error <= 4e-15 * expected, "r = {r}: {found:e}, {expected:e}");
            }
            checked += 1;
        }
        assert!(checked >= 25);
    }

    #[test]
    fn both_forms_of_the_tail_agree_where_they_meet() {
        let ratio =
            tail_series(SERIES_LIMIT) / tail_closed(SERIES_LIMIT.sqrt().recip(), SERIES_LIMIT);
        assert!((ratio - 1.0).abs() < 1e-13);
    }

    #[test]
    fn at_the_limb_half_of_the_sky_is_bright() {
        let limb = VanDeHulst::new(1.0);
        assert!(limb.a.abs() <= 0.0 && (limb.b - 0.25).abs() < 1e-15);
        assert!((limb.c - 4.0 / 3.0).abs() < 1e-15 && (limb.d - 0.75).abs() < 1e-15);
    }

    #[test]
    fn a_distant_sun_is_a_point() {
        for r in [1e4, 1e9, 1e150] {
            let at = VanDeHulst::new(r);
            let sin2 = 1.0 / (r * r);
            for (found, limit) in [(at.a, 1.0), (at.b, 2.0 / 3.0), (at.c, 1.0), (at.d, 2.0 / 3.0)] {
                assert!((found / (limit * sin2) - 1.0).abs() < 1e-7, "{r:e}");
            }
        }
    }
}
