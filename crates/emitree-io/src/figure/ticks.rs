//! The positions and labels of the ticks of an axis.

/// Ticks with labels, and the finer ones without.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    pub(super) major: Vec<(f64, String)>,
    pub(super) minor: Vec<f64>,
}

/// Multiples of 1, 2 or 5 times a power of ten, `about` so many between `low` and `high`.
pub(super) fn linear(low: f64, high: f64, about: f64) -> Ticks {
    let raw = (high - low) / about;
    let power = raw.log10().floor();
    let mantissa = raw / exp10(power);
    // Geometric means of neighbours divide the steps evenly.
    let (factor, parts) = match mantissa {
        m if m < f64::sqrt(2.0) => (1.0, 5.0),
        m if m < f64::sqrt(10.0) => (2.0, 4.0),
        m if m < f64::sqrt(50.0) => (5.0, 5.0),
        _ => (10.0, 5.0),
    };
    let step = factor * exp10(power);
    let values = multiples(low, high, step);
    let largest = low.abs().max(high.abs());
    let exponent = largest.log10().floor();
    let step_power = if factor >= 10.0 { power + 1.0 } else { power };
    let label = |value: f64| {
        if value.abs() < 0.5 * step {
            "0".to_owned()
        } else if (-3.0..5.0).contains(&exponent) {
            decimal(value, -step_power)
        } else {
            let mantissa = decimal(value / exp10(exponent), exponent - step_power);
            format!("{mantissa}×{}", power_of_ten(exponent))
        }
    };
    Ticks {
        major: values.map(|value| (value, label(value))).collect(),
        minor: multiples(low, high, step / parts).collect(),
    }
}

/// Powers of ten between `low` and `high`, both positive, and 2 to 9 times them.
pub(super) fn logarithmic(low: f64, high: f64) -> Ticks {
    let (first, last) = (low.log10(), high.log10());
    let inside = |value: &f64| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(value);
    let decades = || multiples(first.floor(), last.ceil(), 1.0);
    // Over many decades only each second, third, … has a tick.
    let every = ((last - first) / 8.0).ceil().max(1.0);
    let plain = low >= 0.9e-3 && high <= 1.1e4;
    let label = |mantissa: f64, power: f64| match (plain, mantissa) {
        (true, _) => decimal(mantissa * exp10(power), -power),
        (false, m) if m < 1.5 => power_of_ten(power),
        (false, _) => format!("{mantissa}×{}", power_of_ten(power)),
    };
    let mantissas: &[f64] = match last - first {
        ..0.8 => &[1.0, 2.0, 3.0, 4.0, 5.0, 7.0],
        ..1.6 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let major: Vec<_> = decades()
        .filter(|power| (power / every).fract().abs() < 1e-9)
        .flat_map(|power| mantissas.iter().map(move |&m| (m * exp10(power), label(m, power))))
        .filter(|(value, _)| inside(value))
        .collect();
    if major.len() < 2 {
        // A short stretch without two round values of its own.
        return linear(low, high, 5.0);
    }
    let minor = if every > 1.0 {
        decades().map(exp10).filter(inside).collect()
    } else {
        let digits = [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        decades().flat_map(|power| digits.map(|m| m * exp10(power))).filter(inside).collect()
    };
    Ticks { major, minor }
}

/// The multiples of `step` from `low` to `high`, ends included whatever the rounding.
fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step - 1e-6).ceil();
    let last = (high / step + 1e-6).floor();
    std::iter::successors(Some(first), |n| Some(n + 1.0))
        .take_while(move |&n| n <= last)
        // Beyond 2⁵³ the next whole number is the same one again.
        .take(1000)
        .map(move |n| n * step)
}

/// 10^`power`, exact for whole powers where f64 is.
fn exp10(power: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, reason = "a power of an f64, at most 308")]
    let power = power as i32;
    if power < 0 { 1.0 / 10.0_f64.powi(-power) } else { 10.0_f64.powi(power) }
}

/// The value with so many digits after the point, none if negative, and a true minus sign.
fn decimal(value: f64, digits: f64) -> String {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few digits, not negative"
    )]
    let digits = digits.max(0.0) as usize;
    format!("{value:.digits$}").replace('-', "−")
}

fn power_of_ten(power: f64) -> String {
    let digits = power.to_string();
    let raised = digits.chars().map(|c| match c {
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        _ => '⁻',
    });
    format!("10{}", raised.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.major.iter().map(|(_, label)| &**label).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(labels(&linear(0.0, 1.0, 5.0)), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&linear(-8.0, 8.0, 5.0)), ["−5", "0", "5"]);
        assert_eq!(labels(&linear(0.0, 3.2e7, 4.0)), ["0", "1×10⁷", "2×10⁷", "3×10⁷"]);
        assert_eq!(
            labels(&linear(0.0, 2e-5, 4.0)),
            ["0", "0.5×10⁻⁵", "1.0×10⁻⁵", "1.5×10⁻⁵", "2.0×10⁻⁵"]
        );
    }

    #[test]
    fn logarithmic_ticks_are_decades() {
        assert_eq!(labels(&logarithmic(100.0, 1e6)), ["10²", "10³", "10⁴", "10⁵", "10⁶"]);
        assert_eq!(labels(&logarithmic(0.001, 1.0)), ["0.001", "0.01", "0.1", "1"]);
        assert_eq!(
            labels(&logarithmic(1e-16, 1.0)),
            ["10⁻¹⁶", "10⁻¹⁴", "10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²", "10⁰"]
        );
        assert_eq!(labels(&logarithmic(1.5, 30.0)), ["2", "5", "10", "20"]);
        assert_eq!(logarithmic(1.0, 10.0).minor.len(), 8);
    }

    #[test]
    fn ticks_lie_inside() {
        for (low, high) in [(0.3, 0.7), (-1e-9, 5e-9), (12.0, 13.5), (1e-12, 1e12)] {
            let mut all = vec![linear(low, high, 6.0)];
            if low > 0.0 {
                all.push(logarithmic(low, high));
            }
            for ticks in all {
                assert!(ticks.major.len() >= 2, "{low} {high} {ticks:?}");
                let slack = 1e-6 * (high - low);
                let values = ticks.major.iter().map(|(v, _)| v).chain(&ticks.minor);
                for &value in values {
                    assert!((low - slack..=high + slack).contains(&value), "{value}");
                }
            }
        }
    }
}
