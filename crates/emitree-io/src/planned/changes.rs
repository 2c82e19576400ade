//! What of a scene may change while its rates are made.

use std::collections::{BTreeMap, BTreeSet};

/// Tables that change neither the points of a view nor their rates: the rates stay right whatever they say.
const MAY_CHANGE: [&str; 5] = ["image", "render", "instrument", "build", "seed"];

/// The values of a scene by their keys.
pub(super) type Values = BTreeMap<String, String>;

/// The values that the rates depend on.
pub(super) fn lasting(values: Values) -> Values {
    let may_change = |key: &str| {
        let table = key.split(['.', '[']).next().unwrap_or_default();
        MAY_CHANGE.contains(&table)
    };
    values.into_iter().filter(|(key, _)| !may_change(key)).collect()
}

/// The keys in which two scenes differ, with their values.
pub(super) fn between(before: &Values, now: &Values) -> Vec<String> {
    let keys: BTreeSet<&String> = before.keys().chain(now.keys()).collect();
    let change = |key: &String| match (before.get(key), now.get(key)) {
        (Some(before), Some(now)) if before == now => None,
        (Some(before), Some(now)) => Some(format!("`{key}` was {before} and is {now}")),
        (Some(before), None) => Some(format!("`{key}` was {before} and is missing")),
        (None, Some(now)) => Some(format!("`{key}` is {now} and was missing")),
        (None, None) => None,
    };
    keys.into_iter().filter_map(change).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(of: &[(&str, &str)]) -> Values {
        of.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
    }

    #[test]
    fn changes_are_named_with_their_values() {
        let before = values(&[("emission.a", "1"), ("projection.far", "20"), ("x", "2")]);
        let now = values(&[("emission.a", "1"), ("bounds.type", "\"sphere\""), ("x", "3")]);
        let expected = [
            "`bounds.type` is \"sphere\" and was missing",
            "`projection.far` was 20 and is missing",
            "`x` was 2 and is 3",
        ];
        assert_eq!(between(&before, &now), expected);
    }

    #[test]
    fn the_method_and_the_pixels_may_change() {
        let all = values(&[("image.width", "8"), ("seed[0].radius", "1"), ("energy.min", "1")]);
        assert_eq!(lasting(all), values(&[("energy.min", "1")]));
    }
}
