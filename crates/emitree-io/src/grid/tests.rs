//! Files that `numpy`, astropy, h5py and netCDF4 have written: `tests/reference/grids.py`.

use super::*;
use crate::encode_npy;
use std::path::PathBuf;

const X: [f64; 4] = [-1.0, 0.0, 2.0, 6.0];
const Y: [f64; 3] = [0.0, 0.5, 2.0];
const Z: [f64; 2] = [10.0, 20.0];
const UNIT: Option<&str> = Some("cm-3 s-1");

fn path(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests/reference/grids", name].iter().collect()
}

fn bytes(name: &str) -> Vec<u8> {
    fs::read(path(name)).unwrap()
}

fn read(name: &str, request: &GridRequest) -> GridFile {
    read_grid(&path(name), request).unwrap()
}

/// What is wrong with a file, without its name.
fn failure(name: &str, request: &GridRequest) -> GridReadError {
    read_grid(&path(name), request).unwrap_err().cause
}

fn message(name: &str, request: &GridRequest) -> String {
    failure(name, request).to_string()
}

fn lists() -> GridRequest {
    let nodes = [AxisNodes::List(X.to_vec()), AxisNodes::List(Y.into()), AxisNodes::List(Z.into())];
    GridRequest { nodes, ..GridRequest::default() }
}

fn named(values: &str, nodes: [&str; 3]) -> GridRequest {
    let nodes = nodes.map(|name| AxisNodes::Named(name.to_owned()));
    GridRequest { values: Some(values.to_owned()), nodes, ..GridRequest::default() }
}

/// 100 z + 10 y + x of the indices, times a factor.
fn values(factor: f64) -> Vec<f64> {
    let mut values = Vec::new();
    for z in [0.0, 100.0] {
        for y in [0.0, 10.0, 20.0] {
            values.extend([0.0, 1.0, 2.0, 3.0].map(|x| factor * (x + y + z)));
        }
    }
    values
}

/// That a file has the nodes and the values of the script.
fn check(name: &str, request: &GridRequest, unit: Option<&str>) {
    let file = read(name, request);
    assert_eq!(file.grid.nodes(), [&X[..], &Y[..], &Z[..]], "{name}");
    assert_eq!(file.grid.values(), values(1.0), "{name}");
    assert_eq!(file.unit.as_deref(), unit, "{name}");
}

#[test]
fn fits_in_the_layout_of_smile() {
    let request = GridRequest::default();
    check("smile.fits", &request, UNIT);
    check("smile_mixed.fits", &request, None);
    check("nameless.fits", &request, None);
    check("scaled.fits", &request, None);
    let mut request = GridRequest { values: Some("EMISSIVITY".into()), ..request };
    check("extension.fits", &request, UNIT);
    request.values = Some("other".into());
    request.scale = 0.5;
    check("extension.fits", &request, None);
    check("extension.fits", &named("emissivity", ["X", "y", "z"]), UNIT);
    check("smile.fits", &named("primary", ["x", "y", "z"]), UNIT);
}

#[test]
fn fits_with_linear_coordinates() {
    let file = read("wcs.fits", &GridRequest::default());
    let nodes = [&[-1.0, -0.5, 0.0, 0.5][..], &[-3.0, 0.0, 3.0], &[15.0, 25.0]];
    assert_eq!(file.grid.nodes(), nodes);
    assert_eq!(file.grid.values(), values(1.0));
    assert_eq!(
        message("wcs_rotated.fits", &GridRequest::default()),
        "the x axis: it can't be read as FITS: its coordinate 1 depends on several axes of the \
         image: expected none of the terms PC1_2 and CD1_2"
    );
    assert_eq!(
        message("no_axes.fits", &GridRequest::default()),
        "the x axis: the file does not contain its nodes: expected an image extension `x`, or CRPIX1, \
         CRVAL1 and CDELT1 in the header of the values"
    );
    check("no_axes.fits", &lists(), None);
}

