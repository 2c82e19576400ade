//! Response files that astropy wrote, and the numbers that went into them (`reference/responses.py`).

use emitree_instrument::{EffectiveArea, Redistribution};
use std::path::PathBuf;

fn reference(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "reference", name].iter().collect()
}

/// The numbers of the rows about `file` that say `what`.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn stated(file: &str, what: &str) -> Vec<Vec<f64>> {
    let table = std::fs::read_to_string(reference("responses.csv")).unwrap();
    let rows: Vec<Vec<f64>> = table
        .lines()
        .filter_map(|line| line.strip_prefix(&format!("{file},{what},")))
        .map(|row| row.split(',').filter(|f| !f.is_empty()).map(|f| f.parse().unwrap()).collect())
        .collect();
    assert!(!rows.is_empty(), "{what} of {file}");
    rows
}

#[test]
fn areas_have_the_means_that_went_in() {
    for file in ["bins.arf", "descending.arf"] {
        let area = EffectiveArea::read_arf(reference(file)).unwrap();
        for row in stated(file, "area") {
            let &[low, high, mean] = &*row else { unreachable!("three numbers") };
            let found = area.mean([low, high]);
            assert!((found - mean).abs() < 1e-12 * (1.0 + mean), "{file} {low} {high}: {found}");
        }
    }
}

#[test]
#[expect(clippy::float_cmp, reason = "numbers come back from a file as they went in")]
fn matrices_have_the_responses_that_went_in() {
    for (file, rows) in [("variable.rmf", 4), ("fixed.rsp", 4), ("single.rmf", 3)] {
        let matrix = Redistribution::read_rmf(reference(file)).unwrap();
        let channels = stated(file, "channel");
        assert_eq!(matrix.channels().len(), channels.len(), "{file}");
        for (found, row) in matrix.channels().iter().zip(&channels) {
            assert_eq!(found.number as f64, row[1], "{file}");
            for (found, stated) in found.range_kev.iter().zip(&row[2..]) {
                assert!((found - stated).abs() < 1e-15, "{file}: {found} {stated}");
            }
        }

        let responses = stated(file, "response");
        for row in 0..rows {
            for channel in 0..channels.len() {
                let here = (row as f64, channel as f64);
                let stated = responses.iter().find(|response| (response[0], response[1]) == here);
                let stated = stated.map_or(0.0, |response| response[2]);
                assert_eq!(matrix.response(row, channel), stated, "{file} {row} {channel}");
            }
        }

        let sum = &stated(file, "sum")[0];
        assert_eq!(matrix.largest_row_sum(), sum[0], "{file}");
        assert_eq!(matrix.includes_area(), sum[1] == 1.0, "{file}");
    }
}

/// The energies of the rows, by what is within and between them.
#[test]
#[expect(clippy::float_cmp, reason = "numbers come back from a file as they went in")]
fn rows_are_at_their_energies() {
    for (file, edges) in [
        ("variable.rmf", &[0.1_f32, 0.2, 0.4, 0.7, 1.0].map(f64::from)[..]),
        ("single.rmf", &[0.1, 0.4, 0.7, 1.0]),
    ] {
        let matrix = Redistribution::read_rmf(reference(file)).unwrap();
        let folded = matrix.fold(edges, None);
        for bin in 0..edges.len() - 1 {
            for channel in 0..matrix.channels().len() {
                let found = folded.response(bin, channel);
                assert_eq!(found, matrix.response(bin, channel), "{file} {bin} {channel}");
            }
        }
    }
}

#[test]
fn one_kind_of_file_is_not_the_other() {
    let text = |error: emitree_instrument::ResponseFileError| error.to_string();
    assert_eq!(
        text(EffectiveArea::read_arf(reference("variable.rmf")).unwrap_err()),
        format!(
            "the response {}: it has no extension with an effective area: expected HDUCLAS2 = \
             'SPECRESP' or EXTNAME = 'SPECRESP'; there are `MATRIX` and `EBOUNDS`",
            reference("variable.rmf").display()
        )
    );
    assert_eq!(
        text(Redistribution::read_rmf(reference("bins.arf")).unwrap_err()),
        format!(
            "the response {}: it has no extension with a redistribution matrix: expected HDUCLAS2 = \
             'RSP_MATRIX', or EXTNAME = 'MATRIX' or 'SPECRESP MATRIX'; there is `ARF`",
            reference("bins.arf").display()
        )
    );
    let missing = text(EffectiveArea::read_arf("no/such/camera.arf").unwrap_err());
    assert!(
        missing.starts_with("the response no/such/camera.arf: it can't be read: "),
        "{missing}"
    );
}
