//! The size of a unit in SI, with its power of ten apart so that decimal factors stay exact.

/// `mantissa` · 10^`decade`.
///
/// A product of centimetres, kilometres and the like has only decades to add up: 6371 km in cm is
/// 6.371·10⁸ to the last bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Magnitude {
    pub(super) mantissa: f64,
    pub(super) decade: i32,
}

impl Magnitude {
    pub(super) const ONE: Self = Self { mantissa: 1.0, decade: 0 };

    pub(super) fn new(mantissa: f64, decade: i32) -> Self {
        Self { mantissa, decade }
    }

    pub(super) fn times(self, other: Self) -> Self {
        Self {
            mantissa: self.mantissa * other.mantissa,
            decade: self.decade.saturating_add(other.decade),
        }
    }

    pub(super) fn over(self, other: Self) -> Self {
        Self {
            mantissa: self.mantissa / other.mantissa,
            decade: self.decade.saturating_sub(other.decade),
        }
    }

    pub(super) fn power(self, exponent: i32) -> Self {
        Self {
            mantissa: self.mantissa.powi(exponent),
            decade: self.decade.saturating_mul(exponent),
        }
    }

    /// As one number; rounded once if the decade is at most 22, the largest exact power of ten.
    pub(super) fn value(self) -> f64 {
        let ten = |exponent: u32| 10_f64.powi(i32::try_from(exponent).unwrap_or(i32::MAX));
        let size = self.decade.unsigned_abs();
        // Two steps reach values whose power of ten alone is beyond the largest float.
        let (half, rest) = (ten(size / 2), ten(size - size / 2));
        match (self.decade >= 0, size <= 22) {
            (true, true) => self.mantissa * ten(size),
            (false, true) => self.mantissa / ten(size),
            (true, false) => self.mantissa * half * rest,
            (false, false) => self.mantissa / half / rest,
        }
    }
}
