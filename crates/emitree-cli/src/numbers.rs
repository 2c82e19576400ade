//! Numbers for people: percentages, times.

use std::time::Duration;

/// A fraction in per cent: "1 %". Without the last digits, which are of the binary number and not
/// of what was written: 0.007 is not 0.7000000000000001 %. Small fractions are themselves: "1e-9".
pub(crate) fn percent(fraction: f64) -> String {
    if fraction != 0.0 && fraction.abs() < 1e-6 {
        return format!("{fraction:e}");
    }
    let percent = 100.0 * fraction;
    let rounded: f64 = format!("{percent:.9e}").parse().unwrap_or(percent);
    format!("{rounded} %")
}

/// A time of a few digits: "13 ms", "2.4 s".
pub(crate) fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        short if short < 0.1 => format!("{:.2} ms", 1e3 * short),
        long => format!("{long:.2} s"),
    }
}

/// A time that is a forecast: "13 ms", "2.4 s", "5 min", "1.5 h".
pub(crate) fn roughly(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 0.1 => format!("{} ms", short(1e3 * s)),
        s if s < 100.0 => format!("{} s", short(s)),
        s if s < 6000.0 => format!("{} min", short(s / 60.0)),
        s => format!("{} h", short(s / 3600.0)),
    }
}

/// A number of two digits: "0.034", "3.4e-6", "120".
pub(crate) fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.1e}").parse().unwrap_or(number);
    match rounded.abs() {
        plain if plain == 0.0 || (1e-3..1e6).contains(&plain) => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forecasts_of_times_have_two_digits() {
        let of = |seconds| roughly(Duration::from_secs_f64(seconds));
        assert_eq!([of(0.00933), of(0.1), of(16.73)], ["9.3 ms", "0.1 s", "17 s"]);
        assert_eq!([of(100.0), of(5999.0), of(5400.0 * 4.0)], ["1.7 min", "100 min", "6 h"]);
        assert_eq!(of(0.0), "0 ms");
    }
}
