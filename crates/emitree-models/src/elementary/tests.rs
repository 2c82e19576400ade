//! Accuracy against 60 digits and against the standard library, the borders, and the same bits in any
//! batch.

use super::*;
use proptest::prelude::*;

/// Values in 60 digits, by `tests/reference/elementary.py`.
const REFERENCE: &str = include_str!("../../tests/reference/elementary.csv");

/// Numbers to a batch: full vectors of every width, and a rest.
const BATCH: usize = 61;

/// A function of one number in all its forms, and the largest errors that are allowed.
struct Case {
    name: &'static str,
    one: fn(f64) -> f64,
    many: Elementary,
    standard: fn(f64) -> f64,
    /// In units in the last place, from the exact value.
    bound: f64,
    /// The same from the standard library's, which has an error too.
    apart: u64,
}

const CASES: [Case; 5] = [
    Case { name: "exp", one: exp, many: Elementary::Exp, standard: f64::exp, bound: 0.8, apart: 1 },
    Case { name: "ln", one: ln, many: Elementary::Ln, standard: f64::ln, bound: 0.9, apart: 1 },
    Case {
        name: "log10",
        one: log10,
        many: Elementary::Log10,
        standard: f64::log10,
        bound: 0.9,
        apart: 2,
    },
    Case { name: "sin", one: sin, many: Elementary::Sin, standard: f64::sin, bound: 1.6, apart: 2 },
    Case { name: "cos", one: cos, many: Elementary::Cos, standard: f64::cos, bound: 1.6, apart: 2 },
];
/// Likewise, of powers and of angles.
const POWER_BOUND: f64 = 1.0;
const ANGLE_BOUND: f64 = 2.0;

/// Numbers of type f64 in their order, 0 and −0 the same.
#[expect(clippy::cast_possible_wrap, reason = "the sign bit becomes a sign")]
fn order(x: f64) -> i64 {
    let magnitude = (x.to_bits() & !(1 << 63)) as i64;
    if x.is_sign_negative() { -magnitude } else { magnitude }
}

/// How many numbers of type f64 apart, or as many as there are if just one is NaN.
fn distance(a: f64, b: f64) -> u64 {
    match (a.is_nan(), b.is_nan()) {
        (true, true) => 0,
        (false, false) => order(a).abs_diff(order(b)),
        _ => u64::MAX,
    }
}

fn number(bits: &str) -> f64 {
    f64::from_bits(u64::from_str_radix(bits, 16).unwrap())
}

#[test]
fn errors_in_the_last_place() {
    let mut rows = 0;
    for line in REFERENCE.lines().skip(1) {
        let [name, x, y, nearest, offset] = line.split(',').collect::<Vec<_>>().try_into().unwrap();
        let (x, y, nearest) = (number(x), number(y), number(nearest));
        let (value, bound) = match CASES.iter().find(|case| case.name == name) {
            Some(case) => ((case.one)(x), case.bound),
            None if name == "atan2" => (atan2(x, y), ANGLE_BOUND),
            None => (pow(x, y), POWER_BOUND),
        };
        let error = (order(value) - order(nearest)) as f64 - offset.parse::<f64>().unwrap();
        assert!(error.abs() <= bound, "{name}({x:e}, {y}): {error} units");
        rows += 1;
    }
    assert_eq!(rows, 3245);
}

