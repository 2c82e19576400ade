//! Densities of halos as functions of the distance in scale radii.

use crate::elementary::Elementary;
use crate::scalar::Scalar;

/// Closer to a cusp the density does not rise, so that its square is a number, with any usual unit.
const LEAST_X: f64 = 1e-140;

/// How the density of a halo falls with x, the distance in scale radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Profile<T = f64> {
    /// 1/\[x (1 + x)²\].
    Nfw,
    /// exp\[−(2/α)(x^α − 1)\].
    Einasto { alpha: T },
    /// 1/\[(1 + x)(1 + x²)\].
    Burkert,
}

impl<T: Scalar> Profile<T> {
    /// Turns every x into f(x) to a `power`, 1 or 2; in a cusp, x below [`LEAST_X`] is as that, but for 0.
    pub(super) fn fill(self, numbers: &mut [T], power: i32) {
        match self {
            Self::Nfw => numbers.iter_mut().for_each(|x| {
                let is_least = x.value() > 0.0 && x.value() < LEAST_X;
                let within = if is_least { T::of(LEAST_X) } else { *x };
                let beyond = T::of(1.0) + within;
                let density = T::of(1.0) / (within * (beyond * beyond));
                *x = if power == 2 { density * density } else { density };
            }),
            Self::Einasto { alpha } => {
                T::raise_all(numbers, alpha);
                let slope = T::of(-2.0) / alpha * f64::from(power);
                numbers.iter_mut().for_each(|x| *x = slope * (*x - 1.0));
                T::apply(Elementary::Exp, numbers);
            }
            Self::Burkert => numbers.iter_mut().for_each(|x| {
                let one = T::of(1.0);
                let density = one / ((one + *x) * (one + *x * *x));
                *x = if power == 2 { density * density } else { density };
            }),
        }
    }

    /// The smallest x at which the density has to be a number: the centre, unless it is a cusp.
    pub(super) fn least_x(self) -> f64 {
        match self {
            Self::Nfw => LEAST_X,
            Self::Einasto { .. } | Self::Burkert => 0.0,
        }
    }
}