#[test]
fn npy_of_every_type_and_order() {
    let of_types = ["f8", "f4_big", "i2", "i8_big", "u1", "i4_big", "u8", "fortran"];
    for name in of_types {
        check(&format!("{name}.npy"), &lists(), None);
    }
    check("negative_i2.npy", &GridRequest { scale: -1.0, ..lists() }, None);
    check("xyz.npy", &GridRequest { order: Some(ArrayOrder::XYZ), ..lists() }, None);
    let mut ranges = lists();
    ranges.nodes[0] = AxisNodes::Range { min: 0.0, max: 1.5 };
    assert_eq!(read("f8.npy", &ranges).grid.nodes()[0], [0.0, 0.5, 1.0, 1.5]);
    assert_eq!(
        message("complex.npy", &lists()),
        "it can't be read as NPY: its numbers are '<c16': expected one of f4, f8, i1 to i8, \
         u1 to u8"
    );
    assert_eq!(
        message("f8.npy", &GridRequest::default()),
        "the x axis: the file does not contain its nodes: expected their numbers or their range, \
         since an NPY file has only one array"
    );
}

#[test]
fn npz_by_name() {
    check("plain.npz", &GridRequest::default(), None);
    check("compressed.npz", &named("rate", ["lon", "lat", "z"]), None);
    let missing = failure("compressed.npz", &GridRequest::default());
    assert_eq!(missing.concerns(), "values");
    assert_eq!(
        missing.to_string(),
        "it has no array `values`: expected one of `rate`, `lon`, `lat`, `z`"
    );
    let missing = failure("compressed.npz", &named("rate", ["x", "lat", "z"]));
    assert_eq!(missing.concerns(), "x");
    assert_eq!(
        missing.to_string(),
        "the x axis: it has no array `x`: expected one of `rate`, `lon`, `lat`, `z`"
    );
}

#[cfg(feature = "hdf5")]
mod with_hdf5 {
    use super::*;

    #[test]
    fn hdf5_by_name_and_in_groups() {
        check("plain.h5", &GridRequest::default(), UNIT);
        let request = GridRequest { values: Some("/run/last/g".into()), ..GridRequest::default() };
        check("group.h5", &request, None);
        assert_eq!(
            message("group.h5", &GridRequest::default()),
            "it has no array `values`: expected one of `note`, `run/last/g`, `run/last/x`, \
             `run/last/y`, `run/last/z`"
        );
        let text = message("group.h5", &GridRequest { values: Some("note".into()), ..lists() });
        assert_eq!(text, "the values are an array of shape []: expected three axes");
    }

    #[test]
    fn netcdf_classic_and_4() {
        for name in ["classic.nc", "version4.nc", "packed.nc", "named_axes.nc"] {
            check(name, &GridRequest::default(), UNIT);
        }
    }

    #[test]
    fn netcdf_has_the_order_of_its_axes() {
        check("version4_yxz.nc", &GridRequest::default(), UNIT);
        let request = GridRequest { order: Some(ArrayOrder::ZYX), ..GridRequest::default() };
        let error = failure("version4_yxz.nc", &request);
        assert_eq!(error.concerns(), "order");
        assert_eq!(
            error.to_string(),
            "the order of axes is given as zyx, but the file names them yxz: expected the same"
        );
    }

    #[test]
    fn missing_values_are_refused_and_chunks_that_are_not_there_are_filled() {
        for (name, node) in [
            ("missing.h5", "(0, 0, 1)"),
            ("fill.nc", "(2, 1, 1)"),
            ("default_fill.nc", "(0, 0, 1)"),
        ] {
            assert_eq!(
                message(name, &GridRequest::default()),
                format!(
                    "the value at the node with indices (x, y, z) = {node} is NaN: expected a \
                     finite number (blanks and fill values are read as NaN)"
                )
            );
        }
        let file = read("unwritten.h5", &GridRequest::default());
        assert_eq!(file.grid.values()[..12], values(1.0)[..12]);
        assert_eq!(file.grid.values()[12..], [-1.0; 12]);
    }

