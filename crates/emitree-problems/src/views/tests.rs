use super::*;

/// Half of the rules and twice the rows: by the midpoint rule alone, with no breaks.
#[test]
fn references_agree_with_many_plain_lines() {
    for seed in 0..12 {
        let view = random_view(seed);
        let reference = view.reference();
        let largest = reference.image.pixels().iter().fold(0.0_f64, |m, p| m.max(p.abs()));
        let plain = reference::plain(view.scene(), view.shape, 24);
        for (k, (exact, plain)) in reference.image.pixels().iter().zip(plain.pixels()).enumerate() {
            // The lines may miss the corner of a pixel that a disc has.
            assert!(!exact.is_nan() || plain.is_nan(), "{} {k}", view.name());
            let difference = (exact - plain).abs() / largest;
            assert!(plain.is_nan() || difference < 0.02, "{} {k}: {difference:.1e}", view.name());
        }
    }
}

#[test]
fn references_are_good_enough_for_a_tolerance_of_a_thousandth() {
    for seed in 0..24 {
        let view = random_view(seed);
        let reference = view.reference();
        assert!(reference.error < 2e-4, "{}: {:.1e}", view.name(), reference.error);
    }
}
