//! exp, ln, log₁₀, sin, cos, powers and angles of many numbers at once.
//!
//! # Same bits everywhere
//!
//! Each is one formula of additions, multiplications, divisions and bits, without a branch: the
//! compiler makes vector instructions of it, for the instructions that the machine turns out to have
//! (`multiversion`). All of them round as IEEE 754 has it and none is fused with another, so that a
//! value has the same bits on every machine, on its own as in a batch.
//!
//! # Accuracy
//!
//! Within 1 unit in the last place of the exact value, sin, cos and angles within 2; the files say more
//! closely. 0, subnormal numbers, infinities and NaN are as in the standard library. Angles beyond
//! 10⁵ are left to the crate `libm`, one at a time.

mod arctangent;
mod exponential;
mod logarithm;
mod power;
mod sine;

use multiversion::multiversion;
use sine::LARGEST_ANGLE;

/// Added to a number below 2⁵¹ it leaves the nearest integer in the lowest bits: 1.5 · 2⁵².
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// eˣ.
#[inline]
pub(crate) fn exp(x: f64) -> f64 {
    exponential::exp(x)
}

/// ln x.
#[inline]
pub(crate) fn ln(x: f64) -> f64 {
    logarithm::ln(x)
}

/// log₁₀ x.
#[inline]
pub(crate) fn log10(x: f64) -> f64 {
    logarithm::log10(x)
}

/// sin x.
#[inline]
pub(crate) fn sin(x: f64) -> f64 {
    if is_large(x) { libm::sin(x) } else { sine::sin(x) }
}

/// cos x.
#[inline]
pub(crate) fn cos(x: f64) -> f64 {
    if is_large(x) { libm::cos(x) } else { sine::cos(x) }
}

/// xʸ.
#[inline]
pub(crate) fn pow(x: f64, y: f64) -> f64 {
    if power::is_ordinary(x, y) { power::pow(x, y) } else { libm::pow(x, y) }
}

/// The angle of the point (x, y) from the x axis, −π to π.
#[inline(always)]
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    arctangent::atan2(y, x)
}

/// An angle to be left to `libm`; a NaN is none.
#[inline(always)]
fn is_large(angle: f64) -> bool {
    angle.abs() > LARGEST_ANGLE
}

/// A function of one number, for [`apply`]; not exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elementary {
    /// eˣ
    Exp,
    /// ln x
    Ln,
    /// log₁₀ x
    Log10,
    /// sin x
    Sin,
    /// cos x
    Cos,
}

/// Replaces all numbers by a function of them.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn apply(function: Elementary, numbers: &mut [f64]) {
    match function {
        Elementary::Exp => replace(numbers, exponential::exp),
        Elementary::Ln => replace(numbers, logarithm::ln),
        Elementary::Log10 => replace(numbers, logarithm::log10),
        Elementary::Sin if any_is_large(numbers) => replace(numbers, sin),
        Elementary::Sin => replace(numbers, sine::sin),
        Elementary::Cos if any_is_large(numbers) => replace(numbers, cos),
        Elementary::Cos => replace(numbers, sine::cos),
    }
}

/// Replaces all numbers by their powers with the same exponent.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn raise_all(numbers: &mut [f64], exponent: f64) {
    raise(numbers, core::iter::repeat(&exponent));
}

/// Replaces each number by its power with its own exponent.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn raise_each(numbers: &mut [f64], exponents: &[f64]) {
    raise(numbers, exponents.iter());
}

#[inline(always)]
fn raise<'a>(numbers: &mut [f64], exponents: impl Iterator<Item = &'a f64> + Clone) {
    let mut ordinary = true;
    for (&x, &y) in numbers.iter().zip(exponents.clone()) {
        ordinary &= power::is_ordinary(x, y);
    }
    if ordinary {
        for (x, &y) in numbers.iter_mut().zip(exponents) {
            *x = power::pow(*x, y);
        }
    } else {
        for (x, &y) in numbers.iter_mut().zip(exponents) {
            *x = pow(*x, y);
        }
    }
}

/// A loop that is inlined where it is called, and then made of the instructions chosen there.
#[inline(always)]
fn replace(numbers: &mut [f64], function: impl Fn(f64) -> f64) {
    for x in numbers {
        *x = function(*x);
    }
}

#[inline(always)]
fn any_is_large(angles: &[f64]) -> bool {
    let mut any = false;
    for &angle in angles {
        any |= is_large(angle);
    }
    any
}

#[cfg(test)]
mod tests;
