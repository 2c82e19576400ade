//! The nearest of several, by their distances.

/// Keeps at most so many entries with the least distances, the nearest first; equal distances are in the
/// order of their numbers.
pub(super) fn keep_nearest(found: &mut Vec<(f64, usize)>, count: usize) {
    let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if found.len() > count && count > 0 {
        found.select_nth_unstable_by(count - 1, order);
    }
    found.truncate(count);
    found.sort_unstable_by(order);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_entries_in_order_are_kept() {
        let all = [(0.5, 0), (0.2, 1), (0.7, 2), (0.2, 3), (0.1, 4)];
        let sorted = [(0.1, 4), (0.2, 1), (0.2, 3), (0.5, 0), (0.7, 2)];
        for count in 0..7 {
            let mut found = all.to_vec();
            keep_nearest(&mut found, count);
            assert_eq!(found, sorted[..count.min(5)]);
        }
    }
}
