//! Lattices of lines in a pixel.

use super::*;

#[test]
fn each_line_of_a_lattice_has_its_own_row_and_column() {
    for count in [5, 34, 89, 144, 233, 377, 610, 987] {
        let mut seen = vec![[false; 2]; count];
        for k in 0..count {
            for (axis, along) in fibonacci(k, count).into_iter().enumerate() {
                let place = along * count as f64 - 0.5;
                assert!((place - place.round()).abs() < 1e-9);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "0 or more"
                )]
                let place = place.round() as usize;
                assert!(!core::mem::replace(&mut seen[place][axis], true));
            }
        }
    }
}

#[test]
fn a_limb_in_a_pixel_is_resolved() {
    // √x is the chord beside a limb.
    let mean = |count: usize| {
        (0..count).map(|k| fibonacci(k, count)[0].sqrt()).sum::<f64>() / count as f64
    };
    assert!((mean(89) - 2.0 / 3.0).abs() < 3e-4);
    assert!((mean(610) - 2.0 / 3.0).abs() < 2e-5);
}
