//! The provenance of a file: the records of its primary header.

use super::FitsEncodeError;
use super::card::{Card, history_lines, set};
use fits_well::header::{CommentaryName, Header};
use std::time::{SystemTime, UNIX_EPOCH};

/// The provenance in the primary header of any file.
pub(crate) struct Provenance<'a> {
    pub(crate) cards: &'a [Card],
    pub(crate) history: &'a str,
    pub(crate) date: Option<SystemTime>,
}

impl Provenance<'_> {
    /// Adds the software, the date, the cards and the history to `header`.
    pub(crate) fn write(&self, header: &mut Header) -> Result<(), FitsEncodeError> {
        set(header, &Card::new("CREATOR", "emitree", "software that wrote this file"))?;
        let version = env!("CARGO_PKG_VERSION");
        set(header, &Card::new("VERSION", version, "version of the software"))?;
        if let Some(date) = self.date {
            set(header, &Card::new("DATE", utc(date), "when this file was made, UTC"))?;
        }
        for card in self.cards {
            let keyword = &card.keyword;
            let taken = || FitsEncodeError::Taken { keyword: keyword.clone() };
            if STRUCTURE.contains(&&**keyword) || keyword.starts_with("NAXIS") {
                return Err(taken());
            }
            let source = |source| FitsEncodeError::Card { keyword: keyword.clone(), source };
            if header.contains(&**keyword).map_err(source)? {
                return Err(taken());
            }
            set(header, card)?;
        }
        for line in history_lines(self.history) {
            header.push_commentary(CommentaryName::HISTORY, &line)?;
        }
        Ok(())
    }
}

/// Keywords that the encoder writes itself and would drop from a header given to it.
const STRUCTURE: [&str; 12] = [
    "SIMPLE", "XTENSION", "BITPIX", "PCOUNT", "GCOUNT", "GROUPS", "EXTEND", "BSCALE", "BZERO",
    "BLANK", "CHECKSUM", "DATASUM",
];

/// The time as FITS writes it, `2026-11-21T02:30:00`, whole seconds of UTC; times before 1970 are
/// that year's first second.
fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let (mut year, mut day) = (1970, days);
    let leap =
        |year: u64| year.is_multiple_of(4) && !year.is_multiple_of(100) || year.is_multiple_of(400);
    while day >= 365 + u64::from(leap(year)) {
        day -= 365 + u64::from(leap(year));
        year += 1;
    }
    let february = 28 + u64::from(leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{:02}T{hour:02}:{minute:02}:{second:02}", day + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn dates_follow_the_calendar() {
        for (seconds, expected) in [
            (0, "1970-01-01T00:00:00"),
            (951_782_399, "2000-02-28T23:59:59"),
            (951_782_400, "2000-02-29T00:00:00"),
            (1_798_761_599, "2026-12-31T23:59:59"),
            (4_107_542_400, "2100-03-01T00:00:00"),
        ] {
            assert_eq!(utc(UNIX_EPOCH + Duration::from_secs(seconds)), expected);
        }
    }
}
