use super::*;
use emitree::world_tree::{WorldBox, WorldTreeOptions, build_world_tree};
use emitree::{Emission, FromFn, Samples};
use fits_well::table::{Builder, ColumnData, WriteColumn};
use fits_well::{FitsReader, FitsWriter};
use std::path::Path;

fn file() -> TreeFile {
    let g = FromFn(|[x, y, z]: [f64; 3], _: [f64; 3]| {
        (-(x * x + (y - 1.0).powi(2) + 3.0 * z * z)).exp() / 3.0
    });
    let bounds = WorldBox::new([-4.0, -3.0, -0.1], [4.0, 5.0, 1.0 / 3.0]).unwrap();
    let options = WorldTreeOptions::default().with_base_level(3);
    let built = build_world_tree(&g, bounds, &options).unwrap();
    TreeFile::new(built, 1e-3)
        .with_units(Some("R_E"), "keV cm-2 s-1 sr-1")
        .with_scene("# a scene\n[emission]\nexpression = \"é\"\n")
}

fn decode(bytes: &[u8]) -> Result<TreeFile, TreeFileError> {
    TreeFile::decode(Path::new("model.fits"), bytes)
}

#[test]
fn every_bit_comes_back() {
    let written = file();
    let read = decode(&written.encode().unwrap()).unwrap();
    assert_eq!(read.tree.bounds(), written.tree.bounds());
    assert!(read.tree.families().eq(written.tree.families()));
    assert_eq!(read.tree.order(), 5);
    assert_eq!(read.evaluations, 1_024 + written.tree.cells() as u64);
    assert_eq!(
        (read.length_unit.as_deref(), &*read.image_unit),
        (Some("R_E"), "keV cm-2 s-1 sr-1")
    );
    assert!(read.converged && written.converged);
    let numbers = |f: &TreeFile| {
        [f.tolerance, f.threshold, f.largest_dropped, f.largest_rate].map(f64::to_bits)
    };
    assert_eq!(numbers(&read), numbers(&written));
    assert_eq!(read.scene, "# a scene\n[emission]\nexpression = \"\\u00e9\"\n");

    let positions: Vec<[f64; 3]> = (0..5_000)
        .map(|n| [0.618, 0.414, 0.732].map(|s: f64| (f64::from(n) * s).fract()))
        .map(|[x, y, z]| [8.0 * x - 4.0, 8.0 * y - 3.0, 0.43 * z - 0.1])
        .collect();
    let directions = vec![[1.0, 0.0, 0.0]; positions.len()];
    let [a, b] = [&written, &read].map(|file| {
        let mut rates = vec![f64::NAN; positions.len()];
        let Ok(()) = file.tree.emission_rates(&Samples::new(&positions, &directions), &mut rates);
        rates.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    });
    assert_eq!(a, b);
}

#[test]
fn a_tree_without_units_has_none_again() {
    let mut written = file().with_units(None, "").with_scene("");
    written.converged = false;
    let read = decode(&written.encode().unwrap()).unwrap();
    assert_eq!((read.length_unit, &*read.image_unit, &*read.scene), (None, "", ""));
    assert!(!read.converged);
}

#[test]
fn a_file_that_is_missing_or_no_fits_is_named() {
    let missing = TreeFile::open("no/such/model.fits").unwrap_err().to_string();
    assert!(missing.starts_with("the tree no/such/model.fits can't be read: "), "{missing}");
    let error = decode(b"plain text").unwrap_err().to_string();
    assert!(error.starts_with("the tree model.fits "), "{error}");
    assert!(error.ends_with(": expected a file of `emitree build`"), "{error}");
    let image = emitree::Image::zeros(2, 2);
    let image = crate::FitsFile {
        primary: crate::FitsImage::new("RADIANCE", &image, None),
        energies: None,
        extensions: Vec::new(),
        wcs: None,
        provenance: Vec::new(),
        history: String::new(),
        date: None,
    };
    assert_eq!(
        decode(&image.encode().unwrap()).unwrap_err().to_string(),
        "the tree model.fits has no table `TREE`, or it is cut off: expected a file of `emitree \
         build`"
    );
}

/// Whatever is cut off the end, and wherever a byte is wrong, the file is refused.
#[test]
fn a_damaged_file_is_refused() {
    let bytes = file().encode().unwrap();
    for length in [0, 100, 2_880, 4_000, 8_640, bytes.len() / 2, bytes.len() - 2_881] {
        let error = decode(&bytes[..length]).unwrap_err().to_string();
        assert!(error.starts_with("the tree model.fits "), "{length}: {error}");
    }
    let mut damaged = bytes;
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    assert_eq!(
        decode(&damaged).unwrap_err().to_string(),
        "the tree model.fits has a wrong checksum: expected the bytes that `emitree build` wrote"
    );
}

