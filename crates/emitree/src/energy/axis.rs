//! The energy axis: the third axis of a spectral cube.
//!
//! Along it the canonical coordinate u runs from 0 to 1, and all bins are equally wide in u. With
//! [`EnergyScale::Linear`] u grows with the energy, with [`EnergyScale::Log`] with its logarithm.

/// How bins divide the energies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EnergyScale {
    /// Bins of equal width.
    #[default]
    Linear,
    /// Bins of equal ratio between their ends.
    Log,
}

/// An energy axis that can't be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnergyError {
    /// The range is empty, or not finite.
    #[error(
        "the energies are from {min} to {max}: expected finite numbers, the first below the second"
    )]
    Range {
        /// The lowest energy.
        min: f64,
        /// The highest energy.
        max: f64,
    },
    /// A logarithmic axis starts at 0 or below.
    #[error("the lowest energy is {0}: expected a number above 0 on a logarithmic axis")]
    NotPositive(f64),
    /// The number of bins is out of range.
    #[error("there are {0} energy bins: expected 1 to 65536")]
    Bins(usize),
    /// The difference of the ends is infinite in 64-bit floats.
    #[error("the energies are from {min:?} to {max:?}: expected a difference below 1.8e308")]
    Difference {
        /// The lowest energy.
        min: f64,
        /// The highest energy.
        max: f64,
    },
    /// The ratio of the ends of a logarithmic axis is infinite in 64-bit floats.
    #[error(
        "the energies are from {min:?} to {max:?}: expected a ratio below 1.8e308 on a logarithmic \
         axis"
    )]
    Ratio {
        /// The lowest energy.
        min: f64,
        /// The highest energy.
        max: f64,
    },
    /// The bins are so narrow that their borders, in 64-bit floats, are hardly apart.
    #[error(
        "there are {bins} bins from {min:?} to {max:?}: expected bins of {least:.1e} or more, whose \
         borders can be told apart"
    )]
    Narrow {
        /// The lowest energy.
        min: f64,
        /// The highest energy.
        max: f64,
        /// The number of bins.
        bins: usize,
        /// The width that the narrowest bin has to have.
        least: f64,
    },
}

/// The most bins that an axis may have.
const MOST_BINS: usize = 1 << 16;

/// The narrowest bin, relative to its energies: rounded by an ulp or two, 4 · 10⁻¹⁶ of an energy, a
/// border is where it should be to a thousandth of the width.
const NARROWEST: f64 = 1e-12;

/// The energies of a spectral cube: `bins` bins from `min` to `max`, in a unit that the caller has
/// chosen.
///
/// No bin is narrower than 10⁻¹² of its energies (with [`EnergyScale::Linear`], of the largest
/// |energy|), since 64-bit floats would hardly resolve its borders; none is narrower than
/// 2.2 · 10⁻³⁰⁸, the smallest number with all its digits.
///
/// ```
/// use emitree::{EnergyAxis, EnergyScale};
///
/// let axis = EnergyAxis::new(0.5, 8.0, 4, EnergyScale::Log)?;
/// assert_eq!(axis.edges(), [0.5, 1.0, 2.0, 4.0, 8.0]);
/// assert_eq!(axis.width(3), 4.0);
/// # Ok::<(), emitree::energy::EnergyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyAxis {
    min: f64,
    max: f64,
    bins: usize,
    scale: EnergyScale,
}

impl EnergyAxis {
    /// An axis of `bins` bins from `min` to `max`.
    ///
    /// # Errors
    ///
    /// [`EnergyError`]: an empty range, a logarithmic axis that does not start above 0, no bins or
    /// more than 65 536, ends whose difference (or ratio, of a logarithmic axis) is infinite, bins that
    /// are too narrow.
    pub fn new(min: f64, max: f64, bins: usize, scale: EnergyScale) -> Result<Self, EnergyError> {
        if !(min < max && min.is_finite() && max.is_finite()) {
            return Err(EnergyError::Range { min, max });
        }
        if scale == EnergyScale::Log && min <= 0.0 {
            return Err(EnergyError::NotPositive(min));
        }
        if !(1..=MOST_BINS).contains(&bins) {
            return Err(EnergyError::Bins(bins));
        }
        if !(max - min).is_finite() {
            return Err(EnergyError::Difference { min, max });
        }
        if scale == EnergyScale::Log && !(max / min).is_finite() {
            return Err(EnergyError::Ratio { min, max });
        }
        let axis = Self { min, max, bins, scale };
        let least = axis.least_width();
        if axis.width(0) < least {
            return Err(EnergyError::Narrow { min, max, bins, least });
        }
        Ok(axis)
    }

