use super::*;
use crate::effective_area::EffectiveArea;
use crate::field::{total, total_of};
use emitree::{Cube, Image};
use proptest::prelude::*;

fn channels(count: usize) -> Vec<Channel> {
    let range = |n: usize| [n as f64, n as f64 + 1.0];
    (0..count).zip(1..).map(|(n, number)| Channel { number, range_kev: range(n) }).collect()
}

/// Rows between the edges, each with one group from channel 0.
fn matrix(edges: &[f64], rows: &[Vec<f64>], count: usize) -> Redistribution {
    let row = |(ends, responses): (&[f64], &Vec<f64>)| ResponseRow {
        range_kev: [ends[0], ends[1]],
        groups: vec![Group { first: 0, responses: responses.clone() }],
    };
    let rows = edges.windows(2).zip(rows).map(row).collect();
    let built = Redistribution::new(rows, channels(count), false);
    built.unwrap()
}

fn identity(edges: &[f64]) -> Redistribution {
    let count = edges.len() - 1;
    let unit = |n: usize| (0..count).map(|m| f64::from(u8::from(m == n))).collect();
    matrix(edges, &(0..count).map(unit).collect::<Vec<Vec<f64>>>(), count)
}

#[test]
fn the_identity_changes_no_bit() {
    let edges = [0.5, 1.0, 2.0, 4.0];
    let bands: Vec<Image> =
        (0..3).map(|b| Image::from_pixels(1, 3, vec![b as f64 + 0.1, 7.0, f64::NAN])).collect();
    let photons = Cube::from_bands(bands);
    let redistributed = identity(&edges).apply(&photons, &edges);
    let bits = |cube: &Cube| cube.voxels().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(&redistributed.counts), bits(&photons));
    assert_eq!((redistributed.outside, redistributed.uncounted), (0.0, 0.0));
}

/// A matrix by hand: bins of the cube across rows, a gap, the end of the matrix, rows below 1.
#[test]
#[expect(clippy::float_cmp, reason = "sums of dyadic numbers are exact")]
fn photons_go_where_the_overlaps_say() {
    let rows = vec![
        ResponseRow {
            range_kev: [1.0, 2.0],
            groups: vec![
                Group { first: 0, responses: vec![0.5] },
                Group { first: 2, responses: vec![0.25, 0.25] },
            ],
        },
        ResponseRow {
            range_kev: [3.0, 5.0],
            groups: vec![Group { first: 1, responses: vec![0.75] }],
        },
    ];
    let matrix = Redistribution::new(rows, channels(4), false).unwrap();
    assert_eq!(matrix.largest_row_sum(), 1.0);
    assert_eq!([0, 1, 2, 3].map(|c| matrix.response(0, c)), [0.5, 0.0, 0.25, 0.25]);

    // 8 photons from 0 to 4: a quarter in each of nothing, row 1, the gap and row 2. 4 from 4 to 6.
    let photons = Cube::from_bands(vec![
        Image::from_pixels(1, 1, vec![8.0]),
        Image::from_pixels(1, 1, vec![4.0]),
    ]);
    let found = matrix.apply(&photons, &[0.0, 4.0, 6.0]);
    assert_eq!(found.counts.voxels().collect::<Vec<_>>(), [1.0, 3.0, 0.5, 0.5]);
    assert_eq!((found.photons, found.outside, found.uncounted), (12.0, 6.0, 1.0));
    assert_eq!(found.expected, 5.0);
}

#[test]
fn a_matrix_of_descending_rows_is_the_same() {
    let row = |low: f64, first: usize| ResponseRow {
        range_kev: [low, low + 1.0],
        groups: vec![Group { first, responses: vec![1.0] }],
    };
    let up = Redistribution::new(vec![row(1.0, 0), row(2.0, 1)], channels(2), false).unwrap();
    let down = Redistribution::new(vec![row(2.0, 1), row(1.0, 0)], channels(2), false).unwrap();
    assert_eq!(up, down);
}

#[test]
#[expect(clippy::float_cmp, reason = "sums of dyadic numbers are exact")]
fn a_channel_that_nothing_reaches_is_zero_and_none_where_the_field_is_none() {
    let matrix = matrix(&[1.0, 2.0], &[vec![1.0]], 2);
    let photons = Cube::from_bands(vec![Image::from_pixels(1, 2, vec![3.0, f64::NAN])]);
    let counts = matrix.apply(&photons, &[1.0, 2.0]).counts;
    assert_eq!(counts.bands()[1].pixels()[0], 0.0);
    assert!(counts.bands()[1].pixels()[1].is_nan());
}

