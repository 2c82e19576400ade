//! Files that `numpy`, astropy and h5py have written, `tests/reference/tables.py`, and what is wrong with others.

use super::*;
use std::path::PathBuf;

fn path(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests/reference/tables", name].iter().collect()
}

fn request(axes: &[&str], values: &str, logarithmic: &[&str]) -> TableRequest {
    let texts = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    TableRequest {
        axes: texts(axes),
        values: (!values.is_empty()).then(|| values.to_owned()),
        logarithmic: texts(logarithmic),
        ..TableRequest::default()
    }
}

fn in_extension(name: &str, request: TableRequest) -> TableRequest {
    TableRequest { extension: Some(name.to_owned()), ..request }
}

/// That a file has n²/T of the script, which is exact in logarithms.
fn check(name: &str, request: &TableRequest) {
    let table = read_table(&path(name), request).unwrap();
    let last = |name: &String| name.rsplit('/').next().unwrap().to_owned();
    assert_eq!(table.names().iter().map(last).collect::<Vec<_>>(), ["T", "n"], "{name}");
    assert_eq!(
        (table.nodes(0), table.nodes(1)),
        (&[1.0, 10.0, 100.0][..], &[2.0, 4.0, 8.0, 16.0][..])
    );
    for [t, n] in [[1.0, 2.0], [3.0, 5.0], [99.0, 15.0]] {
        let found = table.value(&[t, n]).unwrap();
        assert!((found / (n * n / t) - 1.0).abs() < 1e-13, "{name}: {found}");
    }
}

#[test]
fn every_format_has_the_same_table() {
    let all = ["T", "n", "L"];
    for name in ["two.ecsv", "two.csv"] {
        check(name, &request(&[], "", &all));
        check(name, &request(&["T", "n"], "L", &all));
    }
    check("tables.fits", &in_extension("two", request(&["T", "n"], "L", &all)));
    check("images.fits", &request(&["T", "n"], "PRIMARY", &["T", "n", "PRIMARY"]));
    check("two.npz", &request(&["T", "n"], "", &["T", "n", "values"]));
    // Values whose first axis varies fastest, and nodes that decrease.
    check("fortran.npz", &request(&["T", "n"], "L", &all));
    check("scales.h5", &request(&[], "model/L", &["T", "n", "model/L"]));
    check("scales.h5", &request(&["model/T", "model/n"], "model/L", &[]).into_named());
    // The first table of a file by default.
    let one = read_table(&path("tables.fits"), &request(&[], "", &["T", "L"])).unwrap();
    assert!((one.value(&[4.0]).unwrap() - 1.0).abs() < 1e-14);
    let scaled = TableRequest { scale: 3.0, ..request(&[], "", &["T", "L"]) };
    let scaled = read_table(&path("tables.fits"), &scaled).unwrap();
    assert!((scaled.value(&[4.0]).unwrap() - 3.0).abs() < 1e-14);
}

impl TableRequest {
    /// The same request with the names that it has in logarithms.
    fn into_named(self) -> Self {
        let logarithmic = self.axes.iter().cloned().chain(self.values.clone()).collect();
        Self { logarithmic, ..self }
    }
}

/// What is wrong with a text, or with the request for it.
fn failure(text: &str, request: &TableRequest) -> (String, &'static str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    fs::write(&path, text).unwrap();
    let error = read_table(&path, request).unwrap_err();
    let expected = format!("the table {}: ", path.display());
    let message = error.to_string();
    let (_, message) = message.split_once(&expected).unwrap();
    (message.to_owned(), error.cause.concerns())
}

