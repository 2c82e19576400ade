//! Derivatives against closed forms, and against central differences for every operator and function.

use super::super::Expression;
use super::super::operation::{FUNCTIONS, Function};
use super::*;
use emitree::Emission;

const A: f64 = 0.7;
const B: f64 = 1.3;

fn constants(a: f64, b: f64) -> BTreeMap<String, f64> {
    BTreeMap::from([("a".to_owned(), a), ("b".to_owned(), b)])
}

/// Points of (0, 1)³ that fill it evenly (the additive recurrence of the square roots of 2, 3, 5).
fn points(n: usize) -> Vec<[f64; 3]> {
    let steps = [2.0_f64.sqrt(), 3.0_f64.sqrt(), 5.0_f64.sqrt()];
    (1..=n).map(|i| steps.map(|step| (i as f64 * step).fract())).collect()
}

/// The rates (n), and the derivatives by a and b (n each).
fn found(text: &str, [a, b]: [f64; 2], positions: &[[f64; 3]]) -> [Vec<f64>; 3] {
    let glow = DifferentiableExpression::parse(text, &constants(a, b), &["a", "b"]).unwrap();
    let n = positions.len();
    let directions = vec![[0.6, 0.0, -0.8]; n];
    let samples = Samples::new(positions, &directions);
    let (mut rates, mut derivatives) = (vec![f64::NAN; n], vec![f64::NAN; 2 * n]);
    glow.rates_and_derivatives(&samples, &mut rates, &mut derivatives);
    let by_b = derivatives.split_off(n);
    [rates, derivatives, by_b]
}

fn rates(text: &str, [a, b]: [f64; 2], positions: &[[f64; 3]]) -> Vec<f64> {
    let directions = vec![[0.6, 0.0, -0.8]; positions.len()];
    let mut rates = vec![f64::NAN; positions.len()];
    let samples = Samples::new(positions, &directions);
    let expression = Expression::parse(text, &constants(a, b)).unwrap();
    expression.emission_rates(&samples, &mut rates).unwrap();
    rates
}

/// Compares derivatives with central differences extrapolated from two steps: their error is of the order of
/// h⁴ = 1e-12 and of rounding, 1e-16/h = 1e-13, times higher derivatives.
fn assert_as_differences(text: &str, constants: [f64; 2]) {
    let positions = points(600);
    let [values, by_a, by_b] = found(text, constants, &positions);
    assert_eq!(bits(&values), bits(&rates(text, constants, &positions)), "{text}: other rates");
    for (number, derivatives) in [by_a, by_b].iter().enumerate() {
        let difference = |step: f64| -> Vec<f64> {
            let moved = |by: f64| {
                let mut moved = constants;
                moved[number] += by;
                rates(text, moved, &positions)
            };
            moved(step).iter().zip(moved(-step)).map(|(a, b)| (a - b) / (2.0 * step)).collect()
        };
        let (fine, coarse) = (difference(1e-3), difference(2e-3));
        for (i, derivative) in derivatives.iter().enumerate() {
            let expected = (4.0 * fine[i] - coarse[i]) / 3.0;
            let allowed = 1e-8 * (1.0 + expected.abs());
            let at = positions[i];
            assert!(
                (derivative - expected).abs() < allowed,
                "{text} by {number} at {at:?}: {derivative} {expected}"
            );
        }
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Every function, with an argument that depends on both constants and stays in its domain.
#[test]
fn all_functions_as_central_differences() {
    for (name, function) in FUNCTIONS {
        let text = match function {
            Function::If => "if(x < 0.5, sin(a*x)*b, a*b*y)".to_owned(),
            Function::One(_) => format!("b*{name}(0.1 + 0.6*a*x*x + 0.15*b*y)"),
            Function::Two(_) => format!("{name}(a*y + b*z, 0.5 + a*a*x)"),
            // Equal only at points that the lattice does not contain.
            Function::Fold(_) => format!("{name}(a*x, b*y, a*b*z, 0.4)"),
        };
        // Where `floor` and kinks of the arguments of min and max are: differences across them say nothing.
        match name {
            "floor" => assert_as_differences("b*x*floor(7*y) + a*floor(x + z)", [A, B]),
            "min" | "max" => assert_of_folds(name),
            _ => assert_as_differences(&text, [A, B]),
        }
    }
}

/// `min` and `max` have the derivatives of the argument that they take.
fn assert_of_folds(name: &str) {
    let positions = points(600);
    let [_, by_a, by_b] = found(&format!("{name}(a*x, b*y, a*b*z, 0.4)"), [A, B], &positions);
    for (i, [x, y, z]) in positions.into_iter().enumerate() {
        let arguments =
            [(A * x, [x, 0.0]), (B * y, [0.0, y]), (A * B * z, [B * z, A * z]), (0.4, [0.0; 2])];
        let sign = if name == "min" { 1.0 } else { -1.0 };
        let taken =
            arguments.into_iter().min_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0))).unwrap();
        assert!((by_a[i] - taken.1[0]).abs() < 1e-15 && (by_b[i] - taken.1[1]).abs() < 1e-15);
    }
}

#[test]
fn all_operators_as_central_differences() {
    for text in [
        "a*x + b*y - a*b*z",
        "a*x - y",
        "x - b*y",
        "-(a*x)*(b - y)",
        "(a + x)/(b + y*a)",
        "1/(a + x)",
        "(a*x)/(2 + y)",
        "(a + x)^3",
        "(a + x)^-2",
        "(a*x)^2.5",
        "(0.2 + x)^(a*y + b)",
        "(a + x)^(b*z)",
        "x^a + a^x + 2^(a*b)",
        "(x < y)*a*z + (y <= z)*b*b + (x >= y)*b + (x == y)*a + (x != y)*a*b",
        "a",
        "a^b",
        "a*b*r + dx*a - dz*b",
        "exp(-a*r^2/b^2)*(sin(5*a*x)*sin(7*b*y))^2",
    ] {
        assert_as_differences(text, [A, B]);
    }
    // As exponents that are small integers, whose powers are products.
    assert_as_differences("(0.3 + a*x)^b", [A, 2.0]);
    assert_as_differences("(0.3 + x)^a*b", [-3.0, B]);
}