    #[test]
    fn cut_files_are_refused_or_have_the_requested_values() {
        for name in ["plain.h5", "version4.nc", "classic.nc"] {
            let bytes = bytes(name);
            let (mut refused, request) = (0, GridRequest::default());
            for length in (0..bytes.len()).step_by(23) {
                let cut = bytes[..length].to_vec();
                match decode_grid(cut, GridFormat::NetCdf, &request) {
                    // HDF5 may have unused bytes at its end.
                    Ok(file) => assert_eq!(file.grid.values(), values(1.0), "{name} {length}"),
                    Err(error) => {
                        let text = error.to_string();
                        assert!(
                            text.contains("it can't be read as NetCDF: ")
                                || text.contains("it has no array"),
                            "{name} {length}: {text}"
                        );
                        refused += length;
                    }
                }
            }
            assert!(refused > bytes.len(), "{name}: {refused}");
        }
    }
}

#[cfg(not(feature = "hdf5"))]
#[test]
fn formats_that_were_not_built_are_named() {
    assert_eq!(
        message("plain.h5", &GridRequest::default()),
        "this program was built without HDF5: expected a build with the feature `hdf5`"
    );
}

#[test]
fn blanks_of_fits_are_missing() {
    assert_eq!(
        message("blank.fits", &GridRequest::default()),
        "the value at the node with indices (x, y, z) = (2, 1, 1) is NaN: expected a finite number \
         (blanks and fill values are read as NaN)"
    );
}

#[test]
fn shapes_that_do_not_fit_are_refused() {
    let flat = failure("flat.fits", &GridRequest::default());
    assert_eq!(flat.concerns(), "values");
    assert_eq!(flat.to_string(), "the values are an array of shape [3, 4]: expected three axes");
    let wrong_order = GridRequest { order: Some(ArrayOrder::XYZ), ..GridRequest::default() };
    assert_eq!(
        message("smile.fits", &wrong_order),
        "the x axis: it has 4 nodes: expected 2, since the values are an array of shape [2, 3, 4], \
         with axes in the order xyz"
    );
    let mut cube_as_axis = named("emissivity", ["x", "other", "z"]);
    assert_eq!(
        message("extension.fits", &cube_as_axis),
        "the y axis: it is an array of shape [2, 3, 4]: expected one axis"
    );
    cube_as_axis.nodes[1] = AxisNodes::List(vec![1.0, 0.0, 2.0]);
    let error = failure("extension.fits", &cube_as_axis);
    assert_eq!(error.concerns(), "y");
    assert_eq!(
        error.to_string(),
        "node 1 of the y axis is 0 and follows 1: expected nodes that all increase or all decrease"
    );
    let plane = encode_npy(&[1, 3, 4], &[0.0; 12]).unwrap();
    let mut request = lists();
    request.nodes[2] = AxisNodes::List(vec![10.0]);
    assert_eq!(
        decode_grid(plane, GridFormat::Npy, &request).unwrap_err().to_string(),
        "the z axis has 1 node(s): expected at least 2, since a plane has no volume"
    );
}

#[test]
fn files_that_are_not_there_are_named() {
    let error = read_grid("no/such.npy".as_ref(), &lists()).unwrap_err().to_string();
    assert!(error.starts_with("the grid no/such.npy: it can't be read: "), "{error}");
    let error = read_grid("cube.dat".as_ref(), &lists()).unwrap_err().to_string();
    assert!(error.starts_with("the grid cube.dat: no grid format for this ending: "), "{error}");
    let of_another = GridRequest { format: Some(GridFormat::Npz), ..lists() };
    let error = read_grid(&path("f8.npy"), &of_another).unwrap_err().to_string();
    assert!(error.contains("f8.npy: it can't be read as NPZ: "), "{error}");
}

