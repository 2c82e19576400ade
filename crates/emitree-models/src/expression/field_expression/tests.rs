//! Fields and tables against the same numbers by hand, and every failure.

use super::*;
use crate::expression::{DifferentiableExpression, Expression};
use crate::grid::{Coordinates, Interpolation, uniform_nodes};
use crate::table::{BeyondTable, TableAxis};

const DIRECTION: [f64; 3] = [0.0, 0.6, -0.8];

/// f(x, y, z) at the nodes of a cube from -1 to 1.
fn cube(count: usize, f: impl Fn([f64; 3]) -> f64) -> Grid {
    let nodes = uniform_nodes(-1.0, 1.0, count);
    let mut values = Vec::new();
    for &z in &nodes {
        for &y in &nodes {
            values.extend(nodes.iter().map(|&x| f([x, y, z])));
        }
    }
    Grid::new([nodes.clone(), nodes.clone(), nodes], values).unwrap()
}

fn linear([x, y, z]: [f64; 3]) -> f64 {
    3.0 + x - 0.5 * y + 0.25 * z
}

/// A table of 2 T from 1 to 4.
fn twice() -> Table {
    Table::new(vec![TableAxis::new("T", vec![1.0, 4.0])], vec![2.0, 8.0]).unwrap()
}

fn parse(text: &str, fields: Vec<(&str, Grid)>, tables: Vec<(&str, Table)>) -> FieldExpression {
    try_parse(text, fields, tables).unwrap()
}

fn try_parse(
    text: &str,
    fields: Vec<(&str, Grid)>,
    tables: Vec<(&str, Table)>,
) -> Result<FieldExpression, ExpressionError> {
    let constants = BTreeMap::from([("a".to_owned(), 2.0)]);
    let fields = fields.into_iter().map(|(name, field)| (name.to_owned(), field)).collect();
    let tables = tables.into_iter().map(|(name, table)| (name.to_owned(), table)).collect();
    FieldExpression::parse(text, &constants, fields, tables)
}

fn rates(of: &impl Emission<Error = FieldFailure>, positions: &[[f64; 3]]) -> Vec<f64> {
    try_rates(of, positions).unwrap()
}

fn try_rates(
    of: &impl Emission<Error = FieldFailure>,
    positions: &[[f64; 3]],
) -> Result<Vec<f64>, FieldFailure> {
    let mut rates = vec![f64::NAN; positions.len()];
    of.emission_rates(&Samples::new(positions, &vec![DIRECTION; positions.len()]), &mut rates)?;
    Ok(rates)
}

/// Points of the cube from -1 to 1 (the additive recurrence of the square roots of 2, 3, 5).
fn points(n: usize) -> Vec<[f64; 3]> {
    let steps = [2.0_f64.sqrt(), 3.0_f64.sqrt(), 5.0_f64.sqrt()];
    (1..=n).map(|i| steps.map(|step| 2.0 * (i as f64 * step).fract() - 1.0)).collect()
}

#[test]
fn fields_are_variables_and_tables_functions() {
    // Linear fields are exact on any grid; with other axes, and by monotone cubics.
    let t = cube(5, |at| linear(at) / 2.0).with_interpolation(Interpolation::MonotoneCubic);
    let fields = vec![("n", cube(3, linear)), ("T", t), ("v", cube(3, |[x, ..]| x))];
    let glow = parse("a*n^2*sqrt(T)*Twice(T + 1) + v*x*dy", fields, vec![("Twice", twice())]);
    let positions = points(3000);
    for (rate, &at) in rates(&glow, &positions).iter().zip(&positions) {
        let (n, t) = (linear(at), linear(at) / 2.0);
        let expected = 2.0 * n * n * t.sqrt() * 2.0 * (t + 1.0) + at[0] * at[0] * DIRECTION[1];
        assert!((rate / expected - 1.0).abs() < 1e-13, "{at:?}: {rate} {expected}");
    }
    assert_eq!(glow.same_axes, [0, 1, 0]);
    assert_eq!(glow.data_axes().count(), 2);
}

#[test]
fn a_batch_has_the_bits_of_each_point() {
    let fields = vec![("n", cube(4, linear)), ("T", cube(6, |[x, y, z]| 2.0 + x * y * z))];
    let glow = parse("n^2*exp(-a/T)*Twice(T)", fields, vec![("Twice", twice())]);
    let positions = points(2500);
    let batch = rates(&glow, &positions);
    for (at, rate) in positions.iter().zip(batch) {
        assert_eq!(rates(&glow, &[*at])[0].to_bits(), rate.to_bits());
    }
}

