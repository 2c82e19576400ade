//! Messages of a length that can be read, whatever the length of a scene's lines.

use core::ops::Range;

/// The longest line of a scene that is shown as it is, in bytes.
const LONGEST_LINE: usize = 240;
/// What is shown of a longer one before the marked text, in bytes.
const BEFORE: usize = 80;
/// The longest message, in bytes; it may quote what the scene has.
const LONGEST_MESSAGE: usize = 600;
const CUT: &str = "…";

/// The text with parts of long lines left out, and where the marked part is in it; lines stay lines.
/// The column of what is marked counts from where the shown part of its line begins.
pub(super) fn excerpt(text: &str, span: Range<usize>) -> (String, Range<usize>) {
    if text.lines().all(|line| line.len() <= LONGEST_LINE) {
        return (text.to_owned(), span);
    }
    let mut shown = String::new();
    let mut places = [span.start, span.end];
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let end = at + line.len();
        let [mut from, mut to] = [at, end];
        if line.len() > LONGEST_LINE {
            let is_marked = span.start < end && span.end > at;
            if is_marked {
                from = text.floor_char_boundary(span.start.saturating_sub(BEFORE).max(at));
            }
            to = text.ceil_char_boundary((from + LONGEST_LINE).min(end));
        }
        if from > at {
            shown.push_str(CUT);
        }
        for (place, marked) in places.iter_mut().zip([span.start, span.end]) {
            if (at..=end).contains(&marked) {
                *place = shown.len() + marked.clamp(from, to) - from;
            }
        }
        shown.push_str(&text[from..to]);
        if to < end {
            shown.push_str(CUT);
            if line.ends_with('\n') {
                shown.push('\n');
            }
        }
        at = end;
    }
    (shown, places[0]..places[1].max(places[0]))
}

/// A message with its middle left out if it is long.
pub(super) fn shortened(message: String) -> String {
    if message.len() <= LONGEST_MESSAGE {
        return message;
    }
    let half = LONGEST_MESSAGE / 2;
    let start = &message[..message.floor_char_boundary(half)];
    let end = &message[message.ceil_char_boundary(message.len() - half)..];
    format!("{start} {CUT} {end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_lines_are_shown_as_they_are() {
        let text = "one\ntwo\n";
        assert_eq!(excerpt(text, 4..7), (text.to_owned(), 4..7));
        assert_eq!(shortened("short".to_owned()), "short");
    }

    #[test]
    fn what_is_marked_in_a_long_line_is_shown() {
        let long = "ä".repeat(5000);
        let text = format!("first\n{long}wrong{long}\n{long}\nlast");
        let start = text.find("wrong").unwrap();
        let (shown, span) = excerpt(&text, start..start + 5);
        assert_eq!(&shown[span.clone()], "wrong");
        assert_eq!(shown.lines().count(), 4);
        assert!(shown.starts_with("first\n…ä") && shown.ends_with("…\nlast"), "{shown}");
        assert!(shown.len() < 3 * LONGEST_LINE, "{}", shown.len());
        // Marked from its start to beyond what is shown.
        let (shown, span) = excerpt(&text, 6..start + 5);
        assert!(shown[span].chars().all(|letter| letter == 'ä'));
        // At the very end.
        let (shown, span) = excerpt(&text, text.len()..text.len());
        assert_eq!(span, shown.len()..shown.len());
    }

    #[test]
    fn long_messages_keep_their_ends() {
        let text = shortened(format!("unknown name `{}`: expected x", "é".repeat(100_000)));
        assert!(text.len() < 2 * LONGEST_MESSAGE);
        assert!(text.starts_with("unknown name `é") && text.ends_with("é`: expected x"));
    }
}
