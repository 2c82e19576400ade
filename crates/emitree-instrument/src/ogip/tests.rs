use super::*;
use fits_well::FitsWriter;
use fits_well::header::Header;
use fits_well::table::{Builder, ColumnData, WriteColumn};

type Column<'a> = (&'a str, Vec<f64>, usize);

/// A table of a file: its name, its columns, and header records beside the name, units among them.
type Extension<'a> = (&'a str, Vec<Column<'a>>, &'a [(&'a str, &'a str)]);

fn file(tables: &[Extension<'_>]) -> Vec<u8> {
    let mut writer = FitsWriter::new(Vec::new());
    for (name, columns, records) in tables {
        let mut table = Builder::new();
        for (index, (name, values, repeat)) in columns.iter().enumerate() {
            let mut column = WriteColumn::fixed(*name, ColumnData::F64(values.clone()), *repeat);
            let unit = format!("TUNIT{}", index + 1);
            if let Some((_, unit)) = records.iter().find(|(keyword, _)| *keyword == unit) {
                column = column.with_unit(*unit);
            }
            table.push(column).unwrap();
        }
        let mut header = Header::new();
        header.set("EXTNAME", *name).unwrap();
        for (keyword, value) in records.iter().filter(|(keyword, _)| !keyword.starts_with("TUNIT"))
        {
            match value.parse::<f64>() {
                Ok(number) => header.set(*keyword, number).unwrap(),
                Err(_) => header.set(*keyword, *value).unwrap(),
            };
        }
        writer.write_table(&table, Some(&header)).unwrap();
    }
    writer.into_inner()
}

fn arf_columns() -> Vec<Column<'static>> {
    vec![
        ("ENERG_LO", vec![1.0, 2.0], 1),
        ("ENERG_HI", vec![2.0, 3.0], 1),
        ("SPECRESP", vec![10.0, 20.0], 1),
    ]
}

/// Two rows and three channels, from 1.
fn matrix_columns() -> Vec<Column<'static>> {
    vec![
        ("ENERG_LO", vec![1.0, 2.0], 1),
        ("ENERG_HI", vec![2.0, 3.0], 1),
        ("N_GRP", vec![1.0, 2.0], 1),
        ("F_CHAN", vec![1.0, 0.0, 1.0, 3.0], 2),
        ("N_CHAN", vec![2.0, 0.0, 1.0, 1.0], 2),
        ("MATRIX", vec![0.5, 0.5, 0.75, 0.25], 2),
    ]
}

fn channel_columns() -> Vec<Column<'static>> {
    vec![
        ("CHANNEL", vec![1.0, 2.0, 3.0], 1),
        ("E_MIN", vec![1.0, 1.5, 2.0], 1),
        ("E_MAX", vec![1.5, 2.0, 3.0], 1),
    ]
}

fn with(
    mut columns: Vec<Column<'static>>,
    name: &'static str,
    values: &[f64],
) -> Vec<Column<'static>> {
    for column in &mut columns {
        if column.0 == name {
            column.1 = values.to_vec();
        }
    }
    columns
}

