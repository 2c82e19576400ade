//! An axis: its label, its scale, and the map from values to places.

use super::FigureError;
use super::ticks::{self, Ticks};

/// An axis of a plot or a panel.
///
/// ```
/// use emitree_io::figure::Axis;
///
/// let x = Axis::linear("longitude [deg]").range([-8.0, 8.0]);
/// let y = Axis::log("radiance [m⁻² sr⁻¹ s⁻¹]");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub(super) label: String,
    scale: Scale,
    range: Option<[f64; 2]>,
}

/// Which steps are equal on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios.
    Logarithmic,
    /// Equal differences of the tangent of an angle in degrees.
    Tangent,
}

impl Axis {
    /// An axis that is linear in the value.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear, range: None }
    }

    /// An axis that is linear in the logarithm of the value.
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Logarithmic, range: None }
    }

    /// An axis of angles in degrees that is linear in the tangent of the angle, as on
    /// the image plane of a pinhole camera. It needs a [`range`](Self::range) between −90 and 90.
    ///
    /// ```
    /// use emitree_io::figure::Axis;
    ///
    /// let across = Axis::tangent("to the right [deg]").range([-30.0, 30.0]);
    /// ```
    pub fn tangent(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Tangent, range: None }
    }

    /// From where to where the axis goes; without it, it holds all data.
    #[must_use]
    pub fn range(mut self, range: [f64; 2]) -> Self {
        self.range = Some(range);
        self
    }

    /// The axis with its ends: those given, or `values` with a little room.
    pub(super) fn resolve(
        &self,
        values: impl Iterator<Item = f64>,
    ) -> Result<ResolvedAxis, FigureError> {
        let label = || self.label.clone();
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for value in values.filter(|value| value.is_finite()) {
            if self.scale == Scale::Logarithmic && value <= 0.0 {
                return Err(FigureError::NotPositive { label: label(), value });
            }
            ends = [ends[0].min(value), ends[1].max(value)];
        }
        let axis = ResolvedAxis { scale: self.scale, low: 0.0, high: 1.0 };
        let [low, high] = match self.range {
            Some(range) => range,
            None if ends[0] > ends[1] => {
                return Err(FigureError::Empty { missing: "finite data" });
            }
            None => axis.with_room(ends),
        };
        let (within, expected) = match self.scale {
            Scale::Linear => (true, "finite low < high"),
            Scale::Logarithmic => (low > 0.0, "0 < low < high < ∞"),
            Scale::Tangent => (low > -90.0 && high < 90.0, "−90 < low < high < 90"),
        };
        if !(within && low < high && low.is_finite() && high.is_finite()) {
            return Err(FigureError::Range { label: label(), low, high, expected });
        }
        Ok(ResolvedAxis { low, high, ..axis })
    }
}

/// An axis with definite ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ResolvedAxis {
    pub(super) scale: Scale,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl ResolvedAxis {
    /// Where a value lies between the ends, 0 at the low and 1 at the high one.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic => (value / self.low).log10() / (self.high / self.low).log10(),
            Scale::Tangent => {
                let [value, low, high] =
                    [value, self.low, self.high].map(|angle| angle.to_radians().tan());
                (value - low) / (high - low)
            }
        }
    }

    /// The length of the axis in the coordinate in which it is linear.
    pub(super) fn extent(&self) -> f64 {
        match self.scale {
            Scale::Linear => self.high - self.low,
            Scale::Logarithmic => (self.high / self.low).log10(),
            // In degrees near the middle, so that two axes of a small field compare as angles do.
            Scale::Tangent => {
                let [low, high] = [self.low, self.high].map(|angle| angle.to_radians().tan());
                (high - low).to_degrees()
            }
        }
    }

    /// Ticks for an axis of `length`, at least `spacing` from label to label.
    pub(super) fn ticks(&self, length: f64, spacing: f64) -> Ticks {
        match self.scale {
            Scale::Logarithmic => ticks::logarithmic(self.low, self.high),
            _ => ticks::linear(self.low, self.high, (length / spacing).max(2.0)),
        }
    }

    /// Four per cent of room beyond each end of the data; some for a single value.
    fn with_room(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        if self.scale == Scale::Logarithmic {
            let factor = if low < high { (high / low).powf(0.04) } else { 2.0 };
            [low / factor, high * factor]
        } else {
            let half = if low.abs() > 0.0 { 0.5 * low.abs() } else { 0.5 };
            let room = if low < high { 0.04 * (high - low) } else { half };
            [low - room, high + room]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_data_lie_inside() {
        for axis in [Axis::linear("x"), Axis::log("x")] {
            for data in [&[2.0][..], &[1.0, 1e3], &[1e-5, f64::NAN, 1e-3]] {
                let resolved = axis.resolve(data.iter().copied()).unwrap();
                for &value in data.iter().filter(|value| value.is_finite()) {
                    let fraction = resolved.fraction(value);
                    assert!(fraction > 0.0 && fraction < 1.0, "{axis:?} {value}");
                }
            }
        }
    }

    #[test]
    fn what_has_no_place_is_named() {
        let message = |axis: Axis, values: &[f64]| {
            axis.resolve(values.iter().copied()).unwrap_err().to_string()
        };
        assert_eq!(
            message(Axis::log("error"), &[1.0, 0.0]),
            "0 on the logarithmic axis `error`: expected positive values"
        );
        assert_eq!(
            message(Axis::linear("x").range([1.0, 1.0]), &[]),
            "the axis `x` from 1 to 1: expected finite low < high"
        );
        assert_eq!(
            message(Axis::tangent("x").range([-90.0, 10.0]), &[]),
            "the axis `x` from -90 to 10: expected −90 < low < high < 90"
        );
        assert!(message(Axis::linear("x"), &[f64::NAN]).contains("without finite data"));
    }

    #[test]
    fn angles_are_those_of_a_pinhole_camera() {
        let axis = Axis::tangent("x").range([-60.0, 60.0]).resolve(std::iter::empty()).unwrap();
        let fractions = [-60.0, 0.0, 45.0, 60.0].map(|angle| axis.fraction(angle));
        let expected = [0.0, 0.5, 0.5 + 0.5 / 3.0_f64.sqrt(), 1.0];
        assert!(fractions.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-12));
        assert!((axis.extent() - (2.0 * 3.0_f64.sqrt()).to_degrees()).abs() < 1e-9);
    }
}
