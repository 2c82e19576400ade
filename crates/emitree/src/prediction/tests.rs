use super::*;
use proptest::prelude::*;

/// The mean of Σ c\[k\] xᵏ over \[a, b\].
fn polynomial_mean(coefficients: &[f64], a: f64, b: f64) -> f64 {
    let primitive = |x: f64| {
        let terms = coefficients.iter().zip(1_i32..);
        terms.map(|(c, power)| c * x.powi(power) / f64::from(power)).sum::<f64>()
    };
    (primitive(b) - primitive(a)) / (b - a)
}

#[test]
fn quadratic_weights_are_the_published_ones() {
    assert_eq!(part_weights(3, 1, 0.0, 0.5), [0.125, 1.0, -0.125]);
    assert_eq!(part_weights(3, 0, 0.0, 0.5), [1.375, -0.5, 0.125]);
    assert_eq!(part_weights(1, 0, 0.2, 0.7), [1.0]);
}

#[test]
fn a_polynomial_below_the_order_is_predicted_exactly_at_every_offset() {
    let coefficients = [0.3, -1.2, 0.7, 0.11, -0.05, 0.02, 0.003, -0.001, 0.0004];
    for order in [1, 3, 5, 7, 9] {
        let predictor = Predictor::new(order).unwrap();
        let polynomial = &coefficients[..order];
        let averages: Vec<f64> =
            (0..order).map(|k| polynomial_mean(polynomial, k as f64, k as f64 + 1.0)).collect();
        let scale = averages.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        for offset in 0..order {
            let [lower, upper] = predictor.split(&averages, offset);
            let x = offset as f64;
            assert!((lower - polynomial_mean(polynomial, x, x + 0.5)).abs() < 1e-12 * scale);
            assert!((upper - polynomial_mean(polynomial, x + 0.5, x + 1.0)).abs() < 1e-12 * scale);
        }
    }
}

#[test]
fn orders_outside_the_table_are_refused_by_name() {
    for order in [0, 2, 4, 11] {
        let message = Predictor::new(order).unwrap_err().to_string();
        assert_eq!(message, format!("`order` is {order}: expected an odd number from 1 to 9"));
    }
}

#[test]
fn stencils_stay_inside_or_wrap() {
    assert_eq!(Stencil::around(0, 3, 3, false), Stencil { start: 0, order: 3, offset: 0 });
    assert_eq!(Stencil::around(7, 3, 5, false), Stencil { start: 3, order: 5, offset: 4 });
    assert_eq!(Stencil::around(4, 3, 5, false), Stencil { start: 2, order: 5, offset: 2 });
    assert_eq!(Stencil::around(0, 3, 3, true), Stencil { start: 7, order: 3, offset: 1 });
    // Four cells hold a stencil of three, not of seven.
    assert_eq!(Stencil::around(3, 2, 7, false), Stencil { start: 1, order: 3, offset: 2 });
    assert_eq!(Stencil::around(1, 1, 3, true), Stencil { start: 1, order: 1, offset: 0 });
}

proptest! {
    /// A family predicted at once is the axes split one after the other, with axis 0 fastest.
    #[test]
    fn families_are_predicted_axis_by_axis(
        block in prop::collection::vec(-1.0..1.0_f64, 27),
        offsets in prop::array::uniform3(0..3_usize),
    ) {
        let predictor = Predictor::new(3).unwrap();
        let mut expected = [0.0; 8];
        for (n, child) in expected.iter_mut().enumerate() {
            let half = |axis: usize| n >> axis & 1;
            let along_x: Vec<f64> =
                block.chunks(3).map(|row| predictor.split(row, offsets[0])[half(0)]).collect();
            let along_y: Vec<f64> =
                along_x.chunks(3).map(|row| predictor.split(row, offsets[1])[half(1)]).collect();
            *child = predictor.split(&along_y, offsets[2])[half(2)];
        }
        let (mut family, mut scratch) = (block.clone(), vec![0.0; 27]);
        predictor.predict_family(3, offsets, &mut family, &mut scratch);
        prop_assert_eq!(&family[..8], &expected[..]);
        // Conservation: the mean of the children is the parent.
        let parent = block[offsets[0] + 3 * offsets[1] + 9 * offsets[2]];
        prop_assert!((family[..8].iter().sum::<f64>() / 8.0 - parent).abs() < 1e-14);
    }

    /// Means over parts add up to the cell's average, whatever the cut.
    #[test]
    fn parts_of_a_cell_are_conservative(
        order in prop::sample::select(vec![1_usize, 3, 5, 7]),
        seed in prop::collection::vec(-1.0..1.0_f64, 7),
        cut in 0.01..0.99_f64,
        offset in 0..7_usize,
    ) {
        let offset = offset % order;
        let mean = |from, to| -> f64 {
            part_weights(order, offset, from, to).iter().zip(&seed).map(|(w, a)| w * a).sum()
        };
        let total = cut * mean(0.0, cut) + (1.0 - cut) * mean(cut, 1.0);
        prop_assert!((total - seed[offset]).abs() < 1e-12);
    }
}
