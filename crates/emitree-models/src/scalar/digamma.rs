//! The digamma function ψ, the derivative of ln Γ.

/// From here on the asymptotic series has converged with [`SERIES`].
const SERIES_FROM: f64 = 10.0;

/// B₂ₖ/(2k) for k = 1 to 8: the series ψ(x) = ln x − 1/(2x) − Σ B₂ₖ/(2k x²ᵏ), DLMF 5.11.2.
const SERIES: [f64; 8] = [
    1.0 / 12.0,
    -1.0 / 120.0,
    1.0 / 252.0,
    -1.0 / 240.0,
    1.0 / 132.0,
    -691.0 / 32_760.0,
    1.0 / 12.0,
    -3617.0 / 8160.0,
];

/// ψ(x) for x > 0, to a few roundings of ψ(x) and of the largest term 1/x.
pub(crate) fn digamma(x: f64) -> f64 {
    // ψ(x) = ψ(x + 1) − 1/x, DLMF 5.5.2.
    let (mut x, mut below) = (x, 0.0);
    while x < SERIES_FROM {
        below += 1.0 / x;
        x += 1.0;
    }
    let inverse2 = 1.0 / (x * x);
    let series = SERIES.iter().rev().fold(0.0, |sum, term| (sum + term) * inverse2);
    x.ln() - 0.5 / x - series - below
}

#[cfg(test)]
mod tests {
    use super::*;

    /// mpmath.digamma(x) with 30 digits.
    const DIGAMMA: [(f64, f64); 9] = [
        (0.1, -10.423_754_940_411_076),
        (1.0, -0.577_215_664_901_532_9),
        (1.1, -0.423_754_940_411_076_64),
        (2.6, 0.751_047_452_773_476_3),
        (5.0, 1.506_117_668_431_800_5),
        (9.999, 2.251_647_417_205_735_5),
        (10.0, 2.251_752_589_066_721),
        (77.25, 4.340_560_459_718_617),
        (10_001.0, 9.210_390_371_142_85),
    ];

    #[test]
    fn values_of_mpmath() {
        for (x, expected) in DIGAMMA {
            let error = (digamma(x) - expected).abs();
            assert!(error < 1e-15 * (expected.abs() + 1.0 + 1.0 / x), "{x}: {error:e}");
        }
    }
}
