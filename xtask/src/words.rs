//! `cargo xtask words`: words of a former private vocabulary, which the texts no longer use.
//!
//! Whole words are matched, in any case, and phrases also across underscores, hyphens and the line
//! breaks of comments: `first_look` and "first look" are the same. A hit is reported with its place and
//! the term to write instead, as docs/glossary.md defines it.

use crate::workspace::Workspace;
use std::fmt;

/// A word or a phrase, lower case, and the standard term.
struct Word {
    /// Words with single spaces between them.
    text: &'static str,
    better: &'static str,
    reason: &'static str,
}

const fn word(text: &'static str, better: &'static str, reason: &'static str) -> Word {
    Word { text, better, reason }
}

const COST: &str = "the number of evaluations (and the estimated error)";
const EXPENSIVE: &str = "expensive";
const MET: &str = "tolerance met, or guarantee";
const LOW_RANK: &str = "low-rank (Tucker cross) approximation";
const PROBE: &str = "spectral probe, probe point";
const ISOTROPIC: &str = "isotropic, or uniform";
const OBSERVER: &str = "point observer";
const CUSTOM: &str = "custom projection";
const TOLERANCE: &str = "the tolerance";
const CALLED: &str = "is called with, receives";
const INDEPENDENT: &str = "is independent of";

const METAPHOR: &str = "a metaphor";
const COINED: &str = "not a term of the field";
const PERSONIFIED: &str = "code samples, stores and fits";
const ARCHAIC: &str = "not in use in this meaning";
const RENAMED: &str = "renamed";

const WORDS: &[Word] = &[
    word("bill", COST, METAPHOR),
    word("bills", COST, METAPHOR),
    word("dear", EXPENSIVE, ARCHAIC),
    word("dearer", "more expensive", ARCHAIC),
    word("dearest", "most expensive", ARCHAIC),
    word("promise", MET, "an estimate promises nothing"),
    word("promised", MET, "an estimate promises nothing"),
    word("promises", MET, "an estimate promises nothing"),
    word("sum of few", LOW_RANK, COINED),
    word("sums of few", LOW_RANK, COINED),
    word("know all of it", LOW_RANK, PERSONIFIED),
    word("first look", "initial sampling", PERSONIFIED),
    word("first looks", "initial samplings", PERSONIFIED),
    word("glance", "spot check", METAPHOR),
    word("glances", "spot checks", METAPHOR),
    word("scout", PROBE, METAPHOR),
    word("scouts", PROBE, METAPHOR),
    word("clan", "block of cousins", METAPHOR),
    word("clans", "blocks of cousins", METAPHOR),
    word("alike in all directions", ISOTROPIC, COINED),
    word("directions alike", ISOTROPIC, COINED),
    word("shine alike", ISOTROPIC, COINED),
    word("shines alike", ISOTROPIC, COINED),
    word("an eye", OBSERVER, METAPHOR),
    word("from eye", OBSERVER, METAPHOR),
    word("optics of", CUSTOM, COINED),
    word("of one's own", "custom", ARCHAIC),
    word("idle pessimism", "needlessly conservative", METAPHOR),
    word("own time", "overhead", COINED),
    word("images on the way", "intermediate images", COINED),
    word("equal steps", "uniform steps", COINED),
    word("right to the right", "x to the right", "unclear"),
    word("up up", "y up", "unclear"),
    word("parting", "split distance", METAPHOR),
    word("error asked for", TOLERANCE, PERSONIFIED),
    word("error that is asked for", TOLERANCE, PERSONIFIED),
    word("error that was asked for", TOLERANCE, PERSONIFIED),
    word("all it was asked for", "the stopping criterion was met", PERSONIFIED),
    word("all that it was asked for", "the stopping criterion was met", PERSONIFIED),
    word("all that was asked for", "the stopping criterion was met", PERSONIFIED),
    word("hears", CALLED, PERSONIFIED),
    word("hear of", CALLED, PERSONIFIED),
    word("knows nothing", INDEPENDENT, PERSONIFIED),
    word("knows neither", INDEPENDENT, PERSONIFIED),
    word("know nothing", INDEPENDENT, PERSONIFIED),
    word("tree knows", "the tree contains", PERSONIFIED),
    word("told a tolerance", "with a tolerance", PERSONIFIED),
    word("way of the data", "the order in which data pass", COINED),
    word("hopeless", "NotSeparable", "not the reason"),
    word("optimism", "SAFETY_FACTOR", "not the meaning"),
    word("too dear", "OVERRUN_FACTOR", ARCHAIC),
    word("deepestlevel", "MaxLevel", RENAMED),
    word("evaluations of pixels", "evaluations_per_pixel", RENAMED),
];

/// Where a word has to stay.
struct Exception {
    /// The path from the root.
    file: &'static str,
    word: &'static str,
    reason: &'static str,
}

const EXCEPTIONS: &[Exception] = &[
    Exception { file: "CHANGELOG.md", word: "sum of few", reason: "history" },
    Exception { file: "CHANGELOG.md", word: "evaluations of pixels", reason: "history" },
    Exception { file: "CHANGELOG.md", word: "deepestlevel", reason: "history" },
    Exception {
        file: "python/src/emitree/_result.py",
        word: "evaluations of pixels",
        reason: "the former name, for programs that use it",
    },
    Exception {
        file: "python/tests/test_render.py",
        word: "evaluations of pixels",
        reason: "the former name, for programs that use it",
    },
];