#[test]
fn cut_fits_files_are_refused() {
    let whole = bytes("smile.fits");
    for length in [0, 100, 2879, 2900, whole.len() - 2880] {
        let cut = whole[..length].to_vec();
        let error = decode_grid(cut, GridFormat::Fits, &GridRequest::default()).unwrap_err();
        assert!(error.to_string().contains("it can't be read as FITS: "), "{length}: {error}");
    }
    // Within the header of an extension: what is left is a file without it.
    let cut = whole[..2880 * 2 + 100].to_vec();
    let error = decode_grid(cut, GridFormat::Fits, &GridRequest::default()).unwrap_err();
    assert!(error.to_string().starts_with("the x axis: the file does not contain "), "{error}");
}

#[test]
fn cut_or_wrong_npy_files_are_refused() {
    let whole = bytes("f8.npy");
    let message =
        |bytes: Vec<u8>| decode_grid(bytes, GridFormat::Npy, &lists()).unwrap_err().to_string();
    let start = "it can't be read as NPY: ";
    for (length, reason) in [
        (0, "expected \\x93NUMPY and a version at its start"),
        (7, "expected \\x93NUMPY and a version at its start"),
        (9, "its header is cut off"),
        (100, "its header is cut off"),
        (319, "it has 191 bytes of numbers: expected as many as its shape [2, 3, 4] takes with f8"),
    ] {
        assert_eq!(message(whole[..length].to_vec()), format!("{start}{reason}"));
    }
    let replaced = |from: &str, to: &str| {
        let mut bytes = whole.clone();
        let at = bytes.windows(from.len()).position(|part| part == from.as_bytes()).unwrap();
        bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
        message(bytes)
    };
    assert_eq!(
        replaced("<f8", "<f2"),
        format!("{start}its numbers are '<f2': expected one of f4, f8, i1 to i8, u1 to u8")
    );
    assert!(replaced("(2, 3, 4)", "(2, 3, -)").contains("expected a tuple of lengths"));
    assert!(replaced("'shape'", "'shave'").contains("has no `shape`"));
    assert!(replaced("False", "Maybe").contains("expected a boolean"));
    assert!(replaced("(2, 3, 4)", "(9, 9, 9)").contains("it has 192 bytes of numbers"));
    let mut version = whole.clone();
    version[6] = 9;
    assert_eq!(message(version), format!("{start}its version is 9: expected 1, 2 or 3"));
}

#[test]
fn cut_npz_files_are_refused() {
    let whole = bytes("compressed.npz");
    for length in [0, 50, whole.len() - 30] {
        let cut = whole[..length].to_vec();
        let error = decode_grid(cut, GridFormat::Npz, &lists()).unwrap_err().to_string();
        assert!(error.starts_with("it can't be read as NPZ: "), "{error}");
    }
    // A bit of the compressed numbers: found by the checksum.
    let mut wrong = whole;
    wrong[80] ^= 1;
    let request = named("rate", ["lon", "lat", "z"]);
    let error = decode_grid(wrong, GridFormat::Npz, &request).unwrap_err().to_string();
    assert!(error.starts_with("it can't be read as NPZ: "), "{error}");
}

#[test]
fn what_is_not_finite_after_scaling_is_refused() {
    let request = GridRequest { scale: 1e307, ..lists() };
    assert_eq!(
        message("f8.npy", &request),
        "the value at the node with indices (x, y, z) = (0, 2, 0) is inf: expected a finite number \
         (blanks and fill values are read as NaN)"
    );
}