/// The header of a good file with one record changed, and a table, without a checksum.
fn changed(change: impl FnOnce(&mut fits_well::header::Header), table: &Builder) -> String {
    let bytes = file().encode().unwrap();
    let reader = FitsReader::from_bytes(&bytes).unwrap();
    let mut header = reader.hdu(TABLE).unwrap().header.clone();
    change(&mut header);
    let mut writer = FitsWriter::new(Vec::new());
    writer.write_table(table, Some(&header)).unwrap();
    decode(&writer.into_inner()).unwrap_err().to_string()
}

fn columns(families: &[emitree::tree::Family]) -> [ColumnData; 3] {
    [
        ColumnData::U8(families.iter().map(|f| f.level).collect()),
        ColumnData::I32(families.iter().flat_map(|f| f.position.map(u32::cast_signed)).collect()),
        ColumnData::F64(families.iter().flat_map(|f| f.values).collect()),
    ]
}

fn table([levels, positions, rates]: [ColumnData; 3]) -> Builder {
    let mut table = Builder::new();
    table.push(WriteColumn::fixed("LEVEL", levels, 1)).unwrap();
    table.push(WriteColumn::fixed("FAMILY", positions, 3)).unwrap();
    table.push(WriteColumn::fixed("RATES", rates, 8)).unwrap();
    table
}

#[test]
fn wrong_records_are_named() {
    let families: Vec<_> = file().tree.families().collect();
    let with = |change: &dyn Fn(&mut fits_well::header::Header)| {
        changed(|header| change(header), &table(columns(&families)))
    };
    for (keyword, expected) in [
        ("TREEVERS", "an integer"),
        ("BOXMIN2", "a number"),
        ("ORDER", "an integer"),
        ("NEVAL", "an integer"),
        ("CONVERGD", "T or F"),
    ] {
        let error = with(&|header| drop(header.remove(keyword)));
        assert!(error.starts_with("the tree model.fits: "), "{error}");
        assert!(error.ends_with(&format!(": expected `{keyword}` to be {expected}")), "{error}");
        let error = with(&|header| drop(header.set(keyword, "text")));
        assert!(error.ends_with(&format!(": expected `{keyword}` to be {expected}")), "{error}");
    }
    assert_eq!(
        with(&|header| drop(header.set("TREEVERS", 2_i64))),
        "the tree model.fits: `TREEVERS` is 2: expected 1"
    );
    assert_eq!(
        with(&|header| drop(header.set("BASELEVL", -3_i64))),
        "the tree model.fits: `BASELEVL` is -3: expected a number in its range"
    );
    assert_eq!(
        with(&|header| drop(header.set("ORDER", 4_i64))),
        "the tree model.fits: the order is 4: expected 3, 5 or 7"
    );
    assert_eq!(
        with(&|header| drop(header.set("BOXMAX1", -9.5))),
        "the tree model.fits: the box reaches from -4 to -9.5 along x: expected finite numbers, the \
         first below the second"
    );
}

#[test]
fn wrong_columns_and_rows_are_named() {
    let families: Vec<_> = file().tree.families().collect();
    let error = |columns| changed(|_| {}, &table(columns));
    let [levels, positions, rates] = columns(&families);
    let count = families.len();
    let bytes = ColumnData::U8(vec![0; 3 * count]);
    assert_eq!(
        error([levels.clone(), bytes, rates.clone()]),
        "the tree model.fits: the column `FAMILY` is missing or something else: expected 3 32-bit \
         integers (J) in each row"
    );
    let mut lacking = Builder::new();
    lacking.push(WriteColumn::fixed("LEVEL", levels.clone(), 1)).unwrap();
    lacking.push(WriteColumn::fixed("FAMILY", positions.clone(), 3)).unwrap();
    assert!(changed(|_| {}, &lacking).contains("the column `RATES` is missing"));
    let mut moved = families.clone();
    moved[count - 1].position = [u32::MAX, 0, 0];
    assert!(error(columns(&moved)).ends_with(" fills a cell that the tree has not"));
    let mut hole = families.clone();
    hole[5].values[2] = f64::NAN;
    assert_eq!(
        error(columns(&hole)),
        "the tree model.fits: family 5 has the value NaN: expected a finite number"
    );
    assert_eq!(
        error(columns(&families[..63])),
        "the tree model.fits: there are 63 families: expected at least 64, those of the base grid"
    );
}
