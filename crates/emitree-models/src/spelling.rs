//! "Did you mean …?" for names that users misspell.

use strsim::osa_distance;

/// The known name that `name` most likely stands for, if one is close enough.
///
/// Case does not count; otherwise one wrong, missing, extra or swapped letter is forgiven in a name
/// of up to four letters, two in longer ones, and none in a name of one letter, where it would say
/// nothing.
pub(crate) fn closest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    let forgiven = match wanted.chars().count() {
        0 | 1 => 0,
        2..=4 => 1,
        _ => 2,
    };
    known
        .into_iter()
        .map(|candidate| (osa_distance(&wanted, &candidate.to_lowercase()), candidate))
        .filter(|&(edits, _)| edits <= forgiven)
        .min_by_key(|&(edits, _)| edits)
        .map(|(_, candidate)| candidate)
}

/// The part of a message that suggests a name, empty if there is none.
pub(crate) fn did_you_mean(suggestion: Option<&str>) -> String {
    suggestion.map_or_else(String::new, |name| format!(": did you mean `{name}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggests_the_closest_name() {
        let known = ["sin", "sinh", "sqrt", "A1", "density"];
        let suggestion = |name| closest(name, known);
        assert_eq!(suggestion("sni"), Some("sin"));
        assert_eq!(suggestion("sqr"), Some("sqrt"));
        assert_eq!(suggestion("a1"), Some("A1"));
        assert_eq!(suggestion("dnesty"), Some("density"));
        assert_eq!(suggestion("velocity"), None);
    }

    #[test]
    fn one_letter_is_never_close_to_another() {
        assert_eq!(closest("q", ["x", "y"]), None);
        assert_eq!(closest("X", ["x", "y"]), Some("x"));
    }
}
