//! The redistribution matrix: in which channel a photon of some energy is counted.
//!
//! A row is a bin of energies, and gives the probability of each channel for a photon in it; the
//! probabilities are kept in groups of channels side by side, as the files of missions have them
//! (George et al. 1998, OGIP memo CAL/GEN/92-002). The sum of a row is the probability that the photon
//! is counted at all: 1 for a normalised matrix. A matrix may have the effective area folded in; then
//! a response is in cm², and [`Redistribution::includes_area`] says so.

mod fold;

pub use fold::{FoldedResponse, Redistributed};

use crate::cell::WrongCell;
use crate::energy_bins::EnergyBins;

/// A channel, and the energies \[keV\] that it stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Its number in the files of the mission; without a matrix the number of the bin, from 0.
    pub number: i64,
    /// The nominal energies \[keV\], the lower first.
    pub range_kev: [f64; 2],
}

/// Channels side by side with a response.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// The first of them, counted from 0.
    pub first: usize,
    /// The response of it and of the channels that follow: probabilities, or cm².
    pub responses: Vec<f64>,
}

/// A row of the matrix: the response to photons of a bin of energies.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseRow {
    /// The ends of the bin \[keV\].
    pub range_kev: [f64; 2],
    /// The channels with a response; those in no group have none.
    pub groups: Vec<Group>,
}

/// A redistribution matrix that can't be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RedistributionError {
    /// No rows, or no channels.
    #[error("the redistribution matrix has no {0}: expected one at least")]
    Empty(&'static str),
    /// A group reaches beyond the channels.
    #[error(
        "group {group} of row {row} has {count} channels, the first of them at {first} from 0: \
         expected them among the {channels} channels"
    )]
    Group {
        /// The row, from 1.
        row: usize,
        /// The group, from 1.
        group: usize,
        /// Its first channel, counted from 0.
        first: usize,
        /// Its channels.
        count: usize,
        /// The channels that there are.
        channels: usize,
    },
    /// A response or an energy that can't be.
    #[error(transparent)]
    Cell(#[from] WrongCell),
}

/// A redistribution matrix R(channel | energy).
///
/// ```
/// use emitree_instrument::{Channel, Group, Redistribution, ResponseRow};
///
/// // Photons of 1 to 2 keV are counted in either of two channels.
/// let row = ResponseRow {
///     range_kev: [1.0, 2.0],
///     groups: vec![Group { first: 0, responses: vec![0.25, 0.75] }],
/// };
/// let channels = [[1.0, 1.5], [1.5, 2.0]].into_iter().zip(1..);
/// let channels = channels.map(|(range_kev, number)| Channel { number, range_kev }).collect();
/// let matrix = Redistribution::new(vec![row], channels, false)?;
/// assert_eq!(matrix.largest_row_sum(), 1.0);
/// # Ok::<(), emitree_instrument::RedistributionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Redistribution {
    bins: EnergyBins,
    /// For each bin.
    rows: Vec<Vec<Group>>,
    row_sums: Vec<f64>,
    channels: Vec<Channel>,
    includes_area: bool,
}

impl Redistribution {
    /// A matrix from its rows, ascending or descending in energy, and its channels. If it
    /// `includes_area`, responses are in cm².
    ///
    /// # Errors
    ///
    /// [`RedistributionError`]: no rows, no channels, bins that are empty or overlap, a response that
    /// is negative or not finite, a group beyond the channels, a channel without proper energies.
    pub fn new(
        rows: Vec<ResponseRow>,
        channels: Vec<Channel>,
        includes_area: bool,
    ) -> Result<Self, RedistributionError> {
        if rows.is_empty() {
            return Err(RedistributionError::Empty("rows"));
        }
        check_channels(&channels)?;
        let end = |which: usize| rows.iter().map(|row| row.range_kev[which]).collect::<Vec<_>>();
        let (bins, descending) = EnergyBins::new(&end(0), &end(1))?;
        for (index, row) in rows.iter().enumerate() {
            check_groups(index, &row.groups, channels.len())?;
        }
        let mut rows: Vec<Vec<Group>> = rows.into_iter().map(|row| row.groups).collect();
        if descending {
            rows.reverse();
        }
        let row_sums = rows.iter().map(|groups| responses(groups).map(|(_, r)| r).sum()).collect();
        Ok(Self { bins, rows, row_sums, channels, includes_area })
    }

    /// The channels, in the order of the matrix.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Whether the effective area is folded in, so that responses are in cm².
    pub fn includes_area(&self) -> bool {
        self.includes_area
    }

    /// The largest sum of a row: of a matrix without area the largest probability that a photon is
    /// counted, 1 but for rounding if the matrix is normalised.
    pub fn largest_row_sum(&self) -> f64 {
        self.row_sums.iter().copied().fold(0.0, f64::max)
    }

    /// The response of channel `channel`, from 0, at row `row`, from that of the lowest energies.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    pub fn response(&self, row: usize, channel: usize) -> f64 {
        let found = responses(&self.rows[row]).filter(|&(at, _)| at == channel);
        found.fold(0.0, |sum, (_, response)| sum + response)
    }
}

/// Each channel of the groups, from 0, with its response.
fn responses(groups: &[Group]) -> impl Iterator<Item = (usize, f64)> + '_ {
    groups.iter().flat_map(|group| (group.first..).zip(group.responses.iter().copied()))
}

fn check_channels(channels: &[Channel]) -> Result<(), RedistributionError> {
    if channels.is_empty() {
        return Err(RedistributionError::Empty("channels"));
    }
    for (index, channel) in channels.iter().enumerate() {
        let [min, max] = channel.range_kev;
        if !min.is_finite() {
            return Err(WrongCell::new("E_MIN", index, min, "a finite energy").into());
        }
        if !(max >= min && max.is_finite()) {
            let expected = format!("a finite energy, {min} or more as its E_MIN");
            return Err(WrongCell::new("E_MAX", index, max, expected).into());
        }
    }
    Ok(())
}

fn check_groups(row: usize, groups: &[Group], channels: usize) -> Result<(), RedistributionError> {
    for (index, group) in groups.iter().enumerate() {
        let (first, count) = (group.first, group.responses.len());
        if first.checked_add(count).is_none_or(|end| end > channels) {
            let (row, group) = (row + 1, index + 1);
            return Err(RedistributionError::Group { row, group, first, count, channels });
        }
        let counts = |response: &f64| *response >= 0.0 && response.is_finite();
        if let Some(&wrong) = group.responses.iter().find(|response| !counts(response)) {
            let expected = "a finite number, 0 or more";
            return Err(WrongCell::new("MATRIX", row, wrong, expected).into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