#[test]
fn matrices_that_can_not_be_are_refused_by_name() {
    let row = |range_kev, first, responses: &[f64]| ResponseRow {
        range_kev,
        groups: vec![Group { first, responses: responses.to_vec() }],
    };
    let text = |rows: Vec<ResponseRow>, channels: Vec<Channel>| {
        Redistribution::new(rows, channels, false).unwrap_err().to_string()
    };
    assert_eq!(
        text(vec![row([1.0, 2.0], 0, &[1.0]), row([2.0, 3.0], 3, &[0.5, 0.5])], channels(4)),
        "group 1 of row 2 has 2 channels, the first of them at 3 from 0: expected them among the 4 \
         channels"
    );
    assert!(text(vec![row([1.0, 2.0], usize::MAX, &[1.0])], channels(4)).starts_with("group 1"));
    assert_eq!(
        text(vec![row([1.0, 2.0], 0, &[1.0, -0.5])], channels(4)),
        "MATRIX of row 1 is -0.5: expected a finite number, 0 or more"
    );
    assert_eq!(
        text(vec![], channels(4)),
        "the redistribution matrix has no rows: expected one at least"
    );
    assert!(text(vec![row([1.0, 2.0], 0, &[])], vec![]).contains("no channels"));
    assert!(
        text(vec![row([2.0, 1.0], 0, &[])], channels(1)).starts_with("ENERG_HI of row 1 is 1:")
    );
    let backwards = vec![Channel { number: 1, range_kev: [2.0, 1.0] }];
    assert_eq!(
        text(vec![row([1.0, 2.0], 0, &[])], backwards),
        "E_MAX of row 1 is 1: expected a finite energy, 2 or more as its E_MIN"
    );
}

proptest! {
    /// Counts, photons outside and photons that are not counted are all the photons, whatever the
    /// bins; and the responses are those of overlaps taken the other way round, row by row.
    #[test]
    fn photons_are_conserved(
        rows in prop::collection::vec(prop::collection::vec(0.0..1.0_f64, 5), 1..12),
        widths in prop::collection::vec(0.01..2.0_f64, 1..15),
        start in 0.0..3.0_f64,
        weighted in any::<bool>(),
    ) {
        let edges: Vec<f64> = (0..=rows.len()).map(|n| 1.0 + 0.5 * n as f64).collect();
        let rows: Vec<Vec<f64>> = rows
            .into_iter()
            .map(|row| row.iter().map(|r| r / row.iter().sum::<f64>().max(1.0)).collect())
            .collect();
        let matrix = matrix(&edges, &rows, 5);
        let area = EffectiveArea::from_points(&[0.0, 4.0, 40.0], &[1.0, 9.0, 2.0]).unwrap();
        let area = weighted.then_some(&area);
        let weight = |a: f64, b: f64| {
            let range = [a, b];
            if a < b { area.map_or(b - a, |area| area.integral(range)) } else { 0.0 }
        };

        let mut bins = vec![start];
        for width in &widths {
            bins.push(bins[bins.len() - 1] + width);
        }
        let band = |n: usize| Image::from_pixels(1, 2, vec![1.0 + n as f64, 0.3]);
        let photons = Cube::from_bands((0..widths.len()).map(band).collect());
        let found = matrix.fold(&bins, area).apply(&photons);
        let counted = total_of(&found.counts);
        prop_assert!((found.photons - total_of(&photons)).abs() < 1e-10);
        prop_assert!((counted - found.expected).abs() < 1e-10, "{} {}", counted, found.expected);
        let all = counted + found.outside + found.uncounted;
        prop_assert!((all - found.photons).abs() < 1e-10, "{} of {}", all, found.photons);

        for (channel, band) in found.counts.bands().iter().enumerate() {
            let mut expected = 0.0;
            for (row, ends) in edges.windows(2).enumerate() {
                for (bin, borders) in bins.windows(2).enumerate() {
                    let part = weight(ends[0].max(borders[0]), ends[1].min(borders[1]));
                    let photons = 1.3 + bin as f64;
                    expected += rows[row][channel] * photons * part / weight(borders[0], borders[1]);
                }
            }
            let counted = total(band);
            prop_assert!((counted - expected).abs() < 1e-10, "{} {}", counted, expected);
        }
    }
}