#[test]
fn outside_of_any_field_is_nothing_or_an_error() {
    let small = || {
        let nodes = || vec![0.0, 0.5];
        Grid::new([nodes(), nodes(), nodes()], vec![1.0; 8]).unwrap()
    };
    let outside = [[0.25, 0.25, 0.25], [0.75, 0.25, 0.25], [2.0, 0.0, 0.0]];
    // 1/n would be infinite where n is 0, and 5 is not.
    let glow = parse("5 + a/n + T", vec![("n", cube(3, |_| 1.0)), ("T", small())], vec![]);
    assert_eq!(rates(&glow, &outside), [8.0, 0.0, 0.0]);
    let strict = small().with_outside(Outside::Error);
    let glow = parse("n*T + a", vec![("n", cube(3, |_| 1.0)), ("T", strict)], vec![]);
    assert_eq!(
        try_rates(&glow, &outside).unwrap_err().to_string(),
        "the field `T`: the position [0.75, 0.25, 0.25] is outside the grid: its x is 0.75, \
         expected 0 to 0.5"
    );
    assert_eq!(glow.data_axes().count(), 1);
}

#[test]
fn outside_of_a_table_is_as_chosen() {
    let fields = || vec![("T", cube(2, |[x, ..]| 4.0 + x))];
    let at = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]];
    let glow = parse("a*Twice(T)", fields(), vec![("Twice", twice())]);
    assert_eq!(
        try_rates(&glow, &at).unwrap_err().to_string(),
        "at the position [0.5, 0.0, 0.0]: the argument `T` of `Twice` is 4.5: expected 1 to 4, the \
         range of the table"
    );
    // In a branch that is not taken it is no matter.
    let chosen = parse("a*if(T < 4, Twice(T), 7)", fields(), vec![("Twice", twice())]);
    assert_eq!(rates(&chosen, &at), [14.0, 14.0]);
    let zero = twice().with_beyond(BeyondTable::Zero);
    assert_eq!(rates(&parse("a*Z(T)", fields(), vec![("Z", zero)]), &at), [14.0, 0.0]);
    let edge = twice().with_beyond(BeyondTable::Edge);
    assert_eq!(rates(&parse("a*Z(T)", fields(), vec![("Z", edge)]), &at), [14.0, 16.0]);
}

#[test]
fn a_table_alone_is_of_the_position_and_the_energy() {
    let axes = ["E", "r"].map(|name| TableAxis::new(name, vec![0.0, 10.0])).to_vec();
    let table = Table::new(axes, vec![0.0, 1.0, 1.0, 2.0]).unwrap();
    let glow = parse("a*f(E, r)", vec![], vec![("f", table)]);
    assert_eq!(glow.energy_span(), Some(4..5));
    let mut rates = [0.0; 2];
    let samples = Samples::new(&[[3.0, 0.0, 4.0], [0.0; 3]], &[DIRECTION; 2]);
    glow.emission_rates(&samples.at_energies(&[2.0, 4.0]), &mut rates).unwrap();
    assert!((rates[0] - 2.0 * 0.7).abs() < 1e-15 && (rates[1] - 2.0 * 0.4).abs() < 1e-15);
}

#[test]
fn spherical_fields_are_interpolated_on_their_axes() {
    let (r, pi) = (vec![1.0, 2.0, 4.0], core::f64::consts::PI);
    let axes = GridAxes::new(Coordinates::Spherical, [r, vec![0.0, pi], vec![0.0]]).unwrap();
    let n = Grid::on(axes, vec![1.0, 2.0, 4.0, 1.0, 2.0, 4.0]).unwrap();
    let glow = parse("a*n - r", vec![("n", n)], vec![]);
    for (rate, at) in rates(&glow, &[[3.0, 0.0, 0.0], [0.0, -1.2, 0.9]]).iter().zip([3.0, 1.5]) {
        assert!((rate - at).abs() < 1e-14, "{rate}");
    }
}

