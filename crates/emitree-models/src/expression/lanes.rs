//! Operations on all samples of a block at once.
//!
//! Each is written as a loop of which the compiler makes vector instructions, and compiled once for
//! every set of instructions that a machine may have. The loops stand in functions of their own that
//! are always inlined: a closure in a function for certain machines is one for those machines only, and
//! is not inlined elsewhere.

use super::operation::{Binary, Unary, equal, larger, smaller, truth};
use crate::elementary::{apply, raise_all, raise_each};
use multiversion::multiversion;

/// An operand over a block: a value for each sample, or the same for all.
#[derive(Clone, Copy)]
pub(super) enum Lanes<'a> {
    Each(&'a [f64]),
    Same(f64),
}

impl Lanes<'_> {
    /// The value of one sample.
    pub(super) fn at(self, lane: usize) -> f64 {
        match self {
            Self::Each(values) => values[lane],
            Self::Same(value) => value,
        }
    }
}

/// A component of all vectors.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn load(out: &mut [f64], vectors: &[[f64; 3]], axis: u8) {
    let axis = usize::from(axis);
    for (out, vector) in out.iter_mut().zip(vectors) {
        *out = vector[axis];
    }
}

/// The operand's own values.
pub(super) fn copy(out: &mut [f64], from: Lanes<'_>) {
    match from {
        Lanes::Each(values) => out.copy_from_slice(values),
        Lanes::Same(value) => out.fill(value),
    }
}

/// Writes an operation's values to `out`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn unary(operation: Unary, out: &mut [f64], a: Lanes<'_>) {
    unary_loop(operation, out, a);
}

#[inline(always)]
fn unary_loop(operation: Unary, out: &mut [f64], a: Lanes<'_>) {
    match operation {
        Unary::Negate => map(out, a, |a| -a),
        Unary::Abs => map(out, a, f64::abs),
        Unary::Sqrt => map(out, a, f64::sqrt),
        _ => match operation.elementary() {
            Some(function) => {
                copy(out, a);
                apply(function, out);
            }
            None => map(out, a, operation.scalar()),
        },
    }
}

/// Writes an operation's values to `out`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn binary(operation: Binary, out: &mut [f64], a: Lanes<'_>, b: Lanes<'_>) {
    binary_loop(operation, out, a, b);
}

#[inline(always)]
fn binary_loop(operation: Binary, out: &mut [f64], a: Lanes<'_>, b: Lanes<'_>) {
    match operation {
        Binary::Add => map2(out, a, b, |a, b| a + b),
        Binary::Subtract => map2(out, a, b, |a, b| a - b),
        Binary::Multiply => map2(out, a, b, |a, b| a * b),
        Binary::Divide => map2(out, a, b, |a, b| a / b),
        Binary::Min => map2(out, a, b, smaller),
        Binary::Max => map2(out, a, b, larger),
        Binary::Less => map2(out, a, b, |a, b| truth(a < b)),
        Binary::LessEqual => map2(out, a, b, |a, b| truth(a <= b)),
        Binary::Equal => map2(out, a, b, equal),
        Binary::NotEqual => map2(out, a, b, |a, b| 1.0 - equal(a, b)),
        Binary::Power => {
            copy(out, a);
            match b {
                Lanes::Each(exponents) => raise_each(out, exponents),
                Lanes::Same(exponent) => raise_all(out, exponent),
            }
        }
        Binary::Atan2 => map2(out, a, b, operation.scalar()),
    }
}

#[inline(always)]
fn map(out: &mut [f64], a: Lanes<'_>, f: impl Fn(f64) -> f64) {
    match a {
        Lanes::Each(a) => {
            for (out, &a) in out.iter_mut().zip(a) {
                *out = f(a);
            }
        }
        Lanes::Same(a) => out.fill(f(a)),
    }
}

#[inline(always)]
fn map2(out: &mut [f64], a: Lanes<'_>, b: Lanes<'_>, f: impl Fn(f64, f64) -> f64) {
    match (a, b) {
        (Lanes::Each(a), Lanes::Each(b)) => {
            for (out, (&a, &b)) in out.iter_mut().zip(a.iter().zip(b)) {
                *out = f(a, b);
            }
        }
        (_, Lanes::Same(b)) => map(out, a, |a| f(a, b)),
        (Lanes::Same(a), _) => map(out, b, |b| f(a, b)),
    }
}

/// Replaces the values where the condition holds.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn replace_where(out: &mut [f64], condition: Lanes<'_>, then: Lanes<'_>) {
    replace_loop(out, condition, then);
}

#[inline(always)]
fn choose(condition: f64, then: f64, otherwise: f64) -> f64 {
    if condition == 0.0 { otherwise } else { then }
}

#[inline(always)]
fn replace_loop(out: &mut [f64], condition: Lanes<'_>, then: Lanes<'_>) {
    match (condition, then) {
        (Lanes::Each(condition), Lanes::Each(then)) => {
            for (out, (&condition, &then)) in out.iter_mut().zip(condition.iter().zip(then)) {
                *out = choose(condition, then, *out);
            }
        }
        (Lanes::Each(condition), Lanes::Same(then)) => {
            for (out, &condition) in out.iter_mut().zip(condition) {
                *out = choose(condition, then, *out);
            }
        }
        (Lanes::Same(condition), _) => {
            if condition != 0.0 {
                copy(out, then);
            }
        }
    }
}