/// This file has the words as data.
const TABLE: &str = "xtask/src/words.rs";

const ENDINGS: [&str; 5] = ["*.rs", "*.md", "*.py", "*.pyi", "*.toml"];

/// Fails if a file of the repository has a word of the table, or if an exception has become needless.
pub(crate) fn run(workspace: &Workspace) -> Result<(), String> {
    let mut command = workspace.command("git");
    command.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard", "--"]);
    let listed =
        command.args(ENDINGS).output().map_err(|error| format!("git ls-files: {error}"))?;
    if !listed.status.success() {
        return Err(format!("git ls-files ended with {}", listed.status));
    }
    let files =
        String::from_utf8(listed.stdout).map_err(|error| format!("git ls-files: {error}"))?;
    let (mut hits, mut excepted) = (Vec::new(), vec![false; EXCEPTIONS.len()]);
    for file in files.split_terminator('\0').filter(|&file| file != TABLE) {
        // A file that was deleted is still listed until that is committed.
        let Ok(text) = std::fs::read_to_string(workspace.path(file)) else { continue };
        for hit in hits_in(file, &text) {
            let is_of = |e: &Exception| e.file == hit.file && e.word == hit.word.text;
            match EXCEPTIONS.iter().position(is_of) {
                Some(number) => excepted[number] = true,
                None => hits.push(hit.to_string()),
            }
        }
    }
    let needless = EXCEPTIONS.iter().zip(excepted).filter(|(_, is_used)| !is_used);
    hits.extend(needless.map(|(Exception { file, word, reason }, _)| {
        format!("{TABLE}: the exception of `{word}` in {file} ({reason}) is not needed any more")
    }));
    for line in &hits {
        eprintln!("{line}");
    }
    if hits.is_empty() { Ok(()) } else { Err(format!("{} words to replace", hits.len())) }
}

/// A word of the table in a file.
struct Hit<'a> {
    file: &'a str,
    /// From 1.
    line: usize,
    word: &'static Word,
}

impl fmt::Display for Hit<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, word: Word { text, better, reason } } = self;
        write!(f, "{file}:{line}: {text} → {better} ({reason})")
    }
}

/// The words of the table in a text, in the order of their lines.
fn hits_in<'a>(file: &'a str, text: &str) -> Vec<Hit<'a>> {
    let tokens = tokens(text);
    let phrases: Vec<(&Word, Vec<&str>)> =
        WORDS.iter().map(|word| (word, word.text.split([' ', '\'']).collect())).collect();
    let mut hits = Vec::new();
    for (at, first) in tokens.iter().enumerate() {
        for (word, phrase) in phrases.iter().filter(|(_, phrase)| phrase[0] == first.text) {
            let rest = tokens[at + 1..].iter().take(phrase.len() - 1);
            let is_same =
                |(token, &expected): (&Token, &&str)| token.follows && token.text == expected;
            if rest.len() == phrase.len() - 1 && rest.zip(&phrase[1..]).all(is_same) {
                hits.push(Hit { file, line: first.line, word });
            }
        }
    }
    hits
}

/// A run of letters and digits.
struct Token {
    /// Lower case.
    text: String,
    /// From 1.
    line: usize,
    /// Whether nothing ends a phrase between the token before and this one.
    follows: bool,
}

fn tokens(text: &str) -> Vec<Token> {
    let (mut tokens, mut line, mut follows) = (Vec::<Token>::new(), 1, false);
    let mut is_inside = false;
    for c in text.chars() {
        if c.is_alphanumeric() {
            if !is_inside {
                tokens.push(Token { text: String::new(), line, follows });
                (is_inside, follows) = (true, true);
            }
            if let Some(token) = tokens.last_mut() {
                token.text.extend(c.to_lowercase());
            }
            continue;
        }
        is_inside = false;
        line += usize::from(c == '\n');
        // Blanks, the marks of comments, and what joins the parts of a name.
        follows &= c.is_whitespace() || "/!#>_-'’\\".contains(c);
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::{EXCEPTIONS, WORDS, hits_in};

    fn lines(text: &str) -> Vec<String> {
        hits_in("a.rs", text).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_planted_word_is_found_with_its_place() {
        assert_eq!(
            lines("//! Its cost.\n/// A Dear g.\n"),
            ["a.rs:2: dear → expensive (not in use in this meaning)"]
        );
    }

    #[test]
    fn phrases_are_found_in_names_and_across_line_breaks() {
        for text in ["first_look(2)", "FIRST_LOOK", "a first-look", "the first\n    /// look at g"]
        {
            assert_eq!(lines(text).len(), 1, "{text}");
        }
        assert_eq!(lines("an optics of one's own").len(), 2);
    }

    #[test]
    fn parts_of_words_and_of_sentences_are_not() {
        for text in ["endear billion Clancy", "first, look", "the first. Look", "deepest level"] {
            assert_eq!(lines(text), [""; 0], "{text}");
        }
        assert_eq!(lines("StopReason::DeepestLevel").len(), 1);
    }

    #[test]
    fn the_table_is_in_lower_case_and_its_exceptions_are_of_its_words() {
        for word in WORDS {
            assert_eq!(word.text, word.text.to_lowercase());
            assert!(!word.better.is_empty() && !word.reason.is_empty(), "{}", word.text);
        }
        for exception in EXCEPTIONS {
            assert!(WORDS.iter().any(|word| word.text == exception.word), "{}", exception.word);
        }
    }
}
