//! From the two tables of a redistribution matrix file to the matrix.

use super::error::ResponseFileDefect;
use super::table::{Kind, ResponseTable};
use crate::redistribution::{Channel, Group, Redistribution, ResponseRow};
use fits_well::FitsReader;
use fits_well::table::Ragged;

/// The number of the first channel, if `F_CHAN` has no `TLMIN` (the memo, section 3.2.2).
const FIRST_CHANNEL: i64 = 1;
/// A sum of a row above this is no probability, with room for rounding and for sloppy files.
const LARGEST_PROBABILITY: f64 = 1.5;

pub(super) fn redistribution(bytes: &[u8]) -> Result<Redistribution, ResponseFileDefect> {
    let mut reader = FitsReader::from_bytes(bytes).map_err(ResponseFileDefect::fits)?;
    let table = ResponseTable::open(&mut reader, Kind::Matrix)?;
    let bounds = ResponseTable::open(&mut reader, Kind::Channels)?;
    let channels = channels(&bounds)?;
    let unit = match table.text("HDUCLAS3") {
        // What is a probability may have any unit.
        Some(class) if !class.eq_ignore_ascii_case("FULL") => None,
        _ => table.cm2_per_unit("MATRIX")?,
    };
    let rows = Rows::read(&table, unit.unwrap_or(1.0))?.build(&table, channels.len())?;
    let includes_area = match table.text("HDUCLAS3") {
        Some(class) => class.eq_ignore_ascii_case("FULL"),
        None => unit.is_some() || largest_sum(&rows) > LARGEST_PROBABILITY,
    };
    Redistribution::new(rows, channels, includes_area).map_err(|source| {
        ResponseFileDefect::Redistribution { matrix: table.name, channels: bounds.name, source }
    })
}

fn channels(table: &ResponseTable) -> Result<Vec<Channel>, ResponseFileDefect> {
    let numbers = table.scalars("CHANNEL")?;
    let [min, max] = [table.energies_kev("E_MIN")?, table.energies_kev("E_MAX")?];
    let channel = |(row, &number): (usize, &f64)| {
        let expected = "a whole number";
        let whole = whole(number).and_then(|number| i64::try_from(number).ok());
        let number = whole.ok_or_else(|| table.cell("CHANNEL", row, number, expected))?;
        Ok(Channel { number, range_kev: [min[row], max[row]] })
    };
    numbers.iter().enumerate().map(channel).collect()
}

/// The columns of the matrix, row by row.
struct Rows {
    ranges_kev: Vec<[f64; 2]>,
    group_counts: Vec<f64>,
    first_channels: Ragged<Vec<f64>>,
    channel_counts: Ragged<Vec<f64>>,
    responses: Ragged<Vec<f64>>,
    /// What a response is multiplied with, for cm².
    factor: f64,
    /// The number of the first channel.
    first_channel: i64,
}

impl Rows {
    fn read(table: &ResponseTable, factor: f64) -> Result<Self, ResponseFileDefect> {
        let [low, high] = [table.energies_kev("ENERG_LO")?, table.energies_kev("ENERG_HI")?];
        Ok(Self {
            ranges_kev: low.into_iter().zip(high).map(<[f64; 2]>::from).collect(),
            group_counts: table.scalars("N_GRP")?,
            first_channels: table.vectors("F_CHAN")?,
            channel_counts: table.vectors("N_CHAN")?,
            responses: table.vectors("MATRIX")?,
            factor,
            first_channel: table.minimum("F_CHAN")?.unwrap_or(FIRST_CHANNEL),
        })
    }

    fn build(
        &self,
        table: &ResponseTable,
        channels: usize,
    ) -> Result<Vec<ResponseRow>, ResponseFileDefect> {
        let row = |(row, &range_kev)| {
            let groups = self.groups(table, row, channels)?;
            Ok(ResponseRow { range_kev, groups })
        };
        self.ranges_kev.iter().enumerate().map(row).collect()
    }

    /// The groups of a row. Columns of fixed length have room for the row with most of them, so what
    /// is beyond the groups that there are is none of them.
    fn groups(
        &self,
        table: &ResponseTable,
        row: usize,
        channels: usize,
    ) -> Result<Vec<Group>, ResponseFileDefect> {
        let (firsts, counts) = (self.first_channels.row(row), self.channel_counts.row(row));
        let mut responses = self.responses.row(row);
        let found = self.group_counts[row];
        let most = firsts.len().min(counts.len());
        let groups = whole(found).filter(|&groups| groups <= most).ok_or_else(|| {
            let expected = format!(
                "a whole number up to {most}, the groups that F_CHAN and N_CHAN have there"
            );
            table.cell("N_GRP", row, found, expected)
        })?;
        let mut built = Vec::with_capacity(groups);
        for (&first, &count) in firsts.iter().zip(counts).take(groups) {
            let Some(length) = whole(count).filter(|&length| length <= responses.len()) else {
                let room = responses.len();
                let expected =
                    format!("a whole number up to {room}, the responses left in MATRIX there");
                return Err(table.cell("N_CHAN", row, count, expected));
            };
            if length == 0 {
                continue;
            }
            let first = self.channel(first, length, channels).ok_or_else(|| {
                let from = self.first_channel;
                let to = from.saturating_add_unsigned(channels as u64) - 1;
                let expected = format!(
                    "the first of {length} channels, all from {from} (TLMIN of F_CHAN, or 1 without) \
                     to {to}"
                );
                table.cell("F_CHAN", row, first, expected)
            })?;
            let (of_group, rest) = responses.split_at(length);
            responses = rest;
            let responses = of_group.iter().map(|response| self.factor * response).collect();
            built.push(Group { first, responses });
        }
        Ok(built)
    }

    /// The place from 0 of the channel with this number, if `length` channels are there.
    fn channel(&self, number: f64, length: usize, channels: usize) -> Option<usize> {
        let first = whole(number - self.first_channel as f64)?;
        (first.checked_add(length)? <= channels).then_some(first)
    }
}

fn largest_sum(rows: &[ResponseRow]) -> f64 {
    let of_row = |row: &ResponseRow| row.groups.iter().flat_map(|group| &group.responses).sum();
    rows.iter().map(of_row).fold(0.0, f64::max)
}

/// A whole number, 0 or more, of 31 bits.
fn whole(value: f64) -> Option<usize> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within the numbers of 31 bits"
    )]
    (value.fract() == 0.0 && (0.0..=f64::from(i32::MAX)).contains(&value)).then_some(value as usize)
}