/// 100,000 numbers of all sizes and signs, by their bits, and as many in ±20.
fn numbers() -> impl Iterator<Item = f64> {
    let of_all_sizes = |i: u64| f64::from_bits(i.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let ordinary = |i: u64| 40.0 * (i as f64 * 0.618_033_988_749_894_9).fract() - 20.0;
    (0..100_000).flat_map(move |i| [of_all_sizes(i), ordinary(i)]).filter(|x| !x.is_nan())
}

#[test]
fn as_in_the_standard_library() {
    for case in CASES {
        for x in numbers() {
            let (value, expected) = ((case.one)(x), (case.standard)(x));
            let apart = distance(value, expected);
            assert!(apart <= case.apart, "{}({x:e}) = {value:e}, {expected:e}", case.name);
        }
    }
    for (x, y) in numbers().zip(numbers().skip(1)) {
        for (x, y) in [(x.abs(), y), (x, y.round()), (1.0 + 1e-3 * y, x)] {
            let (value, expected) = (pow(x, y), x.powf(y));
            assert!(distance(value, expected) <= 1, "{x:e}^{y:e} = {value:e}, {expected:e}");
        }
    }
}

#[test]
fn the_borders_are_those_of_the_standard_library() {
    let least = f64::from_bits(1);
    let borders = [0.0, least, f64::MIN_POSITIVE, 0.5, 1.0, 2.0, 3.0, f64::MAX, f64::INFINITY];
    let signed = borders.into_iter().flat_map(|x| [x, -x]).chain([f64::NAN]);
    let signed: Vec<f64> = signed.collect();
    for case in CASES {
        for &x in &signed {
            let (value, expected) = ((case.one)(x), (case.standard)(x));
            assert!(distance(value, expected) <= case.apart, "{}({x:e}): {value:e}", case.name);
        }
    }
    for &x in &signed {
        for &y in &signed {
            assert!(distance(pow(x, y), x.powf(y)) <= 1, "{x:e}^{y:e}: {:e}", pow(x, y));
        }
    }
    let same = |a: f64, b: f64| a.to_bits() == b.to_bits();
    assert!(same(sin(-0.0), -0.0) && same(sin(0.0), 0.0) && same(sin(-least), -least));
    assert!(same(exp(709.8), f64::INFINITY) && same(exp(-745.2), 0.0) && same(exp(-745.1), least));
    assert!(same(pow(-8.0, 3.0), -512.0) && pow(-8.0, 0.5).is_nan());
    assert!((-300..=300).all(|k| same(log10(format!("1e{k}").parse().unwrap()), f64::from(k))));
}

#[test]
fn angles_are_those_of_the_standard_library() {
    for (x, y) in numbers().zip(numbers().skip(1)) {
        // Twice the largest number is infinite.
        let (x, y) = (x.clamp(-1e307, 1e307), y.clamp(-1e307, 1e307));
        for (x, y) in [(x, y), (x, 1.0), (1e-3 * y, y), (y, -y), (x, (1.0 + 1e-9) * x)] {
            let apart = distance(atan2(y, x), y.atan2(x));
            // The smallest have no bits for the ratio.
            assert!(apart <= 2, "atan2({y:e}, {x:e}) = {:e}, {:e}", atan2(y, x), y.atan2(x));
        }
    }
    let borders = [0.0, 5e-324, 1e-300, 0.5, 1.0, 3.0, 1e300, f64::INFINITY];
    for (x, y) in borders.iter().flat_map(|x| borders.map(|y| (*x, y))) {
        for (x, y) in [(x, y), (-x, y), (x, -y), (-x, -y)] {
            let expected = if x.is_infinite() && y.is_infinite() { f64::NAN } else { y.atan2(x) };
            assert!(distance(atan2(y, x), expected) <= 1, "atan2({y}, {x}) = {}", atan2(y, x));
            if y.abs() <= 0.0 {
                assert!(same_bits(atan2(y, x), y.atan2(x)), "atan2({y}, {x})");
            }
        }
    }
    assert!(atan2(f64::NAN, 1.0).is_nan() && atan2(1.0, f64::NAN).is_nan());
}

#[test]
fn large_angles_keep_all_their_digits() {
    for x in [1e5, 1.000_000_000_000_000_2e5, 1e10, 3e15, 1e300] {
        assert!(distance(sin(x), x.sin()) <= 1 && distance(cos(x), x.cos()) <= 1, "{x:e}");
    }
}

/// Ordinary numbers, and one in eight of any kind.
fn any_numbers() -> impl Strategy<Value = Vec<f64>> {
    let one = prop_oneof![3 => -20.0..20.0, 4 => 0.0..2.0, 1 => proptest::num::f64::ANY];
    prop_oneof![
        proptest::collection::vec(one, 0..BATCH),
        proptest::collection::vec(1e-3..100.0, 0..BATCH),
    ]
}

fn same_bits(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

proptest! {
    /// One by one they are compiled for the least of machines, in batches for this one.
    #[test]
    fn in_any_batch_the_same_bits(numbers in any_numbers()) {
        for case in CASES {
            let mut values = numbers.clone();
            apply(case.many, &mut values);
            for (&x, value) in numbers.iter().zip(values) {
                prop_assert!(same_bits((case.one)(x), value), "{}({:e})", case.name, x);
            }
        }
    }

    #[test]
    fn powers_in_any_batch_have_the_same_bits(
        numbers in any_numbers(),
        exponents in proptest::collection::vec(-9.0..9.0, BATCH),
    ) {
        let (mut of_each, mut of_all) = (numbers.clone(), numbers.clone());
        raise_each(&mut of_each, &exponents);
        raise_all(&mut of_all, exponents[0]);
        for (i, &x) in numbers.iter().enumerate() {
            prop_assert!(same_bits(of_each[i], pow(x, exponents[i])), "{:e}^{}", x, exponents[i]);
            prop_assert!(same_bits(of_all[i], pow(x, exponents[0])), "{:e}^{}", x, exponents[0]);
        }
    }

    #[test]
    fn sines_are_odd_and_cosines_even(x in any::<f64>()) {
        prop_assert!(same_bits(sin(-x), -sin(x)) && same_bits(cos(-x), cos(x)));
    }
}
