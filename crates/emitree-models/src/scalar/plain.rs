//! Plain numbers.

use super::Scalar;
use crate::elementary::{self, Elementary};

impl Scalar for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn map(self, function: impl Fn(Self) -> Self, _: impl Fn(Self, Self) -> Self) -> Self {
        function(self)
    }

    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        self.powf(exponent)
    }

    fn apply(function: Elementary, numbers: &mut [Self]) {
        elementary::apply(function, numbers);
    }

    fn raise_all(numbers: &mut [Self], exponent: Self) {
        elementary::raise_all(numbers, exponent);
    }
}