#[test]
fn closed_forms() {
    let positions = points(300);
    let text = "b*exp(-((r - a)/0.2)^2)";
    let [_, by_a, by_b] = found(text, [A, B], &positions);
    for (i, [x, y, z]) in positions.into_iter().enumerate() {
        let offset = ((x * x + y * y + z * z).sqrt() - A) / 0.2;
        let peak = (-offset * offset).exp();
        assert!((by_a[i] - B * peak * 2.0 * offset / 0.2).abs() < 1e-13);
        assert!((by_b[i] - peak).abs() < 1e-15);
    }
    // Without cancellation where the functions are flat: 1 − tanh(x)² would be 0 here.
    let slope = |text: &str, a: f64| found(text, [a, B], &[[1.0, 0.0, 0.0]])[1][0];
    assert!((slope("tanh(a*x)", 20.0) / (4.0 * (-40.0_f64).exp()) - 1.0).abs() < 1e-14);
    let near_1: f64 = 1.0 - 1e-12;
    let expected = 1.0 / ((1.0 - near_1) * (1.0 + near_1)).sqrt();
    assert!((slope("asin(a*x)", near_1) / expected - 1.0).abs() < 1e-14);
    assert!((slope("acos(a*x)", near_1) / expected + 1.0).abs() < 1e-14);
}

/// One side at kinks, and the limits at the borders of domains.
#[test]
#[expect(clippy::float_cmp, reason = "these derivatives have no rounding")]
fn kinks_and_borders() {
    let by_a = |text: &str, a: f64, x: f64| found(text, [a, B], &[[x, 0.0, 0.0]])[1][0];
    assert_eq!(by_a("abs(a - x)", 0.5, 0.5), 1.0);
    assert_eq!([by_a("abs(a - x)", 0.5, 0.6), by_a("abs(a - x)", 0.5, 0.4)], [-1.0, 1.0]);
    assert_eq!([by_a("min(a, x)", 0.5, 0.5), by_a("min(x, a)", 0.5, 0.5)], [1.0, 0.0]);
    assert_eq!([by_a("max(a, x)", 0.5, 0.5), by_a("max(x, a)", 0.5, 0.5)], [1.0, 0.0]);
    assert_eq!(by_a("if(x < a, a*a, 3*a)", 0.5, 0.5), 3.0);
    assert_eq!([by_a("floor(a + x)", 0.5, 0.5), by_a("(x < a) + a", 0.5, 0.5)], [0.0, 1.0]);
    // sqrt(a x) at x = 0 is 0 for every a; at a = 0 its slope is infinite.
    assert_eq!([by_a("sqrt(a*x)", 0.5, 0.0), by_a("sqrt(a*x)", 0.0, 0.5)], [0.0, f64::INFINITY]);
    // x^a at x = 0 is 0 for every a > 0; (a x)^1 and (a x)^0 have finite slopes at a = 0.
    assert_eq!(by_a("x^a", 1.5, 0.0), 0.0);
    assert_eq!([by_a("(a*x)^b", 0.0, 0.5), by_a("(a*x)^1", 0.0, 0.5)], [0.0, 0.5]);
    assert_eq!(by_a("(a*x)^0", 0.0, 0.5), 0.0);
    // A NaN is ignored, with its derivative.
    assert_eq!(by_a("max(sqrt(-x)*a, 3*a)", 0.5, 0.5), 3.0);
    assert_eq!(by_a("min(3*a, ln(-x)*a)", 0.5, 0.5), 3.0);
    // What is not taken is never seen.
    assert_eq!(by_a("if(x > 1, ln(1 - x)*a, a*x)", 0.5, 0.25), 0.25);
}

#[test]
fn any_batch_gives_the_same_bits() {
    let text =
        "if(x < y, exp(-a*r^2)*sin(b*x*y), atan2(z*a, x) + dx)/(1 + b*x^5) + max(x, z*a, 0.5)^b";
    let positions = points(600);
    let all = found(text, [A, B], &positions).map(|values| bits(&values));
    for n in [1, 2, 255, 256, 257, 512, 599] {
        let some = found(text, [A, B], &positions[..n]).map(|values| bits(&values));
        for (some, all) in some.iter().zip(&all) {
            assert_eq!(some.as_slice(), &all[..n]);
        }
    }
    assert!(found(text, [A, B], &[]).iter().all(Vec::is_empty));
}

/// A constant that the expression does not name has the derivative 0, and others need none.
#[test]
fn constants_by_name() {
    let positions = points(3);
    assert_eq!(found("a*x", [A, B], &positions)[2], [0.0; 3]);
    let of = |by: &[&str]| DifferentiableExpression::parse("a*x + b", &constants(A, B), by);
    assert_eq!(of(&["b"]).unwrap().constants(), ["b"]);
    let unknown = of(&["a", "c"]).unwrap_err();
    assert_eq!(unknown.message(), "`c` is not a constant of the expression");
    assert_eq!(unknown.help(), Some("constants: a, b"));
    let twice = "`a` is differentiated by twice: expected each constant once";
    assert_eq!(of(&["a", "a"]).unwrap_err().message(), twice);
    assert!(of(&["x"]).is_err());
}
