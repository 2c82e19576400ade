//! Values: against the standard library, against the same formula in Rust, and in any batch.

use super::evaluate::BLOCK;
use super::*;
use crate::elementary;
use proptest::prelude::*;

fn parse(text: &str) -> Expression {
    Expression::parse(text, &BTreeMap::from([("alpha".to_owned(), 100.0)])).unwrap()
}

fn rates(expression: &Expression, positions: &[[f64; 3]]) -> Vec<f64> {
    let directions = vec![[0.6, 0.0, -0.8]; positions.len()];
    let mut rates = vec![f64::NAN; positions.len()];
    let samples = Samples::new(positions, &directions);
    expression.emission_rates(&samples, &mut rates).unwrap();
    rates
}

fn rate(text: &str, position: [f64; 3]) -> f64 {
    rates(&parse(text), &[position])[0]
}

/// Points of [0, 1)³ that fill it evenly (the additive recurrence of the square roots of 2, 3, 5).
fn points(n: usize) -> Vec<[f64; 3]> {
    let steps = [2.0_f64.sqrt(), 3.0_f64.sqrt(), 5.0_f64.sqrt()];
    (0..n).map(|i| steps.map(|step| (i as f64 * step).fract())).collect()
}

const EQUATION_8: &str = "(sin(5*x)*sin(7*y)*sin(11*z)/10)^2 + exp(-alpha*(x-sqrt(2)/3)^2/sqrt(2) \
                          - alpha*(y-sqrt(7)/5)^2*sqrt(2) - alpha*(z-sqrt(6)/5)^2*sqrt(3))";

fn equation_8([x, y, z]: [f64; 3]) -> f64 {
    let waves = (5.0 * x).sin() * (7.0 * y).sin() * (11.0 * z).sin() / 10.0;
    let (x, y, z) = (x - 2.0_f64.sqrt() / 3.0, y - 7.0_f64.sqrt() / 5.0, z - 6.0_f64.sqrt() / 5.0);
    let sum = x * x / 2.0_f64.sqrt() + y * y * 2.0_f64.sqrt() + z * z * 3.0_f64.sqrt();
    waves * waves + (-100.0 * sum).exp()
}

#[test]
fn equation_8_as_in_rust() {
    let positions = points(1000);
    for (rate, &position) in rates(&parse(EQUATION_8), &positions).iter().zip(&positions) {
        assert!((rate - equation_8(position)).abs() <= 1e-15, "{position:?}");
    }
}

#[test]
fn any_batch_gives_the_same_bits() {
    let expression = parse(
        "if(x < y, exp(-r^2)*sin(x*y), atan2(z, x) + dx)/(1 + x^5) + max(x, z, 0.5)*min(y, dz)^x",
    );
    let positions = points(600);
    let one_by_one: Vec<_> =
        positions.iter().map(|&p| rates(&expression, &[p])[0].to_bits()).collect();
    for n in 0..=positions.len() {
        let batch = rates(&expression, &positions[..n]);
        let bits: Vec<_> = batch.iter().map(|rate| rate.to_bits()).collect();
        assert_eq!(bits, one_by_one[..n], "batch of {n}");
    }
    assert!(positions.len() > 2 * BLOCK);
}

#[test]
fn variables_and_directions() {
    let at = [2.0, 3.0, 6.0];
    let table = [("x", 2.0), ("y", 3.0), ("z", 6.0), ("r", 7.0), ("dx", 0.6), ("dy", 0.0)];
    for (text, value) in table {
        assert!((rate(text, at) - value).abs() <= 0.0, "{text}");
    }
    assert!((rate("100*x + 10*y + z*dz", at) - 225.2).abs() < 1e-13);
    assert!((rate("alpha/4", at) - 25.0).abs() <= 0.0);
}

#[test]
fn a_branch_not_taken_has_no_effect() {
    assert!((rate("if(x > 0, sqrt(x), 7)", [-1.0, 0.0, 0.0]) - 7.0).abs() <= 0.0);
    assert!((rate("if(x > 0, 7, sqrt(-x))", [1.0, 0.0, 0.0]) - 7.0).abs() <= 0.0);
    assert!(rate("if(x > 0, 7, sqrt(x))", [-1.0, 0.0, 0.0]).is_nan());
    assert!(rate("(x > 0)*sqrt(x)", [-1.0, 0.0, 0.0]).is_nan());
}

#[test]
fn conditions_with_every_kind_of_operand() {
    for (x, expected) in [(-1.0, [2.0, 3.0, 3.0, 5.0]), (1.0, [3.0, 1.0, 4.0, 1.0])] {
        let at = [x, 3.0, 5.0];
        let texts = ["if(x < 0, 2, y)", "if(x < 0, y, 1)", "if(x < 0, y, 4)", "if(x < 0, z, x)"];
        for (text, expected) in texts.into_iter().zip(expected) {
            assert!((rate(text, at) - expected).abs() <= 0.0, "{text} at {x}");
        }
    }
}