#[test]
fn the_file_the_line_the_column_and_the_value_are_named() {
    let plain = TableRequest::default();
    let named = |axes, values, logarithmic| request(axes, values, logarithmic);
    let cases = [
        (
            "T,L\n1,2\n2,x\n",
            plain.clone(),
            "line 3: the column `L` is `x`: expected a finite number",
        ),
        ("T,L\n1,2\n,3\n", plain.clone(), "line 3: the column `T` is ``: expected a finite number"),
        (
            "T,L\n1,2\n2,nan\n",
            plain.clone(),
            "line 3: the column `L` is `nan`: expected a finite number",
        ),
        (
            "T,L\n# one\n1,0.0\n2,3\n",
            named(&[], "", &["L"]),
            "line 3: the column `L` is `0`: expected a number above 0, which has a logarithm",
        ),
        (
            "T,L\n1,2\n-2,3\n",
            named(&[], "", &["T"]),
            "line 3: the column `T` is `-2`: expected a number above 0, which has a logarithm",
        ),
        (
            "1 2\n2 3\n1 5\n",
            plain.clone(),
            "line 3 has `1` = 1, as line 1 has: expected each combination once",
        ),
        (
            "T n L\n1 1 0\n1 2 0\n2 1 0\n",
            plain.clone(),
            "no row has `T` = 2 and `n` = 2: expected a row for each combination of 2 numbers of `T` \
             and 2 numbers of `n` (`axes` and `values` choose columns)",
        ),
        ("T,L\n1,2\n", plain.clone(), "the axis `T` has 1 node(s): expected at least 2"),
        (
            "L\n1\n",
            plain.clone(),
            "it has 1 column(s), `L`: expected 2 to 4, the arguments and then the value, or `axes` and \
             `values`, which choose columns",
        ),
        (
            "T,T,L\n1,2,3\n",
            named(&["T"], "L", &[]),
            "it has two columns `T`: expected different names",
        ),
    ];
    for (text, request, message) in cases {
        assert_eq!(failure(text, &request), (message.to_owned(), "file"), "{text}");
    }
    let text = "T,L\n1,2\n2,3\n";
    let cases = [
        (named(&["t"], "L", &[]), "it has no column `t`: expected one of `T`, `L`", "axes"),
        (named(&["T"], "M", &[]), "it has no column `M`: expected one of `T`, `L`", "values"),
        (
            named(&["T"], "L", &["logT"]),
            "`logT` is neither an axis nor the values: expected one of `T`, `L`",
            "logarithmic",
        ),
    ];
    for (request, message, key) in cases {
        assert_eq!(failure(text, &request), (message.to_owned(), key));
    }
}

#[test]
fn what_is_wrong_with_arrays_and_fits_tables_is_named() {
    let message = |name: &str, request: &TableRequest| {
        read_table(&path(name), request).unwrap_err().cause.to_string()
    };
    let cases = [
        (
            "two.npz",
            TableRequest::default(),
            "the file does not name the axes of `values`, an array of shape [3, 4]: expected `axes`, \
             the names of an array of nodes for each",
        ),
        (
            "two.npz",
            request(&["n", "T"], "", &[]),
            "the array `values` has the shape [3, 4]: expected [4, 3], the nodes of `n`, `T`",
        ),
        (
            "two.npz",
            request(&["T", "m"], "", &[]),
            "it has no array `m`: expected one of `T`, `n`, `values`",
        ),
        (
            "tables.fits",
            in_extension("three", TableRequest::default()),
            "it has no table `three`: expected one of `COOLING`, `TWO`, `VECTORS`",
        ),
        (
            "tables.fits",
            in_extension("VECTORS", TableRequest::default()),
            "the column `L` has 4 numbers a row: expected 1",
        ),
        (
            "tables.fits",
            in_extension("COOLING", request(&["T"], "n", &[])),
            "it has no column `n`: expected one of `T`, `L`",
        ),
    ];
    for (name, request, expected) in cases {
        assert_eq!(message(name, &request), expected);
    }
    let no_ending = read_table("table.doc".as_ref(), &TableRequest::default()).unwrap_err();
    assert_eq!(
        no_ending.to_string(),
        "the table table.doc: no table format for this ending: expected .csv, .ecsv, .txt, .dat, \
         .fits, .fit, .npz, .h5, .hdf5 or .nc"
    );
    let absent = read_table("no.csv".as_ref(), &TableRequest::default()).unwrap_err();
    assert!(absent.to_string().starts_with("the table no.csv: it can't be read: "), "{absent}");
}
