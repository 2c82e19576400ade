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
fn all_forms_of_xml_have_the_same_data() {
    let forms = ["text", "base64", "base64_zlib", "appended", "appended_zlib"];
    for form in forms.into_iter().chain(["appended_base64", "appended_base64_zlib"]) {
        let read = |values: &str| read_grid(&path(&format!("{form}.vtr")), &request(values));
        let grid = read("g").unwrap().grid;
        assert_eq!(grid.nodes(), [&X[..], &[0.0, 0.5, 2.0], &[10.0, 20.0]], "{form}");
        assert_eq!(grid.values()[..5], [0.0, 1.0, 2.0, 3.0, 10.0], "{form}");
        assert_eq!(grid.values()[22..], [122.0, 123.0], "{form}");
        assert_eq!(read("the velocity:y").unwrap().grid.values()[22..], [244.0, 246.0], "{form}");
        let missing = read("speed").unwrap_err().to_string();
        assert!(
            missing.contains("no array `speed`: expected one of `g`, `the velocity:x`"),
            "{missing}"
        );
    }
    let cells = read_grid(&path("cells.vti"), &request("of cells")).unwrap().grid;
    assert_eq!(cells.nodes(), [&[0.25, 0.75, 1.25][..], &[0.5, 1.5], &[1.0, 3.0]]);
    assert_eq!(cells.values()[..4], [0.0, 1.0, 2.0, 3.0]);
    let part = read_grid(&path("uniform.vti"), &request("")).unwrap().grid;
    assert_eq!(part.nodes(), [&[-1.0, -0.5, 0.0, 0.5][..], &[0.0, 1.0, 2.0], &[5.0, 7.0]]);
    assert_eq!(part.values()[22..], [122.0, 123.0]);
}

/// An image of 2 x 2 x 2 points in XML, with the attributes of the file and its elements of data.
fn image(file: &str, data: &str) -> String {
    format!(
        "<VTKFile type=\"ImageData\" {file}><ImageData Origin=\"0 0 0\" Spacing=\"1 1 1\">\
         <Piece Extent=\"0 1 0 1 0 1\"><PointData>{data}</PointData></Piece></ImageData></VTKFile>"
    )
}

fn array(format: &str, content: &str) -> String {
    format!("<DataArray type=\"UInt8\" Name=\"g\" format=\"{format}\">{content}</DataArray>")
}