#[test]
fn several_threads_and_sizes_of_tape_share_nothing() {
    let small = parse("x + 1");
    let large = parse(EQUATION_8);
    let positions = points(700);
    let expected = (rates(&small, &positions), rates(&large, &positions));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..20 {
                    assert_eq!(rates(&large, &positions), expected.1);
                    assert_eq!(rates(&small, &positions), expected.0);
                }
            });
        }
    });
}

#[test]
fn text_is_kept() {
    assert_eq!(parse(" x + 1 ").text(), " x + 1 ");
    assert_eq!(parse("x + 1").unused_constants(), ["alpha"]);
    assert!(parse("alpha*x").unused_constants().is_empty());
}

/// Energies of 0.1 to 10, every time others.
fn energies(n: usize) -> Vec<f64> {
    (0..n).map(|i| 10.0_f64.powf(2.0 * (i as f64 * 7.0_f64.sqrt()).fract() - 1.0)).collect()
}

fn rates_at(expression: &Expression, positions: &[[f64; 3]], energies: &[f64]) -> Vec<f64> {
    let directions = vec![[0.6, 0.0, -0.8]; positions.len()];
    let mut rates = vec![f64::NAN; positions.len()];
    let samples = Samples::new(positions, &directions).at_energies(energies);
    expression.emission_rates(&samples, &mut rates).unwrap();
    rates
}

#[test]
fn energies_go_with_their_positions() {
    let expression = parse("exp(-alpha*r^2 - E/(1 + x^2))/E*sqrt(1.5 + dz) + if(E > 5, y, 0)*dx");
    let (positions, energies) = (points(1000), energies(1000));
    assert!(positions.len() > 3 * BLOCK);
    let rates = rates_at(&expression, &positions, &energies);
    for (rate, (&[x, y, z], &energy)) in rates.iter().zip(positions.iter().zip(&energies)) {
        let cloud = (-100.0 * (x * x + y * y + z * z) - energy / (1.0 + x * x)).exp();
        let step = if energy > 5.0 { 0.6 * y } else { 0.0 };
        let expected = cloud / energy * 0.7_f64.sqrt() + step;
        assert!((rate - expected).abs() <= 1e-14, "{x}, {y}, {z}, {energy}: {rate}, {expected}");
    }
}

#[test]
fn any_batch_with_energies_gives_the_same_bits() {
    let expression = parse("exp(-r*E)*sin(x*y) + E^y - dx/E");
    let (positions, energies) = (points(600), energies(600));
    let one_by_one: Vec<_> = positions
        .iter()
        .zip(&energies)
        .map(|(&position, &energy)| rates_at(&expression, &[position], &[energy])[0].to_bits())
        .collect();
    for n in (0..=positions.len()).step_by(7).chain([BLOCK, 2 * BLOCK]) {
        let batch = rates_at(&expression, &positions[..n], &energies[..n]);
        let bits: Vec<_> = batch.iter().map(|rate| rate.to_bits()).collect();
        assert_eq!(bits, one_by_one[..n], "batch of {n}");
    }
}

#[test]
fn the_energy_is_not_a_number_without_an_axis() {
    let spectrum = parse("if(x < 0.5, 1, E)");
    let positions = points(600);
    // Energies of the batch before don't come back from the registers.
    let with = rates_at(&spectrum, &positions, &vec![3.0; 600]);
    let without = rates(&spectrum, &positions);
    for ([x, _, _], (with, without)) in positions.iter().zip(with.iter().zip(without)) {
        let expected = if *x < 0.5 { [1.0; 2] } else { [3.0, f64::NAN] };
        assert!(same(*with, expected[0]) && same(without, expected[1]), "{x}: {with}, {without}");
    }
    assert_eq!(spectrum.energy_span(), Some(15..16));
    // Without E the spectrum is flat.
    let flat = parse("exp(-r^2)");
    assert_eq!(flat.energy_span(), None);
    assert_eq!(rates_at(&flat, &positions, &energies(600)), rates(&flat, &positions));
}

/// Same value to the last bit, or both not a number. The sign of a zero is left open, as the
/// standard library leaves it open in `min` and `max`.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()) || (a.abs() + b.abs() <= 0.0)
}

fn truth(condition: bool) -> f64 {
    f64::from(u8::from(condition))
}

