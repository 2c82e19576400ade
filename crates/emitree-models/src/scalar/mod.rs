//! Numbers over which the formulas of models are written once: plain ones, or with a derivative.
//!
//! A formula of [`Scalar`] is compiled for `f64`, where it is the same operations as without, and for
//! [`Dual`], which has a derivative beside each number (forward differentiation). The functions of `f64` are
//! this crate's own and those of the standard library: no crate of dual numbers has them, nor blocks.

mod digamma;
mod dual;
mod plain;

pub(crate) use digamma::digamma;
pub(crate) use dual::Dual;

use crate::elementary::Elementary;
use core::fmt;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// A number of a formula; public as a bound of public types alone, and not exported. Comparisons are those of its [`value`](Self::value): a formula with branches has the
/// derivative of the branch that is taken.
pub trait Scalar:
    Copy
    + fmt::Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// A constant.
    fn of(value: f64) -> Self;

    /// The number without its derivative.
    fn value(self) -> f64;

    /// A function of it, and the slope of the function from the argument and the value.
    fn map(self, function: impl Fn(f64) -> f64, slope: impl Fn(f64, f64) -> f64) -> Self;

    /// xʸ of the standard library.
    fn powf(self, exponent: Self) -> Self;

    /// Replaces all numbers by a function of them.
    fn apply(function: Elementary, numbers: &mut [Self]);

    /// Replaces all numbers by their powers with the same exponent.
    fn raise_all(numbers: &mut [Self], exponent: Self);

    /// √x; its derivative is 0 where that of x is, also at 0.
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt, |_, root| 0.5 / root)
    }

    /// eˣ
    #[inline(always)]
    fn exp(self) -> Self {
        self.map(f64::exp, |_, value| value)
    }

    /// eˣ − 1
    #[inline(always)]
    fn exp_m1(self) -> Self {
        self.map(f64::exp_m1, |x, _| x.exp())
    }

    /// ln x
    #[inline(always)]
    fn ln(self) -> Self {
        self.map(f64::ln, |x, _| 1.0 / x)
    }

    /// ln(1 + x)
    #[inline(always)]
    fn ln_1p(self) -> Self {
        self.map(f64::ln_1p, |x, _| 1.0 / (1.0 + x))
    }

    /// xⁿ
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        self.map(|x| x.powi(exponent), |x, _| f64::from(exponent) * x.powi(exponent - 1))
    }
}