/// Small files that declare large arrays: the limit is in the message, and nothing is allocated.
#[test]
fn arrays_are_compared_with_the_memory_allowed() {
    let allowed = |bytes, request| GridRequest { max_memory_bytes: Some(bytes), ..request };
    let too_large = |shape: &str, needed: u64, allowed: u64| {
        format!(
            "to read an array of shape {shape} takes {needed} bytes of memory: expected at most \
             {allowed}, which are available"
        )
    };
    for name in ["smile.fits", "plain.npz"] {
        let request = |bytes| allowed(bytes, GridRequest::default());
        assert_eq!(message(name, &request(191)), too_large("[2, 3, 4]", 192, 191), "{name}");
        assert!(read_grid(&path(name), &request(192)).is_ok(), "{name}");
    }
    // Another order of the axes takes a second array.
    let xyz = |bytes| GridRequest { order: Some(ArrayOrder::XYZ), ..allowed(bytes, lists()) };
    assert_eq!(message("xyz.npy", &xyz(383)), too_large("[4, 3, 2]", 384, 383));
    assert!(read_grid(&path("xyz.npy"), &xyz(384)).is_ok());

    // Holes take no room on a disk.
    let folder = tempfile::tempdir().unwrap();
    let sparse = folder.path().join("sparse.npy");
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (50000, 50000, 5000), }\n";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    fs::write(&sparse, &bytes).unwrap();
    let length = bytes.len() as u64 + 100_000_000_000_000;
    let file = File::options().write(true).open(&sparse).unwrap();
    // Not every file system has files of 100 TB.
    if file.set_len(length).is_ok() {
        let error = read_grid(&sparse, &lists()).unwrap_err().to_string();
        let start = format!("the grid {}: to read an array of shape [50000, ", sparse.display());
        assert!(error.starts_with(&start), "{error}");
        assert!(error.contains("takes 100000000000000 bytes"), "{error}");
    }
}

/// An archive that is small because its numbers are all the same.
#[test]
fn an_archive_is_unpacked_no_further_than_memory_allows() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.npz");
    let mut archive = zip::ZipWriter::new(File::create(&path).unwrap());
    let options = zip::write::SimpleFileOptions::default();
    archive.start_file("values.npy", options).unwrap();
    archive.write_all(&encode_npy(&[100, 100, 100], &vec![0.0; 1_000_000]).unwrap()).unwrap();
    archive.finish().unwrap();
    assert!(fs::metadata(&path).unwrap().len() < 20_000);
    let request = GridRequest { max_memory_bytes: Some(1 << 20), ..GridRequest::default() };
    let error = read_grid(&path, &request).unwrap_err().to_string();
    assert!(error.contains("bomb.npz") && error.contains("takes 8000000 bytes"), "{error}");
}

#[cfg(feature = "hdf5")]
#[test]
fn hdf5_in_memory_needs_memory_for_its_file_too() {
    let length = bytes("unwritten.h5").len() as u64;
    let request = |bytes| GridRequest { max_memory_bytes: Some(bytes), ..GridRequest::default() };
    let decode = |most| decode_grid(bytes("unwritten.h5"), GridFormat::Hdf5, &request(most));
    let needed = length + 192;
    let text = decode(needed - 1).unwrap_err().to_string();
    assert!(text.contains(&format!("shape [2, 3, 4] takes {needed} bytes")), "{text}");
    assert!(decode(needed).is_ok());
    let text = decode(length - 1).unwrap_err().to_string();
    assert!(text.contains(&format!("takes {length} bytes")), "{text}");
    // A file itself is read in place.
    let text = message("unwritten.h5", &request(191));
    assert!(text.contains("shape [2, 3, 4] takes 192 bytes"), "{text}");
    assert!(read_grid(&path("unwritten.h5"), &request(192)).is_ok());
}

#[test]
fn only_ordinary_files_are_read() {
    let error =
        read_grid(path("").as_ref(), &GridRequest { format: Some(GridFormat::Npy), ..lists() });
    assert!(error.unwrap_err().to_string().contains("it is not an ordinary file"));
    if cfg!(unix) {
        let request = GridRequest { format: Some(GridFormat::Npy), ..lists() };
        let error = read_grid("/dev/zero".as_ref(), &request).unwrap_err().to_string();
        assert!(
            error.contains("/dev/zero: it can't be read: it is not an ordinary file"),
            "{error}"
        );
    }
}