#[test]
fn names_are_checked() {
    let n = || cube(2, linear);
    let message = |text: &str, field: &str, table: &str| {
        let error = try_parse(text, vec![(field, n())], vec![(table, twice())]).unwrap_err();
        let help = error.help().map(|help| format!(" ({help})")).unwrap_or_default();
        format!("{error}{help}")
    };
    let cases = [
        ("n", "r", "f", "the field `r` has the name of a variable"),
        ("n", "exp", "f", "the field `exp` has the name of a function"),
        ("n", "E", "f", "the field `E` has a reserved name: `E` is the energy"),
        ("n", "a", "f", "the field `a` has the name of a constant"),
        ("n", "n", "n", "the table `n` has the name of another field or table"),
        (
            "n",
            "n",
            "2f",
            "the table `2f` is not a name: expected letters, digits and underscores, a digit not \
             first",
        ),
        (
            "rha*f(n)",
            "rho",
            "f",
            "unknown name `rha`: did you mean `rho`? (known: x, y, z, dx, dy, dz, E, r, pi, a, rho)",
        ),
        ("n(2)", "n", "f", "`n` is not a function (a product is written with *: n*(…))"),
        ("n*f", "n", "f", "`f` is a table (arguments follow in parentheses: f(T))"),
        ("f(n, n)", "n", "f", "the table `f` takes 1 argument, not 2 (write f(T))"),
    ];
    for (text, field, table, expected) in cases {
        assert_eq!(message(text, field, table), expected, "{text}");
    }
    let unknown = message("Lamda(n)", "n", "Lambda");
    assert!(unknown.starts_with("unknown function `Lamda`: did you mean `Lambda`?"), "{unknown}");
    assert!(unknown.ends_with("erf, floor, Lambda)"), "{unknown}");
    let unused = parse("x", vec![("n", n())], vec![("f", twice())]);
    assert_eq!(unused.unused_names(), ["a", "n", "f"]);
}

#[test]
fn derivatives_go_through_fields_and_tables() {
    let table = Table::new(vec![TableAxis::new("T", vec![0.5, 8.0]).logarithmic()], vec![0.5, 8.0])
        .and_then(Table::with_logarithmic_values)
        .unwrap(); // T itself
    let inputs = Inputs::new(
        ["n", "T"].map(str::to_owned).to_vec(),
        vec![("f".to_owned(), Arc::new(table))],
    );
    let constants = BTreeMap::from([("a".to_owned(), 1.5), ("b".to_owned(), 0.5)]);
    let glow =
        DifferentiableExpression::with_inputs("a^2*n*f(a*T + b)", &constants, &["a", "b"], &inputs)
            .unwrap();
    let samples = Samples::new(&[[0.0; 3]; 2], &[DIRECTION; 2]);
    let (n, t) = ([2.0, 3.0], [1.0, 4.0]);
    let (mut rates, mut slopes) = ([0.0; 2], [0.0; 4]);
    glow.rates_and_derivatives_of(&samples, &[&n, &t], &mut rates, &mut slopes).unwrap();
    for i in 0..2 {
        let (a, b) = (1.5, 0.5);
        let inner: f64 = a * t[i] + b;
        assert!((rates[i] / (a * a * n[i] * inner) - 1.0).abs() < 1e-14);
        let by_a = 2.0 * a * n[i] * inner + a * a * n[i] * t[i];
        assert!((slopes[i] / by_a - 1.0).abs() < 1e-13);
        assert!((slopes[2 + i] / (a * a * n[i]) - 1.0).abs() < 1e-13);
    }
    let beyond =
        glow.rates_and_derivatives_of(&samples, &[&n, &[1.0, 9.0]], &mut rates, &mut slopes);
    let message = beyond.unwrap_err().to_string();
    assert!(message.contains("the argument `T` of `f` is 14: expected 0.5 to 8"), "{message}");
}

#[test]
fn without_inputs_it_is_the_expression() {
    let text = "if(x < y, exp(-r^2)*sin(x*y), atan2(z, x) + dx)/(1 + x^5)";
    let plain = Expression::parse(text, &BTreeMap::new()).unwrap();
    let with = FieldExpression::parse(text, &BTreeMap::new(), vec![], vec![]).unwrap();
    let positions = points(700);
    let directions = vec![DIRECTION; 700];
    let mut of_plain = vec![0.0; 700];
    plain.emission_rates(&Samples::new(&positions, &directions), &mut of_plain).unwrap();
    assert_eq!(rates(&with, &positions), of_plain);
}
