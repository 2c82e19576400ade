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
}

/// The most bins that an axis may have.
const MOST_BINS: usize = 1 << 16;

/// The energies of a spectral cube: `bins` bins from `min` to `max`, in a unit that the caller has
/// chosen.
///
/// ```
/// use emitree::{EnergyAxis, EnergyScale};
///
/// let axis = EnergyAxis::new(0.5, 8.0, 4, EnergyScale::Log)?;
/// assert_eq!(axis.edges(), [0.5, 1.0, 2.0, 4.0, 8.0]);
/// assert_eq!(axis.width(3), 4.0);
/// # Ok::<(), emitree::EnergyError>(())
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
    /// more than 65 536.
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
        Ok(Self { min, max, bins, scale })
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
            EnergyScale::Log => self.energy(u) * (self.max / self.min).ln(),
        }
    }

    /// The `bins` + 1 borders of the bins, ascending.
    pub fn edges(&self) -> Vec<f64> {
        (0..=self.bins).map(|edge| self.energy(edge as f64 / self.bins as f64)).collect()
    }

    /// The width of bin `bin`, from the lowest.
    pub fn width(&self, bin: usize) -> f64 {
        let [low, high] = [bin, bin + 1].map(|edge| self.energy(edge as f64 / self.bins as f64));
        high - low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
