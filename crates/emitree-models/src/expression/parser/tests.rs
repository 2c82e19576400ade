//! The grammar and the text of every failure.

use super::*;

fn parse(text: &str, constants: &BTreeMap<String, f64>) -> Result<Parsed, ExpressionError> {
    super::parse(text, constants, &[], &Inputs::default())
}

/// The value of an expression without variables; a = 3, b = 5.
fn value(text: &str) -> f64 {
    let constants = BTreeMap::from([("a".to_owned(), 3.0), ("b".to_owned(), 5.0)]);
    let parsed = parse(text, &constants).unwrap_or_else(|error| panic!("{text}: {error}"));
    parsed.graph.value(parsed.root).unwrap()
}

/// The message, the text that the span covers, and the help.
fn failure(text: &str) -> (String, String, String) {
    let constants = BTreeMap::from([("alpha".to_owned(), 3.0)]);
    let error = parse(text, &constants).unwrap_err();
    let help = error.help().unwrap_or_default().to_owned();
    (error.message().to_owned(), text[error.span()].to_owned(), help)
}

fn assert_failure(text: &str, message: &str, at: &str, help: &str) {
    let expected = (message.to_owned(), at.to_owned(), help.to_owned());
    assert_eq!(failure(text), expected, "{text}");
}

fn refused_constant(name: &str, value: f64) -> String {
    let constants = BTreeMap::from([(name.to_owned(), value)]);
    let error = parse("1", &constants).unwrap_err();
    assert_eq!(error.span(), 0..0);
    error.message().to_owned()
}

#[test]
fn precedence() {
    let table = [
        ("1 + 2*3", 7.0),
        ("(1 + 2)*3", 9.0),
        ("10 - 4 - 3", 3.0),
        ("10 - (4 - 3)", 9.0),
        ("24/4/2", 3.0),
        ("24/4*2", 12.0),
        ("2^3^2", 512.0),
        ("(2^3)^2", 64.0),
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^-3", 0.125),
        ("2^-2^2", 0.0625),
        ("2^-3*4", 0.5),
        ("2*-3", -6.0),
        ("2 - -3", 5.0),
        ("--2", 2.0),
        ("+2", 2.0),
        ("-a*b", -15.0),
        ("-a^2/b", -1.8),
        ("1 + 1 < 3", 1.0),
        ("1 < 2 + (3 > 4)", 1.0),
        ("2 >= 2", 1.0),
        ("2 > 2", 0.0),
        ("2 <= 1", 0.0),
        ("1 == 1", 1.0),
        ("1 != 1", 0.0),
        ("a - b != b - a", 1.0),
        ("-1 < -2", 0.0),
        ("if(a < b, a, b)", 3.0),
        ("if(a > b, a, b)", 5.0),
        ("if(-0.5, 1, 2)", 1.0),
        ("min(4, 2, 3)", 2.0),
        ("max(4, 2, 3, 9, 1)", 9.0),
        ("2*pi", 2.0 * PI),
        ("atan2(1, -1)", 0.75 * PI),
        ("1_000*1e-3", 1.0),
    ];
    for (text, expected) in table {
        assert!((value(text) - expected).abs() < 1e-15, "{text} = {}", value(text));
    }
}

#[test]
fn unknown_names() {
    let known = "known: x, y, z, dx, dy, dz, E, r, pi, alpha";
    assert_failure("1 + aplha*x", "unknown name `aplha`: did you mean `alpha`?", "aplha", known);
    assert_failure("X", "unknown name `X`: did you mean `x`?", "X", known);
    assert_failure("theta", "unknown name `theta`", "theta", known);
    assert_failure("dE", "unknown name `dE`: did you mean `dx`?", "dE", known);
    let message = "unknown name `e`: write exp(1), or E for the energy";
    assert_failure("e^x", message, "e", known);
    let functions = "known: if, min, max, abs, sqrt, exp, ln, log10, sin, cos, tan, asin, acos, \
                     atan, atan2, sinh, cosh, tanh, erf, floor";
    let message = "unknown function `sqr`: did you mean `sqrt`?";
    assert_failure("2*sqr(x)", message, "sqr", functions);
    let message = "unknown function `log`: write `ln` or `log10`";
    assert_failure("log(x)", message, "log", functions);
    assert_failure("pow(x, 2)", "unknown function `pow`: write a^b", "pow", functions);
}

#[test]
fn the_first_energy_has_its_place() {
    let place = |text| parse(text, &BTreeMap::new()).unwrap().energy_span;
    assert_eq!(place("x*E"), Some(2..3));
    assert_eq!(place("2*exp(E) - E"), Some(6..7));
    assert_eq!(place("1e3*x + 2E0"), None);
    // Where it stands, though nothing comes of it.
    assert_eq!(place("if(1 < 2, x, E) + E"), Some(13..14));
}

