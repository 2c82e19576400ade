//! Dates as FITS writes them, and as modified Julian dates.

use serde::{Deserialize, Serialize};

/// A time in UTC.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SkyDate {
    /// As FITS writes it: `2024-04-08T18:00:00`, with any number of decimals, or the day alone.
    pub text: String,
    /// The same as a modified Julian date \[d\].
    pub mjd: f64,
}

impl SkyDate {
    /// Reads `2024-04-08`, `2024-04-08T18:00` or `2024-04-08T18:00:00.25`, with a space instead of the
    /// `T` and with a `Z` at the end, too. `None` if it is no such date.
    ///
    /// ```
    /// use emitree_io::SkyDate;
    ///
    /// let date = SkyDate::parse("2024-04-08 18:00Z").unwrap();
    /// assert_eq!((date.text.as_str(), date.mjd), ("2024-04-08T18:00:00", 60408.75));
    /// assert_eq!(SkyDate::parse("2023-02-29"), None);
    /// ```
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.strip_suffix(['Z', 'z']).unwrap_or(text);
        let (day, time) = match text.split_once(['T', 't', ' ']) {
            Some((day, time)) => (day, Some(time)),
            None => (text, None),
        };
        let [year, month, of_month] = split(day, '-')?;
        let [year, month, of_month] = [digits(year, 4)?, digits(month, 2)?, digits(of_month, 2)?];
        let is_leap = year % 4 == 0 && year % 100 != 0 || year % 400 == 0;
        let longest = match month {
            4 | 6 | 9 | 11 => 30,
            2 => 28 + i64::from(is_leap),
            1..=12 => 31,
            _ => return None,
        };
        if !(1..=longest).contains(&of_month) {
            return None;
        }
        let midnight = days(year, month, of_month);
        let Some(time) = time else {
            return Some(Self { text: day.to_owned(), mjd: whole(midnight) });
        };
        let with_seconds =
            if time.matches(':').count() == 1 { format!("{time}:00") } else { time.to_owned() };
        let [hour, minute, second] = split(&with_seconds, ':')?;
        let (seconds, decimals) = second.split_once('.').unwrap_or((second, "0"));
        if decimals.is_empty() || !decimals.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        let [hour, minute, _] = [digits(hour, 2)?, digits(minute, 2)?, digits(seconds, 2)?];
        let second: f64 = second.parse().ok()?;
        // A minute with a leap second has 61.
        if hour > 23 || minute > 59 || second >= 61.0 {
            return None;
        }
        let of_day = whole(60 * (60 * hour + minute)) + second;
        Some(Self {
            text: format!("{day}T{with_seconds}"),
            mjd: whole(midnight) + of_day / 86_400.0,
        })
    }
}

/// Three parts of a text.
fn split(text: &str, at: char) -> Option<[&str; 3]> {
    let parts: Vec<&str> = text.split(at).collect();
    parts.try_into().ok()
}

/// A number of so many digits.
fn digits(text: &str, count: usize) -> Option<i64> {
    let is_number = text.len() == count && text.bytes().all(|byte| byte.is_ascii_digit());
    if is_number { text.parse().ok() } else { None }
}

/// The modified Julian date of a day of the Gregorian calendar at midnight.
///
/// Fliegel & Van Flandern 1968 (doi:10.1145/364096.364097), with years that begin in March.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let of_years = 365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    of_years + (153 * month + 2) / 5 + day - 678_882
}

#[expect(clippy::cast_precision_loss, reason = "days of four-digit years, and seconds of a day")]
fn whole(number: i64) -> f64 {
    number as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_become_modified_julian_dates() {
        for (text, mjd) in [
            ("1858-11-17", 0.0),
            ("1970-01-01", 40_587.0),
            ("2000-01-01T12:00:00", 51_544.5),
            ("2000-02-29", 51_603.0),
            ("2000-03-01T06:00", 51_604.25),
            ("2024-04-08T18:00:00.000", 60_408.75),
            ("2016-12-31T23:59:60.500", 57_753.0 + 86_400.5 / 86_400.0),
        ] {
            assert_eq!(SkyDate::parse(text).map(|date| date.mjd), Some(mjd), "{text}");
        }
        let date = SkyDate::parse("2024-04-08t18:00:00.250z").unwrap();
        assert_eq!(date.text, "2024-04-08T18:00:00.250");
    }

    #[test]
    fn what_is_no_date_is_refused() {
        for wrong in [
            "",
            "2024",
            "2024-4-8",
            "2024-13-01",
            "2024-00-01",
            "2023-02-29",
            "1900-02-29",
            "2024-04-31",
            "2024-04-08T24:00:00",
            "2024-04-08T18:60:00",
            "2024-04-08T18:00:61",
            "2024-04-08T18:00:00.",
            "2024-04-08T18:00:00+01:00",
            "2024-04-08T18",
            "8 April 2024",
            "+024-04-08",
        ] {
            assert_eq!(SkyDate::parse(wrong), None, "{wrong}");
        }
    }
}
