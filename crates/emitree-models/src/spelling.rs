//! "Did you mean …?" for names that users misspell.

/// The known name that `name` most likely stands for, if one is close enough.
///
/// Case does not count; otherwise one wrong, missing, extra or swapped letter is forgiven in a name
/// of up to four letters, two in longer ones, and none in a name of one letter, where it would say
/// nothing.
pub(crate) fn closest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let letters = |text: &str| text.to_lowercase().chars().collect::<Vec<_>>();
    let wanted = letters(name);
    let forgiven = match wanted.len() {
        0 | 1 => 0,
        2..=4 => 1,
        _ => 2,
    };
    known
        .into_iter()
        .map(|candidate| (distance(&wanted, &letters(candidate)), candidate))
        .filter(|&(edits, _)| edits <= forgiven)
        .min_by_key(|&(edits, _)| edits)
        .map(|(_, candidate)| candidate)
}

/// The part of a message that suggests a name, empty if there is none.
pub(crate) fn did_you_mean(suggestion: Option<&str>) -> String {
    suggestion.map_or_else(String::new, |name| format!(": did you mean `{name}`?"))
}

/// Letters to change, insert, drop or swap with their neighbour to turn `a` into `b` (the
/// optimal string alignment distance).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for (i, row) in rows.iter_mut().enumerate() {
        row[0] = i;
    }
    rows[0] = (0..=b.len()).collect();
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let changed = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut edits = changed.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                edits = edits.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = edits;
        }
    }
    rows[a.len()][b.len()]
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

    #[test]
    fn counts_edits() {
        let edits = |a: &str, b: &str| {
            distance(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>())
        };
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("abc", ""), 3);
        assert_eq!(edits("abcd", "acbd"), 1);
        assert_eq!(edits("kitten", "sitting"), 3);
    }
}