    /// What the lowest bin, which is as narrow as any, has to be wide.
    fn least_width(&self) -> f64 {
        let energy = match self.scale {
            EnergyScale::Linear => self.min.abs().max(self.max.abs()),
            EnergyScale::Log => self.min,
        };
        (NARROWEST * energy).max(f64::MIN_POSITIVE)
    }

    /// The lowest energy.
    pub fn min(&self) -> f64 {
        self.min
    }

    /// The highest energy.
    pub fn max(&self) -> f64 {
        self.max
    }

    /// The number of bins.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// How the bins divide the energies.
    pub fn scale(&self) -> EnergyScale {
        self.scale
    }

    /// The energy at canonical coordinate `u`, 0 to 1.
    pub fn energy(&self, u: f64) -> f64 {
        if u <= 0.0 {
            return self.min;
        }
        if u >= 1.0 {
            return self.max;
        }
        match self.scale {
            EnergyScale::Linear => self.min + (self.max - self.min) * u,
            EnergyScale::Log => self.min * (self.max / self.min).powf(u),
        }
    }

    /// The canonical coordinate of an `energy`; outside of 0 to 1 beyond the axis.
    pub fn canonical(&self, energy: f64) -> f64 {
        match self.scale {
            EnergyScale::Linear => (energy - self.min) / (self.max - self.min),
            EnergyScale::Log => (energy / self.min).ln() / (self.max / self.min).ln(),
        }
    }

    /// dE/du at canonical coordinate `u`.
    pub fn energy_per_canonical(&self, u: f64) -> f64 {
        match self.scale {
            EnergyScale::Linear => self.max - self.min,
            EnergyScale::Log => self.energy(u) * self.log_ratio(),
        }
    }

    /// ln(max/min). Of a narrow axis the quotient has few digits of its distance from 1, the
    /// difference has all.
    fn log_ratio(&self) -> f64 {
        ((self.max - self.min) / self.min).ln_1p()
    }

    /// The `bins` + 1 borders of the bins, ascending.
    pub fn edges(&self) -> Vec<f64> {
        (0..=self.bins).map(|edge| self.energy(edge as f64 / self.bins as f64)).collect()
    }

