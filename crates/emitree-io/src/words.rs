//! Lists in messages.

/// What may be chosen: `a, b or c`.
pub(crate) fn alternatives<T: ToString>(items: impl IntoIterator<Item = T>) -> String {
    listed(items, "or")
}

/// What belongs together: `a, b and c`.
pub(crate) fn all_of<T: ToString>(items: impl IntoIterator<Item = T>) -> String {
    listed(items, "and")
}

fn listed<T: ToString>(items: impl IntoIterator<Item = T>, last: &str) -> String {
    let mut items: Vec<String> = items.into_iter().map(|item| item.to_string()).collect();
    match items.pop() {
        Some(end) if !items.is_empty() => format!("{} {last} {end}", items.join(", ")),
        only => only.unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_item_follows_a_word() {
        let list = |items: &[&str]| [alternatives(items), all_of(items)];
        assert_eq!(list(&["a", "b", "c"]), ["a, b or c", "a, b and c"]);
        assert_eq!(list(&["a", "b"]), ["a or b", "a and b"]);
        assert_eq!((list(&["a"]), list(&[])), (["a", "a"].map(String::from), Default::default()));
    }
}
