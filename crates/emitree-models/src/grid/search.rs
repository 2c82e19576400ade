//! [`Search`]: how the cell of a coordinate is found among ascending places.
//!
//! All ways give the same cell: the last one whose lower end is not above the coordinate.

/// How cells are found.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Search {
    /// By a product, and a step to a neighbour at most.
    Even {
        /// Cells per length.
        cells_per_length: f64,
    },
    /// By a table of equal intervals, and bisection between two of its entries.
    Table {
        /// Intervals per length.
        intervals_per_length: f64,
        /// For each interval, and for the end, the last place in an interval before, or 0.
        cells: Vec<u32>,
    },
    /// By bisection.
    Bisection,
}

/// Intervals of a table for each cell: of nodes at constant ratios over two decades most intervals have at
/// most one.
const INTERVALS_PER_CELL: usize = 8;
/// The longest table, 256 kB: with more nodes there are more in each interval.
const MOST_INTERVALS: usize = 1 << 16;

impl Search {
    /// The fastest way for these ascending places, of which there are at least two.
    pub(super) fn new(places: &[f64]) -> Self {
        let last_cell = places.len() - 2;
        let span = places[last_cell + 1] - places[0];
        let cells_per_length = (places.len() - 1) as f64 / span;
        // The span of the places, or its inverse, may exceed the largest number.
        if !(cells_per_length.is_normal() && span.is_finite()) {
            return Self::Bisection;
        }
        if are_even(places, cells_per_length) {
            return Self::Even { cells_per_length };
        }
        let intervals = INTERVALS_PER_CELL.saturating_mul(places.len() - 1).min(MOST_INTERVALS);
        let intervals_per_length = intervals as f64 / span;
        if !intervals_per_length.is_finite() || u32::try_from(last_cell).is_err() {
            return Self::Bisection;
        }
        let mut cells = vec![0; intervals + 1];
        for (cell, &place) in (0_u32..).zip(&places[..=last_cell]) {
            let after = interval(place - places[0], intervals_per_length, intervals) + 1;
            cells[after] = cell;
        }
        // An interval without a place has the cell of the one before.
        for at in 1..cells.len() {
            cells[at] = cells[at].max(cells[at - 1]);
        }
        Self::Table { intervals_per_length, cells }
    }

    /// The cell of a coordinate that is between the first and the last of the places.
    #[inline(always)]
    pub(super) fn cell(&self, places: &[f64], coordinate: f64) -> usize {
        match self {
            Self::Even { cells_per_length } => even_cell(places, coordinate, *cells_per_length),
            Self::Table { intervals_per_length, cells } => {
                cell_by_table(places, coordinate, *intervals_per_length, cells)
            }
            Self::Bisection => cell_by_bisection(places, coordinate),
        }
    }

    /// The cells of many coordinates, of which each is between the first and the last of the places.
    pub(super) fn cells(&self, places: &[f64], coordinates: &[f64], found: &mut [usize]) {
        let pairs = found.iter_mut().zip(coordinates);
        match self {
            Self::Even { cells_per_length } => {
                pairs.for_each(|(cell, &at)| *cell = even_cell(places, at, *cells_per_length));
            }
            Self::Table { intervals_per_length, cells } => pairs.for_each(|(cell, &at)| {
                *cell = cell_by_table(places, at, *intervals_per_length, cells);
            }),
            Self::Bisection => {
                pairs.for_each(|(cell, &at)| *cell = cell_by_bisection(places, at));
            }
        }
    }
}

#[inline(always)]
fn cell_by_table(
    places: &[f64],
    coordinate: f64,
    intervals_per_length: f64,
    cells: &[u32],
) -> usize {
    // The product rounds, but never to a lower interval for a larger coordinate: all places of
    // the intervals before are below, and all of those after are above.
    let at = interval(coordinate - places[0], intervals_per_length, cells.len() - 1);
    let (low, high) = (cells[at] as usize, cells[at + 1] as usize);
    // Most intervals have one place at most: no branch for them.
    let cell = (low + usize::from(places[low + 1] <= coordinate)).min(high);
    if high - low <= 1 {
        return cell;
    }
    low + places[low + 1..=high].partition_point(|&place| place <= coordinate)
}

#[inline(always)]
fn cell_by_bisection(places: &[f64], coordinate: f64) -> usize {
    let above = places.partition_point(|&place| place <= coordinate);
    above.saturating_sub(1).min(places.len() - 2)
}

/// The interval that a distance from the first place is in, of `count`.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is a number of intervals, 0 or more"
)]
fn interval(along: f64, intervals_per_length: f64, count: usize) -> usize {
    ((along * intervals_per_length) as usize).min(count - 1)
}

/// A guess, mended by at most one cell: the answer depends on the places alone.
#[inline(always)]
fn even_cell(places: &[f64], coordinate: f64, cells_per_length: f64) -> usize {
    let cells = places.len() - 1;
    let guess = interval(coordinate - places[0], cells_per_length, cells);
    // No branch: whether a guess has to be mended is hard to predict.
    let above = usize::from(guess + 1 < cells && coordinate >= places[guess + 1]);
    guess + above - usize::from(coordinate < places[guess])
}

/// Whether no place is further than a quarter of the mean spacing from its even place: then the even cell of
/// any coordinate is its cell or a neighbour.
fn are_even(places: &[f64], cells_per_length: f64) -> bool {
    let is_even = |(index, &place): (usize, &f64)| {
        ((place - places[0]) * cells_per_length - index as f64).abs() <= 0.25
    };
    places.iter().enumerate().all(is_even)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn only_even_places_are_found_by_a_product() {
        let cells_per_length = |places: &[f64]| match Search::new(places) {
            Search::Even { cells_per_length } => Some(cells_per_length),
            _ => None,
        };
        assert_eq!(cells_per_length(&[0.0, 0.5, 1.0]), Some(2.0));
        assert_eq!(cells_per_length(&[0.0, 0.37, 1.0]), None);
        // Coordinates that were once of 32 bits are even enough.
        let rounded: Vec<f64> = (0..101).map(|i| f64::from(0.1_f32 * i as f32)).collect();
        assert!(cells_per_length(&rounded).is_some());
        // The span of these exceeds the largest number, and that of the others is too small for its inverse.
        for places in [[-f64::MAX, 0.0, f64::MAX], [0.0, 5e-324, 1e-323]] {
            assert_eq!(Search::new(&places), Search::Bisection);
        }
    }

    proptest! {
        /// All ways find the same cell, at places and beside them too.
        #[test]
        fn all_searches_agree(
            steps in prop::collection::vec(-8.0..4.0_f64, 1..60),
            uneven in 0.0..=1.0_f64,
            at in prop::collection::vec(0.0..=1.0_f64, 20),
        ) {
            let mut places = vec![-3.0];
            for step in steps {
                places.push(places[places.len() - 1] + (uneven * step).exp());
            }
            let (first, last) = (places[0], places[places.len() - 1]);
            let search = Search::new(&places);
            let between = at.iter().map(|at| (first + at * (last - first)).min(last));
            let beside = places.iter().flat_map(|place| [*place, place.next_up(), place.next_down()]);
            for coordinate in between.chain(beside).filter(|c| (first..=last).contains(c)) {
                let expected = Search::Bisection.cell(&places, coordinate);
                prop_assert_eq!(search.cell(&places, coordinate), expected);
                let mut found = [usize::MAX];
                search.cells(&places, &[coordinate], &mut found);
                prop_assert_eq!(found, [expected]);
            }
        }
    }
}
