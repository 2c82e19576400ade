//! Dual numbers: a value and its derivative by one parameter.

use super::Scalar;
use crate::elementary::{self, Elementary};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// A number and its derivative by one parameter. Its value is that of the same operations on plain numbers, to
/// the last bit.
///
/// A derivative of 0 stays 0 wherever a function is not differentiable: a number that does not depend on the
/// parameter has no derivative that is not a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dual {
    pub(crate) value: f64,
    pub(crate) derivative: f64,
}

/// slope · derivative, 0 where the derivative is 0, whatever the slope.
#[inline(always)]
fn chained(slope: f64, derivative: f64) -> f64 {
    if derivative == 0.0 { 0.0 } else { slope * derivative }
}

impl Dual {
    /// xʸ of the two numbers, whose power is given.
    fn power(self, exponent: Self, power: impl Fn(f64, f64) -> f64) -> Self {
        let (x, y) = (self.value, exponent.value);
        let value = power(x, y);
        // y x^(y − 1) is 0 for y = 0, and xʸ ln x has the limit 0 where xʸ is 0.
        let of_base = if y == 0.0 { 0.0 } else { y * power(x, y - 1.0) };
        let of_exponent = if value == 0.0 { 0.0 } else { value * x.ln() };
        let derivative =
            chained(of_base, self.derivative) + chained(of_exponent, exponent.derivative);
        Self { value, derivative }
    }
}

impl Scalar for Dual {
    fn of(value: f64) -> Self {
        Self { value, derivative: 0.0 }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn map(self, function: impl Fn(f64) -> f64, slope: impl Fn(f64, f64) -> f64) -> Self {
        let value = function(self.value);
        Self { value, derivative: chained(slope(self.value, value), self.derivative) }
    }

    fn powf(self, exponent: Self) -> Self {
        self.power(exponent, f64::powf)
    }

    fn apply(function: Elementary, numbers: &mut [Self]) {
        for x in numbers {
            *x = match function {
                Elementary::Exp => x.map(elementary::exp, |_, value| value),
                Elementary::Ln => x.map(elementary::ln, |x, _| 1.0 / x),
                Elementary::Log10 => {
                    x.map(elementary::log10, |x, _| core::f64::consts::LOG10_E / x)
                }
                Elementary::Sin => x.map(elementary::sin, |x, _| elementary::cos(x)),
                Elementary::Cos => x.map(elementary::cos, |x, _| -elementary::sin(x)),
            };
        }
    }

    fn raise_all(numbers: &mut [Self], exponent: Self) {
        for x in numbers {
            *x = x.power(exponent, elementary::pow);
        }
    }
}

impl Add for Dual {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, derivative: self.derivative + other.derivative }
    }
}

impl Sub for Dual {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, derivative: self.derivative - other.derivative }
    }
}

impl Mul for Dual {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let derivative =
            chained(other.value, self.derivative) + chained(self.value, other.derivative);
        Self { value: self.value * other.value, derivative }
    }
}

impl Div for Dual {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        // (da − (a/b) db)/b
        let value = self.value / other.value;
        let numerator = self.derivative - chained(value, other.derivative);
        let derivative = if numerator == 0.0 { 0.0 } else { numerator / other.value };
        Self { value, derivative }
    }
}

impl Neg for Dual {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, derivative: -self.derivative }
    }
}

impl Add<f64> for Dual {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        self + Self::of(other)
    }
}

impl Sub<f64> for Dual {
    type Output = Self;

    fn sub(self, other: f64) -> Self {
        self - Self::of(other)
    }
}

impl Mul<f64> for Dual {
    type Output = Self;

    fn mul(self, other: f64) -> Self {
        self * Self::of(other)
    }
}

impl Div<f64> for Dual {
    type Output = Self;

    fn div(self, other: f64) -> Self {
        self / Self::of(other)
    }
}