fn without(columns: Vec<Column<'static>>, name: &str) -> Vec<Column<'static>> {
    columns.into_iter().filter(|column| column.0 != name).collect()
}

fn area_text(columns: Vec<Column<'_>>, records: &[(&str, &str)]) -> String {
    area(&file(&[("SPECRESP", columns, records)])).unwrap_err().to_string()
}

fn matrix_of(
    columns: Vec<Column<'_>>,
    records: &[(&str, &str)],
) -> Result<Redistribution, ResponseFileDefect> {
    matrix::redistribution(&file(&[
        ("MATRIX", columns, records),
        ("EBOUNDS", channel_columns(), &[]),
    ]))
}

fn matrix_text(columns: Vec<Column<'_>>, records: &[(&str, &str)]) -> String {
    matrix_of(columns, records).unwrap_err().to_string()
}

#[test]
#[expect(clippy::float_cmp, reason = "numbers come back from a file as they went in")]
fn wrong_areas_are_refused_by_column_and_row() {
    let read = area(&file(&[("SPECRESP", arf_columns(), &[])])).unwrap();
    assert_eq!(read.mean([1.0, 3.0]), 15.0);
    assert_eq!(
        area_text(without(arf_columns(), "SPECRESP"), &[]),
        "extension `SPECRESP` has no column `SPECRESP`; there are `ENERG_LO` and `ENERG_HI`"
    );
    assert_eq!(
        area_text(with(arf_columns(), "SPECRESP", &[10.0, -3.0]), &[]),
        "extension `SPECRESP`: SPECRESP of row 2 is -3: expected a finite number, 0 or more"
    );
    assert_eq!(
        area_text(with(arf_columns(), "ENERG_LO", &[1.0, 1.5]), &[]),
        "extension `SPECRESP`: ENERG_LO of row 2 is 1.5: expected 2 or more, where the bin of lower \
         energies beside it ends"
    );
    assert_eq!(
        area_text(arf_columns(), &[("TUNIT1", "Angstrom")]),
        "extension `SPECRESP`: the unit of column `ENERG_LO` is `Angstrom`: expected keV, eV, MeV \
         or GeV"
    );
    assert!(
        area_text(arf_columns(), &[("TUNIT3", "s")]).contains("`SPECRESP` is `s`: expected cm")
    );
    let mut vectors = arf_columns();
    vectors[2] = ("SPECRESP", vec![1.0; 4], 2);
    assert_eq!(
        area_text(vectors, &[]),
        "extension `SPECRESP`: column `SPECRESP` has 2 numbers a row: expected 1"
    );
}

#[test]
#[expect(clippy::float_cmp, reason = "numbers come back from a file as they went in")]
fn classes_win_over_names_and_several_are_refused() {
    let class = [("HDUCLAS1", "RESPONSE"), ("HDUCLAS2", "SPECRESP")];
    let other = with(arf_columns(), "SPECRESP", &[5.0, 5.0]);
    let tables = [("SPECRESP", arf_columns(), &[][..]), ("AREA", other, &class[..])];
    assert_eq!(area(&file(&tables)).unwrap().mean([1.0, 3.0]), 5.0);
    let twice = [("SPECRESP", arf_columns(), &[][..]), ("SPECRESP", arf_columns(), &[][..])];
    assert_eq!(
        area(&file(&twice)).unwrap_err().to_string(),
        "it has 2 extensions with an effective area: expected one"
    );
}

#[test]
#[expect(clippy::float_cmp, reason = "numbers come back from a file as they went in")]
fn wrong_groups_are_refused_by_column_and_row() {
    let matrix = matrix_of(matrix_columns(), &[]).unwrap();
    assert_eq!([0, 1, 2].map(|channel| matrix.response(1, channel)), [0.75, 0.0, 0.25]);
    let changed = |name, values: &[f64]| matrix_text(with(matrix_columns(), name, values), &[]);
    assert_eq!(
        changed("N_GRP", &[1.0, 3.0]),
        "extension `MATRIX`: N_GRP of row 2 is 3: expected a whole number up to 2, the groups that \
         F_CHAN and N_CHAN have there"
    );
    assert!(changed("N_GRP", &[0.5, 1.0]).contains("N_GRP of row 1 is 0.5"));
    assert_eq!(
        changed("N_CHAN", &[2.0, 0.0, 1.0, 2.0]),
        "extension `MATRIX`: N_CHAN of row 2 is 2: expected a whole number up to 1, the responses \
         left in MATRIX there"
    );
    assert!(changed("N_CHAN", &[-1.0, 0.0, 1.0, 1.0]).contains("N_CHAN of row 1 is -1"));
    let channels = "all from 1 (TLMIN of F_CHAN, or 1 without) to 3";
    assert_eq!(
        changed("F_CHAN", &[3.0, 0.0, 1.0, 3.0]),
        format!(
            "extension `MATRIX`: F_CHAN of row 1 is 3: expected the first of 2 channels, {channels}"
        )
    );
    assert!(changed("F_CHAN", &[0.0, 0.0, 1.0, 3.0]).contains("F_CHAN of row 1 is 0"));
    assert_eq!(
        changed("MATRIX", &[0.5, 0.5, -0.75, 0.25]),
        "extensions `MATRIX` and `EBOUNDS`: MATRIX of row 2 is -0.75: expected a finite number, 0 \
         or more"
    );
    assert_eq!(
        matrix_text(without(matrix_columns(), "N_CHAN"), &[]),
        "extension `MATRIX` has no column `N_CHAN`; there are `ENERG_LO`, `ENERG_HI`, `N_GRP`, \
         `F_CHAN` and `MATRIX`"
    );
    assert_eq!(
        matrix_text(matrix_columns(), &[("TLMIN4", "zero")]).split(": expected").last(),
        Some(" the number of the first channel, since it is that of `F_CHAN`")
    );
}

#[test]
fn the_first_channel_is_that_of_the_column() {
    let from_zero = with(matrix_columns(), "F_CHAN", &[0.0, 0.0, 0.0, 2.0]);
    let matrix = matrix_of(from_zero, &[("TLMIN4", "0")]).unwrap();
    assert_eq!(matrix, matrix_of(matrix_columns(), &[]).unwrap());
}

/// By the class; without one by the unit, or by sums that no probability has.
#[test]
#[expect(clippy::float_cmp, reason = "numbers come back from a file as they went in")]
fn it_is_known_whether_the_area_is_included() {
    let large = || with(matrix_columns(), "MATRIX", &[50.0, 50.0, 75.0, 25.0]);
    let included = |columns, records: &[(&str, &str)]| {
        matrix_of(columns, records).map(|matrix| matrix.includes_area()).unwrap()
    };
    assert!(!included(matrix_columns(), &[]));
    assert!(included(large(), &[]));
    assert!(included(matrix_columns(), &[("TUNIT6", "cm**2")]));
    assert!(included(matrix_columns(), &[("HDUCLAS3", "FULL")]));
    assert!(!included(large(), &[("HDUCLAS3", "REDIST"), ("TUNIT6", "cm**2")]));
    let in_m2 = matrix_of(matrix_columns(), &[("TUNIT6", "m**2")]).unwrap();
    assert_eq!(in_m2.largest_row_sum(), 1e4);
}

#[test]
fn files_that_lack_a_part_are_refused() {
    let no_bounds = file(&[("MATRIX", matrix_columns(), &[])]);
    assert_eq!(
        matrix::redistribution(&no_bounds).unwrap_err().to_string(),
        "it has no extension with the energies of channels: expected HDUCLAS2 = 'EBOUNDS' or \
         EXTNAME = 'EBOUNDS'; there is `MATRIX`"
    );
    let wrong = area(b"plain text").unwrap_err().to_string();
    assert!(wrong.starts_with("it can't be read as FITS: "), "{wrong}");
    let whole = file(&[("SPECRESP", arf_columns(), &[])]);
    for length in [100, 2_880, 4_000, whole.len() - 2_880] {
        assert!(area(&whole[..length]).is_err(), "{length} of {}", whole.len());
    }
}
