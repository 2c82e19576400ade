//! The bins of energy that a response is given for.

use crate::cell::WrongCell;
use core::cmp::Ordering;

/// How far the end of a bin may be from the start of the next one to be the same border, as a
/// fraction of the bin: files have 32 bits for each.
const ROUNDING: f64 = 1e-3;

/// Bins of energy \[keV\], ascending, with or without gaps between them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EnergyBins {
    bins: Vec<[f64; 2]>,
}

impl EnergyBins {
    /// Bins from their ends, in ascending order or, as gratings have them, all descending. The second
    /// value is whether they were descending: then the order is reversed here, and so has to be
    /// whatever belongs to them.
    pub(crate) fn new(low: &[f64], high: &[f64]) -> Result<(Self, bool), WrongCell> {
        let mut bins: Vec<[f64; 2]> =
            low.iter().zip(high).map(|(&low, &high)| [low, high]).collect();
        for (index, &[low, high]) in bins.iter().enumerate() {
            if !(low >= 0.0 && low.is_finite()) {
                let expected = "a finite energy, 0 or more";
                return Err(WrongCell::new("ENERG_LO", index, low, expected));
            }
            if !(high > low && high.is_finite()) {
                let expected = format!("a finite energy above its ENERG_LO, {low}");
                return Err(WrongCell::new("ENERG_HI", index, high, expected));
            }
        }
        let descending = match &*bins {
            [first, .., last] => first[0].partial_cmp(&last[0]) == Some(Ordering::Greater),
            _ => false,
        };
        let count = bins.len();
        if descending {
            bins.reverse();
        }
        for index in 1..count {
            let ([low, high], next) = (bins[index - 1], bins[index][0]);
            if (high - next).abs() <= ROUNDING * (high - low) {
                bins[index - 1][1] = next;
            } else if next < high {
                let row = if descending { count - 1 - index } else { index };
                let expected =
                    format!("{high} or more, where the bin of lower energies beside it ends");
                return Err(WrongCell::new("ENERG_LO", row, next, expected));
            }
        }
        Ok((Self { bins }, descending))
    }

    /// The parts of the bins between two energies: the index of each bin, and the ends of its part.
    pub(crate) fn between(
        &self,
        [low, high]: [f64; 2],
    ) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        let first = self.bins.partition_point(|bin| bin[1] <= low);
        let parts = self.bins.iter().enumerate().skip(first);
        parts
            .take_while(move |(_, bin)| bin[0] < high)
            .map(move |(index, bin)| (index, [bin[0].max(low), bin[1].min(high)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_the_overlaps() {
        let (bins, descending) = EnergyBins::new(&[1.0, 2.0, 5.0], &[2.0, 4.0, 6.0]).unwrap();
        assert!(!descending);
        let parts = |range| bins.between(range).collect::<Vec<_>>();
        assert_eq!(parts([1.5, 5.5]), [(0, [1.5, 2.0]), (1, [2.0, 4.0]), (2, [5.0, 5.5])]);
        assert_eq!(parts([2.0, 2.5]), [(1, [2.0, 2.5])]);
        assert!(parts([4.0, 5.0]).is_empty() && parts([0.0, 1.0]).is_empty());
        assert!(parts([6.0, 9.0]).is_empty());
    }

    #[test]
    fn descending_bins_are_reversed_and_borders_of_32_bits_are_one() {
        let (bins, descending) = EnergyBins::new(&[2.0, 1.0], &[3.0, 1.999_999_9]).unwrap();
        assert!(descending);
        assert_eq!(bins.bins, [[1.0, 2.0], [2.0, 3.0]]);
    }

    #[test]
    fn bins_that_can_not_be_are_refused_by_row() {
        let text = |low: &[f64], high: &[f64]| EnergyBins::new(low, high).unwrap_err().to_string();
        assert_eq!(
            text(&[1.0, 2.0], &[2.0, 1.5]),
            "ENERG_HI of row 2 is 1.5: expected a finite energy above its ENERG_LO, 2"
        );
        assert_eq!(
            text(&[-1.0], &[2.0]),
            "ENERG_LO of row 1 is -1: expected a finite energy, 0 or more"
        );
        let overlap = "expected 2 or more, where the bin of lower energies beside it ends";
        assert_eq!(
            text(&[1.0, 1.5, 3.0], &[2.0, 3.0, 4.0]),
            format!("ENERG_LO of row 2 is 1.5: {overlap}")
        );
        assert_eq!(
            text(&[3.0, 1.5, 1.0], &[4.0, 3.0, 2.0]),
            format!("ENERG_LO of row 2 is 1.5: {overlap}")
        );
        assert!(text(&[1.0, f64::NAN], &[2.0, 3.0]).contains("row 2 is NaN"));
    }
}
