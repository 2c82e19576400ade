//! The effective area \[cm²\] against energy \[keV\]: mirror, filter and detector together.
//!
//! A table of bins, as ancillary response files (ARF) have it, is constant within each bin; a table of
//! points is linear between them. Outside of its table the area is 0. What the camera takes from a bin
//! of a spectral cube is the mean over that bin, exact for either kind of table.

use crate::cell::WrongCell;
use crate::energy_bins::EnergyBins;

/// An effective area that can't be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AreaError {
    /// Too few rows for a range of energies.
    #[error("the effective area has {found} rows: expected {expected} at least")]
    TooFewRows {
        /// The rows.
        found: usize,
        /// 1 for bins, 2 for points.
        expected: usize,
    },
    /// Columns of different lengths.
    #[error("the columns of the effective area have {lengths:?} rows: expected the same number")]
    Lengths {
        /// The rows of each column.
        lengths: Vec<usize>,
    },
    /// An area or an energy that can't be.
    #[error(transparent)]
    Cell(#[from] WrongCell),
}

/// The effective area \[cm²\] against energy \[keV\].
///
/// ```
/// use emitree_instrument::EffectiveArea;
///
/// let area = EffectiveArea::from_points(&[1.0, 2.0, 4.0], &[0.0, 10.0, 10.0])?;
/// assert_eq!(area.mean([1.0, 2.0]), 5.0);
/// assert_eq!(area.integral([1.0, 8.0]), 25.0); // 0 beyond 4 keV
/// # Ok::<(), emitree_instrument::AreaError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EffectiveArea {
    table: Table,
}

/// What the rows of the table are.
#[derive(Clone, Debug, PartialEq)]
enum Table {
    Bins { bins: EnergyBins, areas_cm2: Vec<f64> },
    Points { energies_kev: Vec<f64>, areas_cm2: Vec<f64> },
}

impl EffectiveArea {
    /// An area that is constant within bins, which are given by their ends, as in an ARF; bins may
    /// ascend or descend, and have gaps between them, where the area is 0.
    ///
    /// # Errors
    ///
    /// [`AreaError`]: no bins, columns of different lengths, an area that is negative or not finite,
    /// bins that are empty or overlap.
    pub fn from_bins(
        low_kev: &[f64],
        high_kev: &[f64],
        areas_cm2: &[f64],
    ) -> Result<Self, AreaError> {
        check_lengths(&[low_kev.len(), high_kev.len(), areas_cm2.len()], 1)?;
        let (bins, descending) = EnergyBins::new(low_kev, high_kev)?;
        WrongCell::unless_all_count("SPECRESP", areas_cm2)?;
        let mut areas_cm2 = areas_cm2.to_vec();
        if descending {
            areas_cm2.reverse();
        }
        Ok(Self { table: Table::Bins { bins, areas_cm2 } })
    }

    /// An area that is linear between points, of ascending energies.
    ///
    /// # Errors
    ///
    /// [`AreaError`]: fewer than two points, columns of different lengths, an area that is negative or
    /// not finite, energies that don't ascend.
    pub fn from_points(energies_kev: &[f64], areas_cm2: &[f64]) -> Result<Self, AreaError> {
        check_lengths(&[energies_kev.len(), areas_cm2.len()], 2)?;
        WrongCell::unless_all_count("energy", energies_kev)?;
        if let Some(index) = energies_kev.windows(2).position(|pair| pair[0] >= pair[1]) {
            let expected = format!("above {}, the energy of the row before", energies_kev[index]);
            let later = index + 1;
            return Err(WrongCell::new("energy", later, energies_kev[later], expected).into());
        }
        WrongCell::unless_all_count("area", areas_cm2)?;
        let (energies_kev, areas_cm2) = (energies_kev.to_vec(), areas_cm2.to_vec());
        Ok(Self { table: Table::Points { energies_kev, areas_cm2 } })
    }

    /// ∫ A dE \[cm² keV\] between two energies \[keV\]; 0 if the first is not below the second.
    pub fn integral(&self, range_kev: [f64; 2]) -> f64 {
        match &self.table {
            Table::Bins { bins, areas_cm2 } => bins
                .between(range_kev)
                .map(|(bin, [low, high])| (high - low) * areas_cm2[bin])
                .fold(0.0, |sum, part| sum + part),
            Table::Points { energies_kev, areas_cm2 } => {
                integral_of_points(energies_kev, areas_cm2, range_kev)
            }
        }
    }

    /// The mean area \[cm²\] between two energies \[keV\], which is that of photons spread
    /// evenly in energy; 0 if the first is not below the second.
    pub fn mean(&self, range_kev: [f64; 2]) -> f64 {
        let [low, high] = range_kev;
        if low < high { self.integral(range_kev) / (high - low) } else { 0.0 }
    }
}

fn check_lengths(lengths: &[usize], least: usize) -> Result<(), AreaError> {
    if lengths.iter().any(|&length| length != lengths[0]) {
        return Err(AreaError::Lengths { lengths: lengths.to_vec() });
    }
    if lengths[0] < least {
        return Err(AreaError::TooFewRows { found: lengths[0], expected: least });
    }
    Ok(())
}

