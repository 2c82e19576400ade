//! Files that pyvista has written, `tests/reference/vtk.py`, and what is wrong with others.

use super::super::{GridRequest, decode_grid, read_grid};
use super::*;
use std::path::PathBuf;

fn path(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests/reference/vtk", name].iter().collect()
}

fn request(values: &str) -> GridRequest {
    let values = (!values.is_empty()).then(|| values.to_owned());
    GridRequest { values, ..GridRequest::default() }
}

const X: [f64; 4] = [-1.0, 0.0, 2.0, 6.0];

#[test]
fn text_and_binary_have_the_same_data() {
    for name in ["rectilinear_text.vtk", "rectilinear_binary.vtk"] {
        let read = |values: &str| read_grid(&path(name), &request(values)).unwrap().grid;
        let grid = read("g");
        assert_eq!(grid.nodes(), [&X[..], &[0.0, 0.5, 2.0], &[10.0, 20.0]], "{name}");
        // g = 100 z + 10 y + x of the indices; the vectors are g, 2 g, 3 g.
        assert_eq!(grid.values()[..5], [0.0, 1.0, 2.0, 3.0, 10.0], "{name}");
        assert_eq!(grid.values()[22..], [122.0, 123.0]);
        assert_eq!(read("the velocity:y").values()[22..], [244.0, 246.0]);
    }
    let cells = read_grid(&path("cells.vtk"), &request("of cells")).unwrap().grid;
    assert_eq!(cells.nodes(), [&[0.25, 0.75, 1.25][..], &[0.5, 1.5], &[1.0, 3.0]]);
    assert_eq!(cells.values()[..4], [0.0, 1.0, 2.0, 3.0]);
    for name in ["uniform_text.vtk", "uniform_binary.vtk"] {
        let grid = read_grid(&path(name), &request("")).unwrap().grid;
        assert_eq!(
            grid.nodes(),
            [&[-1.0, -0.5, 0.0, 0.5][..], &[0.0, 1.0, 2.0], &[5.0, 7.0]],
            "{name}"
        );
        assert_eq!(grid.values()[22..], [122.0, 123.0]);
    }
}

#[test]
fn what_is_wrong_is_said() {
    let message = |text: &str, values: &str| {
        let bytes = text.as_bytes().to_vec();
        decode_grid(bytes, GridFormat::Vtk, &request(values)).unwrap_err().to_string()
    };
    let start = "# vtk DataFile Version 3.0\ntitle\nASCII\n";
    let grid = format!("{start}DATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nPOINT_DATA 8\n");
    let cases = [
        ("a,b\n".to_owned(), "expected `# vtk DataFile Version` at its start"),
        (start.replace("ASCII", "HEX"), "its third line is `HEX`: expected ASCII or BINARY"),
        (
            format!("{start}DATASET UNSTRUCTURED_GRID\n"),
            "its dataset is UNSTRUCTURED_GRID: expected STRUCTURED_POINTS or RECTILINEAR_GRID (in \
             Python `emitree.from_pyvista` takes others)",
        ),
        (
            format!("{grid}SCALARS g float\nLOOKUP_TABLE default\n1 2 3\n"),
            "its numbers are cut off",
        ),
        (format!("{grid}SCALARS g float\n1 2 3 4 x 6 7 8\n"), "`x` is in place of a number"),
        (
            format!("{grid}SCALARS g complex\n"),
            "its numbers are of type complex: expected a real one",
        ),
        (format!("{grid}NOISE\n"), "it has the keyword `NOISE`, which is not known"),
        (
            format!("{start}DATASET STRUCTURED_POINTS\nDIMENSIONS 2 2\n"),
            "`DIMENSIONS` lacks arguments",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(message(&text, "g"), format!("it can't be read as VTK: {expected}"));
    }
    let vectors = format!("{grid}VECTORS v float\n{}", "0 ".repeat(24));
    assert_eq!(message(&vectors, "v"), "it has no array `v`: expected one of `v:x`, `v:y`, `v:z`");
    let no_bytes = format!("{start}DATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 9999999999\n");
    assert!(message(&no_bytes, "").contains("expected fewer"));
}