    /// The width of bin `bin`, from the lowest: to all digits, which the difference of two
    /// [`edges`](Self::edges) that are nearly equal has not.
    pub fn width(&self, bin: usize) -> f64 {
        let bins = self.bins as f64;
        match self.scale {
            EnergyScale::Linear => (self.max - self.min) / bins,
            EnergyScale::Log => self.energy(bin as f64 / bins) * (self.log_ratio() / bins).exp_m1(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{prop_assert, proptest};

    #[test]
    fn the_coordinate_of_an_energy_is_the_inverse() {
        for scale in [EnergyScale::Linear, EnergyScale::Log] {
            let axis = EnergyAxis::new(0.3, 12.0, 7, scale).unwrap();
            for u in [0.0, 0.1, 0.5, 0.93, 1.0] {
                assert!((axis.canonical(axis.energy(u)) - u).abs() < 1e-14, "{scale:?} {u}");
                let slope = (axis.energy(u + 1e-6) - axis.energy(u - 1e-6)) / 2e-6;
                if u > 0.0 && u < 1.0 {
                    let derivative = axis.energy_per_canonical(u);
                    assert!((slope / derivative - 1.0).abs() < 1e-6, "{scale:?} {u}");
                }
            }
            let widths: f64 = (0..7).map(|bin| axis.width(bin)).sum();
            assert!((widths - 11.7).abs() < 1e-12, "{widths}");
        }
    }

    #[test]
    fn axes_that_can_not_be_are_refused_by_name() {
        let text =
            |min, max, bins, scale| EnergyAxis::new(min, max, bins, scale).unwrap_err().to_string();
        let linear = EnergyScale::Linear;
        assert!(text(2.0, 1.0, 4, linear).contains("from 2 to 1"));
        assert!(text(0.0, f64::NAN, 4, linear).contains("NaN"));
        assert!(text(0.0, 1.0, 0, linear).contains("0 energy bins"));
        assert!(text(0.0, 1.0, 4, EnergyScale::Log).contains("above 0"));
    }

    #[test]
    fn axes_that_floats_have_no_room_for_are_refused_by_name() {
        let text =
            |min, max, bins, scale| EnergyAxis::new(min, max, bins, scale).unwrap_err().to_string();
        let (linear, log) = (EnergyScale::Linear, EnergyScale::Log);
        let wide = "the energies are from -1e308 to 1e308: expected a difference below 1.8e308";
        assert_eq!(text(-1e308, 1e308, 4, linear), wide);
        let wide = "the energies are from 1e-200 to 1e200: expected a ratio below 1.8e308 on a \
                    logarithmic axis";
        assert_eq!(text(1e-200, 1e200, 4, log), wide);
        assert!(EnergyAxis::new(1e-200, 1e200, 4, linear).is_ok());
        let narrow = "there are 3000 bins from 1.0 to 1.00000000001: expected bins of 1.0e-12 or more, \
                      whose borders can be told apart";
        for scale in [linear, log] {
            assert_eq!(text(1.0, 1.000_000_000_01, 3000, scale), narrow);
        }
    }

    /// The limit is 10⁻¹², and 2⁻³⁹ is 1.8 of it.
    #[test]
    fn bins_are_wide_against_their_energies() {
        let more = 1.0 + 2_f64.powi(-39);
        let fits =
            |[min, max]: [f64; 2], bins, scale| EnergyAxis::new(min, max, bins, scale).is_ok();
        for (ends, scale) in [
            ([1.0, more], EnergyScale::Linear),
            ([1.0, more], EnergyScale::Log),
            ([-more, -1.0], EnergyScale::Linear),
            ([1e-200, more * 1e-200], EnergyScale::Log),
        ] {
            assert_eq!([1, 2].map(|bins| fits(ends, bins, scale)), [true, false], "{ends:?}");
        }
        // Below the smallest normal number floats have fewer digits.
        assert!(fits([0.0, 1e-300], MOST_BINS, EnergyScale::Linear));
        assert!(!fits([0.0, 1e-305], MOST_BINS, EnergyScale::Linear));
        assert!(!fits([1e-320, 1e-310], 1, EnergyScale::Log));
    }

    /// Eight bins of (max − min) / 8, but for terms of the order of (max − min)².
    #[test]
    fn widths_of_narrow_bins_are_exact() {
        let (min, max) = (1.0, 1.000_000_000_01);
        for scale in [EnergyScale::Linear, EnergyScale::Log] {
            let axis = EnergyAxis::new(min, max, 8, scale).unwrap();
            for bin in 0..8 {
                let found = 8.0 * axis.width(bin) / (max - min);
                assert!((found - 1.0).abs() < 1e-11, "{scale:?} {bin}: {found}");
            }
            let slope = axis.energy_per_canonical(0.5) / (max - min);
            assert!((slope - 1.0).abs() < 1e-11, "{scale:?}: {slope}");
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "powers of 2 are exact")]
    fn widths_of_powers_are_powers() {
        let axis = EnergyAxis::new(0.5, 8.0, 4, EnergyScale::Log).unwrap();
        assert_eq!([0, 1, 2, 3].map(|bin| axis.width(bin)), [0.5, 1.0, 2.0, 4.0]);
        let axis = EnergyAxis::new(-1.0, 2.0, 4, EnergyScale::Linear).unwrap();
        assert_eq!([0, 3].map(|bin| axis.width(bin)), [0.75; 2]);
    }

    proptest! {
        /// Together they have the whole axis, and each is as far from the next as its borders are.
        #[test]
        fn widths_are_those_between_the_edges(
            min in 1e-3..1e3_f64, octaves in -20.0..20_f64, bins in 1_usize..40, is_log: bool,
        ) {
            let scale = if is_log { EnergyScale::Log } else { EnergyScale::Linear };
            let max = min * (1.0 + octaves.exp2());
            let axis = EnergyAxis::new(min, max, bins, scale).unwrap();
            let sum: f64 = (0..bins).map(|bin| axis.width(bin)).sum();
            prop_assert!((sum / (max - min) - 1.0).abs() < 1e-13, "{sum}");
            for (bin, ends) in axis.edges().windows(2).enumerate() {
                let difference = ends[1] - ends[0] - axis.width(bin);
                prop_assert!(difference.abs() < 1e-14 * ends[1], "{bin}: {difference}");
            }
        }
    }
}