/// Σ of the trapezia between the points, each cut to the range.
fn integral_of_points(energies: &[f64], areas: &[f64], [low, high]: [f64; 2]) -> f64 {
    let first = energies.partition_point(|&energy| energy <= low).saturating_sub(1);
    let mut sum = 0.0;
    for segment in first..energies.len() - 1 {
        let [start, end] = [energies[segment], energies[segment + 1]];
        let [from, to] = [start.max(low), end.min(high)];
        if start >= high {
            break;
        }
        if from < to {
            let slope = (areas[segment + 1] - areas[segment]) / (end - start);
            let middle = areas[segment] + slope * (0.5 * (from + to) - start);
            sum += (to - from) * middle;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "sums of dyadic numbers are exact")]
    fn bins_are_constant_and_gaps_are_empty() {
        let area =
            EffectiveArea::from_bins(&[1.0, 2.0, 5.0], &[2.0, 4.0, 6.0], &[3.0, 8.0, 2.0]).unwrap();
        // By hand: half of the first bin, all of the second, the gap, half of the third.
        assert_eq!(area.integral([1.5, 5.5]), 1.5 + 16.0 + 1.0);
        assert_eq!(area.mean([1.5, 5.5]), 18.5 / 4.0);
        assert_eq!(area.mean([4.0, 5.0]), 0.0);
        assert_eq!(area.mean([0.0, 1.0]), 0.0);
        assert_eq!(area.mean([2.5, 2.75]), 8.0);
        assert_eq!(area.mean([3.0, 3.0]), 0.0);
        let reversed =
            EffectiveArea::from_bins(&[5.0, 2.0, 1.0], &[6.0, 4.0, 2.0], &[2.0, 8.0, 3.0]).unwrap();
        assert_eq!(reversed, area);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "sums of dyadic numbers are exact")]
    fn points_are_joined_by_lines() {
        let area = EffectiveArea::from_points(&[1.0, 3.0, 4.0], &[2.0, 6.0, 0.0]).unwrap();
        assert_eq!(area.integral([1.0, 3.0]), 8.0);
        assert_eq!(area.integral([0.0, 9.0]), 11.0);
        // A = 2E from 1.5 to 2, and 6 (4 − E) from 3.5 to 4.
        assert!((area.integral([1.5, 2.0]) - 1.75).abs() < 1e-15);
        assert!((area.integral([3.5, 5.0]) - 0.75).abs() < 1e-15);
        assert_eq!(area.integral([4.0, 5.0]), 0.0);
        assert_eq!(area.integral([0.0, 1.0]), 0.0);
        assert_eq!(area.integral([3.0, 2.0]), 0.0);
    }

    #[test]
    fn tables_that_can_not_be_are_refused_by_name() {
        let bins = |low: &[f64], high: &[f64], areas: &[f64]| {
            EffectiveArea::from_bins(low, high, areas).unwrap_err().to_string()
        };
        assert_eq!(
            bins(&[1.0, 2.0], &[2.0, 3.0], &[4.0, -2.0]),
            "SPECRESP of row 2 is -2: expected a finite number, 0 or more"
        );
        assert_eq!(bins(&[], &[], &[]), "the effective area has 0 rows: expected 1 at least");
        assert_eq!(
            bins(&[1.0], &[2.0], &[]),
            "the columns of the effective area have [1, 1, 0] rows: expected the same number"
        );
        let points = |energies: &[f64], areas: &[f64]| {
            EffectiveArea::from_points(energies, areas).unwrap_err().to_string()
        };
        assert_eq!(
            points(&[1.0, 3.0, 2.0], &[1.0; 3]),
            "energy of row 3 is 2: expected above 3, the energy of the row before"
        );
        assert!(points(&[1.0, 3.0], &[1.0, f64::INFINITY]).starts_with("area of row 2 is inf:"));
        assert!(points(&[1.0], &[1.0]).contains("1 rows: expected 2 at least"));
    }

    proptest! {
        /// Parts add up to the whole, wherever it is cut.
        #[test]
        fn integrals_add_up(
            areas in prop::collection::vec(0.0..100.0_f64, 2..30),
            cuts in prop::collection::vec(-1.0..31.0_f64, 1..20),
        ) {
            let energies: Vec<f64> = (0..areas.len()).map(|n| n as f64).collect();
            let count = areas.len() - 1;
            let tables = [
                EffectiveArea::from_points(&energies, &areas).unwrap(),
                EffectiveArea::from_bins(&energies[..count], &energies[1..], &areas[..count]).unwrap(),
            ];
            let mut cuts = cuts;
            cuts.extend([-1.0, 31.0]);
            cuts.sort_by(f64::total_cmp);
            for area in tables {
                let parts: f64 = cuts.windows(2).map(|c| area.integral([c[0], c[1]])).sum();
                let whole = area.integral([-1.0, 31.0]);
                prop_assert!((parts - whole).abs() <= 1e-11 * (1.0 + whole), "{} {}", parts, whole);
            }
        }
    }
}