#[test]
fn functions_and_values_are_not_confused() {
    let help = "arguments follow in parentheses: sin(…)";
    assert_failure("sin x", "`sin` is a function", "sin", help);
    let help = "a product is written with *: x*(…)";
    assert_failure("x(y)", "`x` is not a function", "x", help);
    let help = "a product is written with *: E*(…)";
    assert_failure("E(y)", "`E` is not a function", "E", help);
    let help = "a product is written with *: alpha*(…)";
    assert_failure("alpha(y)", "`alpha` is not a function", "alpha", help);
}

#[test]
fn numbers_of_arguments() {
    let case = |text, message, help| assert_failure(text, message, text, help);
    case("sin()", "`sin` takes 1 argument, not 0", "write sin(x)");
    case("exp(x, y)", "`exp` takes 1 argument, not 2", "write exp(x)");
    case("atan2(y)", "`atan2` takes 2 arguments, not 1", "write atan2(y, x)");
    case("min(x)", "`min` takes 2 or more arguments, not 1", "write min(x, y)");
    let help = "write if(condition, then, otherwise)";
    case("if(x > 0, 1)", "`if` takes 3 arguments, not 2", help);
    let message = "`sin` takes 1 argument, not 0";
    assert_failure("1 + sin( )*2", message, "sin( )", "write sin(x)");
}

#[test]
fn parentheses() {
    let never_closed = "unbalanced parenthesis: this `(` is never closed";
    assert_failure("2*(x + (y - 1)", never_closed, "(", "");
    assert_eq!(parse("2*(x + (y", &BTreeMap::new()).unwrap_err().span(), 7..8);
    assert_failure("sin(x", never_closed, "(", "");
    let message = "unbalanced parenthesis: this `)` closes nothing";
    assert_failure("x + 1)", message, ")", "");
    assert_failure("()", "expected a value, found `)`", ")", "");
}

#[test]
fn missing_values_and_operators() {
    assert_failure("", "the expression is empty", "", "");
    assert_failure("  ", "the expression is empty", "  ", "");
    assert_failure("x +", "expected a value, found the end of the expression", "", "");
    assert_failure("x */ y", "expected a value, found `/`", "/", "");
    let help = "powers are written with ^, not **";
    assert_failure("x**2", "expected a value, found `*`", "*", help);
    assert_failure("min(x, )", "expected a value, found `)`", ")", "");
    let help = "a product is written with *";
    assert_failure("2x", "expected an operator, found `x`", "x", help);
    assert_failure("(x)(y)", "expected an operator, found `(`", "(", help);
    assert_failure("sin(2 x)", "expected an operator, found `x`", "x", help);
    let help = "commas only separate the arguments of a function";
    assert_failure("x, y", "expected an operator, found `,`", ",", help);
    assert_failure("(x, y)", "expected an operator, found `,`", ",", help);
}

#[test]
fn characters_and_comparisons() {
    assert_failure("x # y", "unexpected character `#`", "#", "");
    assert_failure("x = y", "unexpected character `=`", "=", "to compare, write ==");
    let help = "multiply them: (0 < x) * (x < 1)";
    assert_failure("0 < x < 1", "comparisons do not chain", "<", help);
    assert_failure("x == y != z", "comparisons do not chain", "!=", help);
}

#[test]
fn constants_have_names_of_their_own() {
    assert_eq!(refused_constant("x", 1.0), "the constant `x` has the name of a variable");
    assert_eq!(refused_constant("r", 1.0), "the constant `r` has the name of a variable");
    assert_eq!(refused_constant("dz", 1.0), "the constant `dz` has the name of a variable");
    assert_eq!(refused_constant("erf", 1.0), "the constant `erf` has the name of a function");
    assert_eq!(refused_constant("pi", 3.0), "the constant `pi` has the name of the number pi");
    let message = "the constant `E` has a reserved name: `E` is the energy";
    assert_eq!(refused_constant("E", 1.0), message);
    let message = "the constant `2a` is not a name: expected letters, digits and underscores, a \
                   digit not first";
    assert_eq!(refused_constant("2a", 1.0), message);
    assert_eq!(refused_constant("k", f64::NAN), "the constant `k` is not a finite number");
}

#[test]
fn deep_nesting_is_refused() {
    let nested = |depth: usize| format!("{}x{}", "(".repeat(depth), ")".repeat(depth));
    assert!(parse(&nested(MAX_NESTING - 1), &BTreeMap::new()).is_ok());
    let deep = [
        nested(MAX_NESTING),
        nested(100_000),
        "-".repeat(100_000) + "x",
        "2^".repeat(100_000) + "x",
        "sin(".repeat(100_000),
        "if(x,".repeat(100_000),
    ];
    for text in deep {
        let error = parse(&text, &BTreeMap::new()).unwrap_err();
        assert_eq!(error.message(), "nested more than 128 deep");
    }
}

#[test]
fn long_is_not_deep() {
    let sum = vec!["x"; 10_000].join(" + ");
    assert!(parse(&sum, &BTreeMap::new()).is_ok());
}