#[test]
fn what_is_wrong_in_xml_is_said() {
    let message = |text: &str| {
        let bytes = text.as_bytes().to_vec();
        decode_grid(bytes, GridFormat::Vtk, &request("g")).unwrap_err().to_string()
    };
    let zlib = "compressor=\"vtkZLibDataCompressor\"";
    let eight = array("ascii", "1 2 3 4 5 6 7 8");
    let cases = [
        ("<svg/>".to_owned(), "it is XML with <svg>: expected <VTKFile>"),
        ("<VTKFile>".to_owned(), "its XML: "),
        ("<!DOCTYPE a []><VTKFile/>".to_owned(), "its XML: "),
        (
            image("", &eight).replace("ImageData", "StructuredGrid"),
            "its dataset is StructuredGrid: expected ImageData or RectilinearGrid (in Python \
             `emitree.from_pyvista` takes others)",
        ),
        (
            image("byte_order=\"PDP\"", &eight),
            "its byte_order is PDP: expected LittleEndian or BigEndian",
        ),
        (image("header_type=\"UInt8\"", &eight), "its header_type is UInt8: expected UInt32"),
        (image("", &eight).replace("0 1 0 1 0 1", "0 1 0 1"), "the Extent of <Piece> is `0 1 0 1`"),
        (
            image("", &eight).replace("0 1 0 1 0 1", "1 0 0 1 0 1"),
            "its extent is [1, 0, 0, 1, 0, 1]",
        ),
        (
            image("", &eight).replace("0 1 0 1 0 1", "0 9999999 0 1 0 1"),
            "its extent is [0, 9999999, 0, 1, 0, 1]: expected a smaller one",
        ),
        (
            image("", &eight).replace("Origin", "Direction=\"0 1 0 1 0 0 0 0 1\" Origin"),
            "Direction",
        ),
        (image("", &eight).replace("Piece", "Part"), "it has 0 pieces: expected one"),
        (
            image("", &array("ascii", "1 2 3")),
            "the array `g` has 3 values: expected 8, of [2, 2, 2]",
        ),
        (image("", &array("ascii", "1 2 3 4 5 6 7 8 9")), "an array has more than 8 numbers"),
        (image("", &array("ascii", "1 2 x")), "`x` is in place of a number"),
        (image("", &array("hex", "1 2")), "the format of the array g is hex: expected ascii"),
        // Lengths of 4 bytes: 8 and 9 of them, then the numbers.
        (image("", &array("binary", "CAAAAA==")), "its numbers are cut off"),
        (image("", &array("binary", "CQAAAAECAwQFBgcICQ==")), "an array has 9 bytes: expected 8"),
        (image("", &array("binary", "C?AAAAEC")), "C?AA is no base64"),
        (image("", &array("appended", "")), "the offset of <DataArray> is ``: expected 1 numbers"),
        (image("", &array("appended\" offset=\"7", "")), "the array g is beyond the appended data"),
        // One block of 8 bytes with 3 compressed ones, and 2³² blocks of none.
        (image(zlib, &array("binary", "AQAAAAgAAAAAAAAAAwAAAA==AAAA")), "block 0 of an array: "),
        (
            image(zlib, &array("binary", "/////wAAAAAIAAAA")),
            "an array of 8 bytes has 4294967295 blocks",
        ),
    ];
    for (text, expected) in cases {
        let found = message(&text);
        let start = format!("it can't be read as VTK: {expected}");
        assert!(
            found.starts_with(&start) || (expected.len() < 10 && found.contains(expected)),
            "{found}"
        );
    }
    let lz4 = read_grid(&path("lz4.vti"), &request("g")).unwrap_err().to_string();
    assert!(
        lz4.contains("compressor is vtkLZ4DataCompressor: expected vtkZLibDataCompressor"),
        "{lz4}"
    );
    let text = array("appended\" offset=\"0", "");
    let after = "</ImageData><AppendedData encoding=\"raw\">XX</AppendedData>";
    let appended = image("", &text).replace("</ImageData>", after);
    assert!(message(&appended).contains("its appended data begin without `_`"));
    let cut = appended.replace("XX</AppendedData></VTKFile>", "_\u{8}\0\0\0abc");
    assert!(message(&cut).contains("its numbers are cut off"));
    let whole = decode_grid(
        appended.replace("XX", "_\u{8}\0\0\0abcdefgh").into_bytes(),
        GridFormat::Vtk,
        &request("g"),
    );
    assert_eq!(whole.unwrap().grid.values()[..2], [97.0, 98.0]);
}

/// A megabyte of zeros takes a kilobyte of zlib: no more is unpacked than the extent has room for, nor more than
/// there is memory.
#[test]
fn compressed_data_take_no_more_memory_than_allowed() {
    let zeros = vec![0_u8; 1 << 20];
    let mut packed = Vec::new();
    flate2::read::ZlibEncoder::new(&zeros[..], flate2::Compression::best())
        .read_to_end(&mut packed)
        .unwrap();
    let words = |block: u32| {
        [1, block, 0, u32::try_from(packed.len()).unwrap()].map(u32::to_le_bytes).concat()
    };
    let file = |block: u32, extent: &str| {
        let data = array("appended\" offset=\"0", "");
        let text =
            image("compressor=\"vtkZLibDataCompressor\"", &data).replace("0 1 0 1 0 1", extent);
        let start =
            text.replace("</ImageData></VTKFile>", "</ImageData><AppendedData encoding=\"raw\">_");
        [start.as_bytes(), &words(block), &packed].concat()
    };
    let read = |bytes: Vec<u8>, max_memory_bytes| {
        let request = GridRequest { max_memory_bytes, ..request("g") };
        decode_grid(bytes, GridFormat::Vtk, &request).map(|file| file.grid.shape())
    };
    let error = read(file(8, "0 1 0 1 0 1"), None).unwrap_err().to_string();
    assert!(error.contains("block 0 of an array has 9 bytes: expected 8"), "{error}");
    let (all, extent) = (1 << 20, "0 127 0 127 0 63");
    assert_eq!(read(file(all, extent), None).unwrap(), [128, 128, 64]);
    let error = read(file(all, extent), Some(1 << 22)).unwrap_err().to_string();
    assert!(error.contains("bytes of memory: expected at most 4194304"), "{error}");
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
        (
            "a,b\n".to_owned(),
            "expected `# vtk DataFile Version` at its start, or XML with <VTKFile>",
        ),
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