#[expect(clippy::float_cmp, reason = "compared with the language's own comparison")]
fn comparisons(x: f64, y: f64) -> [(&'static str, f64); 6] {
    [
        ("x < y", truth(x < y)),
        ("x <= y", truth(x <= y)),
        ("x > y", truth(x > y)),
        ("x >= y", truth(x >= y)),
        ("x == y", truth(x == y)),
        ("x != y", truth(x != y)),
    ]
}

proptest! {
    #[test]
    fn every_function_as_in_the_standard_library(
        x in prop_oneof![-1.0..1.0, -50.0..50.0, any::<f64>()],
        y in prop_oneof![-1.0..1.0, -50.0..50.0, any::<f64>()],
    ) {
        let (x, y): (f64, f64) = (x, y);
        let table = [
            ("-x", -x), ("x + y", x + y), ("x - y", x - y), ("x*y", x * y), ("x/y", x / y),
            ("2/x", 2.0 / x), ("x/3", x / 3.0), ("2 - y", 2.0 - y), ("x - 2", x - 2.0),
            ("x^2", x * x), ("min(x, y)", x.min(y)), ("max(x, y)", x.max(y)), ("max(x, 0)", x.max(0.0)),
            ("abs(x)", x.abs()), ("sqrt(x)", x.sqrt()), ("tan(x)", x.tan()), ("asin(x)", x.asin()), ("acos(x)", x.acos()),
            ("atan(x)", x.atan()), ("atan2(x, y)", x.atan2(y)), ("sinh(x)", x.sinh()),
            ("cosh(x)", x.cosh()), ("tanh(x)", x.tanh()), ("erf(x)", libm::erf(x)),
            ("floor(x)", x.floor()), ("if(x, 1, 2)", if x == 0.0 { 2.0 } else { 1.0 }),
        ];
        for (text, expected) in table.into_iter().chain(comparisons(x, y)) {
            let value = rate(text, [x, y, 0.0]);
            prop_assert!(same(value, expected), "{} = {}, expected {}", text, value, expected);
        }
        // Our own, whose accuracy is tested where they are.
        let table = [
            ("exp(x)", elementary::exp(x)), ("ln(x)", elementary::ln(x)),
            ("log10(x)", elementary::log10(x)), ("sin(x)", elementary::sin(x)),
            ("cos(x)", elementary::cos(x)), ("x^y", elementary::pow(x, y)),
            ("2^y", elementary::pow(2.0, y)), ("x^0.5", elementary::pow(x, 0.5)),
        ];
        for (text, expected) in table {
            let value = rate(text, [x, y, 0.0]);
            prop_assert!(same(value, expected), "{} = {}, expected {}", text, value, expected);
        }
    }

    /// Within 2 units in the last place.
    #[test]
    fn functions_of_our_own_near_the_standard_library(x in -50.0..50.0, y in -3.0..3.0) {
        let (x, y): (f64, f64) = (x, y);
        let table = [
            ("exp(x)", x.exp()), ("ln(x)", x.ln()), ("log10(x)", x.log10()), ("sin(x)", x.sin()),
            ("cos(x)", x.cos()), ("x^y", x.powf(y)), ("2^y", y.exp2()), ("x^0.5", x.powf(0.5)),
            ("abs(x)^y", x.abs().powf(y)), ("abs(x)^-2.5", x.abs().powf(-2.5)),
        ];
        for (text, expected) in table {
            let value = rate(text, [x, y, 0.0]);
            let near = (value - expected).abs() <= 2.0 * f64::EPSILON * expected.abs();
            prop_assert!(
                near || (value.is_nan() && expected.is_nan()),
                "{} = {}, expected {}", text, value, expected
            );
        }
    }

    /// A part without variables has the same value as if it had one.
    #[test]
    fn constants_fold_to_the_same_bits(x in 0.1..40.0) {
        for function in ["exp", "ln", "log10", "sin", "cos", "1.7^", "tan"] {
            let folded = rate(&format!("{function}({x:?})"), [0.0; 3]);
            prop_assert!(same(folded, rate(&format!("{function}(x)"), [x, 0.0, 0.0])), "{}", function);
        }
    }

    #[test]
    fn integer_powers(x in prop_oneof![0.1..10.0, -10.0..-0.1], n in -64_i32..=64) {
        let value = rate(&format!("x^{n}"), [x, 0.0, 0.0]);
        let expected = x.powf(f64::from(n));
        let bound = f64::EPSILON * (1.0 + 0.5 * f64::from(n.abs())) * expected.abs();
        prop_assert!((value - expected).abs() <= bound, "{}^{}", x, n);
    }

    /// Whatever the text, parsing ends with a value or a message, never a panic.
    #[test]
    fn no_text_panics(text in "[-+*/^()<>=!,. xyz0-9eEπ²sinmaxif_]{0,40}") {
        if let Err(error) = Expression::parse(&text, &BTreeMap::new()) {
            prop_assert!(!error.message().is_empty());
            prop_assert!(text.get(error.span()).is_some());
        }
    }
}
