//! Tables against functions that they have exactly, and their derivatives against differences.

use super::*;

fn powers(count: i32) -> Vec<f64> {
    (0..count).map(|n| 2.0_f64.powi(n)).collect()
}

/// 2 + 3 a - b + 0.5 c + a b c, which is linear along each axis, on descending and uneven nodes.
fn linear_table() -> Table {
    let nodes = [vec![0.0, 1.0, 5.0], vec![3.0, 1.0], vec![-1.0, 0.0, 0.5, 2.0]];
    let mut values = Vec::new();
    for a in &nodes[0] {
        for b in &nodes[1] {
            values.extend(nodes[2].iter().map(|c| of_three(*a, *b, *c)));
        }
    }
    let axes = ["a", "b", "c"].into_iter().zip(nodes);
    Table::new(axes.map(|(name, nodes)| TableAxis::new(name, nodes)).collect(), values).unwrap()
}

fn of_three(a: f64, b: f64, c: f64) -> f64 {
    2.0 + 3.0 * a - b + 0.5 * c + a * b * c
}

#[test]
fn a_function_that_is_linear_along_each_axis_is_exact() {
    let table = linear_table();
    assert_eq!(table.names(), ["a", "b", "c"]);
    assert_eq!(table.nodes(1), [1.0, 3.0]);
    for [a, b, c] in [[0.0, 3.0, -1.0], [5.0, 1.0, 2.0], [0.25, 2.5, 0.3], [4.0, 1.1, 1.9]] {
        let found = table.value(&[a, b, c]).unwrap();
        assert!((found - of_three(a, b, c)).abs() < 1e-14, "{a} {b} {c}: {found}");
        let slopes = [3.0 + b * c, -1.0 + a * c, 0.5 + a * b];
        for (along, expected) in slopes.into_iter().enumerate() {
            let slope = table.slope([a, b, c], along);
            assert!((slope - expected).abs() < 1e-13, "{a} {b} {c}: {slope} {expected}");
        }
    }
}

#[test]
fn logarithms_make_powers_exact() {
    // a^-1.5 b^0.5 is linear in the logarithms.
    let nodes = [powers(5), powers(3)];
    let values =
        nodes[0].iter().flat_map(|a| nodes[1].iter().map(|b| a.powf(-1.5) * b.sqrt())).collect();
    let axes = ["a", "b"].into_iter().zip(nodes);
    let axes = axes.map(|(name, nodes)| TableAxis::new(name, nodes).logarithmic()).collect();
    let table = Table::new(axes, values).unwrap().with_logarithmic_values().unwrap();
    for [a, b] in [[1.0, 1.0], [3.0, 2.7], [15.9, 3.0]] {
        let expected: f64 = f64::powf(a, -1.5) * f64::sqrt(b);
        assert!((table.value(&[a, b]).unwrap() / expected - 1.0).abs() < 1e-14);
        assert!((table.slope([a, b, 0.0], 0) / (-1.5 * expected / a) - 1.0).abs() < 1e-13);
        assert!((table.slope([a, b, 0.0], 1) / (0.5 * expected / b) - 1.0).abs() < 1e-13);
    }
}

#[test]
fn beyond_the_axes_it_is_as_chosen() {
    let table = linear_table();
    let error = table.value(&[1.0, 4.0, 9.0]).unwrap_err();
    assert_eq!(error.to_string(), "the argument `b` is 4: expected 1 to 3, the range of the table");
    assert!(table.interpolated([1.0, 4.0, 0.0]).is_nan());
    let zero = table.clone().with_beyond(BeyondTable::Zero);
    assert_eq!(zero.value(&[1.0, 4.0, 0.0]).unwrap().to_bits(), 0.0_f64.to_bits());
    assert_eq!(zero.slope([1.0, 4.0, 0.0], 0).to_bits(), 0.0_f64.to_bits());
    let edge = table.with_beyond(BeyondTable::Edge);
    assert!((edge.value(&[1.0, 4.0, 9.0]).unwrap() - of_three(1.0, 3.0, 2.0)).abs() < 1e-14);
    assert_eq!(edge.slope([1.0, 4.0, 0.0], 1).to_bits(), 0.0_f64.to_bits());
    assert!((edge.slope([1.0, 4.0, 0.5], 0) - (3.0 + 3.0 * 0.5)).abs() < 1e-13);
    for table in [zero, edge] {
        assert!(table.value(&[1.0, 4.0, f64::NAN]).unwrap().is_nan());
        assert!(table.value(&[f64::NAN, 2.0, 0.0]).unwrap().is_nan());
    }
}

#[test]
fn what_makes_no_table_is_named() {
    let one = |nodes: &[f64], values: &[f64]| {
        Table::new(vec![TableAxis::new("T", nodes.to_vec())], values.to_vec())
    };
    let cases = [
        (one(&[1.0], &[1.0]), "the axis `T` has 1 node(s): expected at least 2"),
        (
            one(&[1.0, f64::NAN], &[1.0; 2]),
            "node 1 of the axis `T` is NaN: expected a finite number",
        ),
        (
            one(&[1.0, 3.0, 3.0], &[1.0; 3]),
            "node 2 of the axis `T` is 3 and follows 3: expected nodes that all increase or all \
             decrease",
        ),
        (
            one(&[1.0, 3.0], &[1.0; 3]),
            "3 values for axes of [2] nodes: expected one for each combination",
        ),
        (
            one(&[1.0, 3.0], &[1.0, f64::INFINITY]),
            "the value at the nodes [1] is inf: expected a finite number",
        ),
        (
            one(&[1.0, 3.0], &[1.0, 0.0]).and_then(Table::with_logarithmic_values),
            "the value at the nodes [1] is 0: expected a number above 0, which has a logarithm",
        ),
        (
            Table::new(vec![TableAxis::new("T", vec![3.0, 0.0]).logarithmic()], vec![1.0; 2]),
            "node 1 of the axis `T` is 0: expected a number above 0 and apart from the others, \
             which has a logarithm",
        ),
        (Table::new(Vec::new(), vec![1.0]), "the table has 0 axes: expected 1 to 3"),
    ];
    for (found, message) in cases {
        assert_eq!(found.unwrap_err().to_string(), message);
    }
}