/// A FITS image that is stored in a table, tile by tile.
#[test]
fn images_compressed_by_tiles_are_distinguished_from_none() {
    let mut bytes = Vec::new();
    let card = |text: &str| format!("{text:80}").into_bytes();
    let primary = [
        "SIMPLE  =                    T",
        "BITPIX  =                    8",
        "NAXIS   =                    0",
        "EXTEND  =                    T",
        "END",
    ];
    let table = [
        "XTENSION= 'BINTABLE'",
        "BITPIX  =                    8",
        "NAXIS   =                    2",
        "NAXIS1  =                    8",
        "NAXIS2  =                    0",
        "PCOUNT  =                    0",
        "GCOUNT  =                    1",
        "TFIELDS =                    1",
        "TTYPE1  = 'COMPRESSED_DATA'",
        "TFORM1  = '1PB(0)  '",
        "ZIMAGE  =                    T",
        "ZBITPIX =                  -64",
        "ZNAXIS  =                    3",
        "ZNAXIS1 =                    4",
        "ZNAXIS2 =                    3",
        "ZNAXIS3 =                    2",
        "ZCMPTYPE= 'GZIP_1  '",
        "EXTNAME = 'RATE    '",
        "END",
    ];
    for header in [&primary[..], &table[..]] {
        bytes.extend(header.iter().flat_map(|text| card(text)));
        bytes.resize(bytes.len().next_multiple_of(2880), b' ');
    }
    let expected = "it can't be read as FITS: its image in HDU 1 is compressed by tiles (ZIMAGE = T): \
                    expected one that is not, as `funpack` makes it";
    let named = GridRequest { values: Some("rate".into()), ..GridRequest::default() };
    for request in [GridRequest::default(), named] {
        let error = decode_grid(bytes.clone(), GridFormat::Fits, &request).unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
}

/// Spherical, with the dimensions lat, radius and lon, and their units.
#[cfg(feature = "hdf5")]
#[test]
fn the_names_and_units_of_geography_are_honoured() {
    use emitree::{Emission, Samples};
    use emitree_models::grid::Coordinates;
    let request = GridRequest { coordinates: Coordinates::Spherical, ..GridRequest::default() };
    let grid = read("globe.nc", &request).grid;
    assert_eq!(grid.shape(), [2, 3, 3]);
    let rate = |[r, latitude, phi]: [f64; 3]| {
        let [latitude, phi] = [latitude, phi].map(f64::to_radians);
        let in_plane = r * latitude.cos();
        let position = [in_plane * phi.cos(), in_plane * phi.sin(), r * latitude.sin()];
        let mut rate = [f64::NAN];
        grid.emission_rates(&Samples::new(&[position], &[[0.0; 3]]), &mut rate).unwrap();
        rate[0]
    };
    // g = r + latitude/100, and 10 more at 120 degrees.
    for (at, expected) in [
        ([1.5, 30.0, 0.0], 1.8),
        ([1.5, -30.0, 60.0], 1.2 + 5.0),
        ([1.5, 0.0, -60.0], 1.5),
        ([1.25, 50.0, 120.0], 1.25 + 0.5 + 10.0),
        // The mean of the ring at 60 degrees is that of the pole.
        ([1.0, 90.0, 0.0], 1.6 + 10.0 / 3.0),
    ] {
        let found = rate(at);
        assert!((found - expected).abs() < 1e-12, "{at:?}: {found} {expected}");
    }
    let degrees = GridRequest { angle_unit: Some(AngleUnit::Radians), ..request };
    let error = message("globe.nc", &degrees);
    assert!(error.starts_with("the theta axis: node 0 is 60 rad: expected a latitude"), "{error}");
}
