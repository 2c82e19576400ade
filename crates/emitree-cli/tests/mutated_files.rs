//! Files of all kinds with something wrong in them: each is read, or refused by its name.
//!
//! No reader may panic, abort or go on for ever, whatever the bytes; `cargo xtask fuzz` tests more of
//! them. What was found once is in the tests of the readers.

#![allow(clippy::panic, clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::FromFn;
use emitree::world_tree::{WorldBox, WorldTreeOptions, build_world_tree};
use emitree_instrument::{EffectiveArea, Psf, Redistribution};
use emitree_io::TreeFile;
use emitree_io::grid::{AxisNodes, GridRequest, Step, read_grid};
use emitree_io::table::{TableRequest, read_table};
use emitree_problems::mutation::{Campaign, Mutator, watched};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// A reader, and the text of its error.
type Reader = fn(&Path) -> Result<(), String>;

/// A file that is whole.
struct Original {
    name: String,
    bytes: Vec<u8>,
    read: Reader,
}

/// Arrays of the mutants may take this much, so that the test needs no more on any machine.
const MEMORY_BYTES: u64 = 1 << 26;
/// The longest that reading a small file may take on a busy machine.
const LIMIT: Duration = Duration::from_secs(20);

fn reference(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder)
}

/// All files of a folder that a reader is for.
fn originals(folder: &str, readers: &[(&str, Reader)]) -> Vec<Original> {
    let entries = std::fs::read_dir(reference(folder)).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let of_path = |path: PathBuf| {
        let ending = path.extension()?.to_str()?;
        let (_, read) = readers.iter().find(|(name, _)| *name == ending)?;
        let name = path.file_name()?.to_str()?.to_owned();
        Some(Original { name, bytes: std::fs::read(&path).unwrap(), read: *read })
    };
    paths.into_iter().filter_map(of_path).collect()
}

fn grid(path: &Path) -> Result<(), String> {
    let mut request = GridRequest::default();
    request.max_memory_bytes = Some(MEMORY_BYTES);
    if path.extension().is_some_and(|ending| ending == "npy") {
        let nodes: [&[f64]; 3] = [&[-1.0, 0.0, 2.0, 6.0], &[0.0, 0.5, 2.0], &[10.0, 20.0]];
        request.nodes = nodes.map(|nodes| AxisNodes::List(nodes.to_vec()));
    }
    read_grid(path, &request).map(|_| ()).map_err(|error| error.to_string())
}

/// The second step of a file with steps, or an array of a file with others.
fn part(path: &Path) -> Result<(), String> {
    let mut request = GridRequest::default();
    request.max_memory_bytes = Some(MEMORY_BYTES);
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("vtk" | "vti" | "vtr") => request.values = Some("g".to_owned()),
        _ => request.step = Some(Step::index(1)),
    }
    read_grid(path, &request).map(|_| ()).map_err(|error| error.to_string())
}

fn lookup(path: &Path) -> Result<(), String> {
    let mut request = TableRequest::default();
    if path.extension().is_some_and(|ending| ending == "npz") {
        request.axes = ["T", "n"].map(str::to_owned).to_vec();
    }
    read_table(path, &request).map(|_| ()).map_err(|error| error.to_string())
}

fn tree(path: &Path) -> Result<(), String> {
    TreeFile::open(path).map(|_| ()).map_err(|error| error.to_string())
}

fn area(path: &Path) -> Result<(), String> {
    EffectiveArea::read_arf(path).map(|_| ()).map_err(|error| error.to_string())
}

fn matrix(path: &Path) -> Result<(), String> {
    Redistribution::read_rmf(path).map(|_| ()).map_err(|error| error.to_string())
}

fn kernel(path: &Path) -> Result<(), String> {
    Psf::read_kernel(path).map(|_| ()).map_err(|error| error.to_string())
}

fn table(path: &Path) -> Result<(), String> {
    EffectiveArea::read_table(path).map(|_| ()).map_err(|error| error.to_string())
}

/// Reads as many mutants of the files as a campaign has, each file in turn.
fn read_mutants(originals: Vec<Original>, cases: u64) {
    assert!(!originals.is_empty());
    let originals = Arc::new(originals);
    let folder = Arc::new(tempfile::tempdir().unwrap());
    let mut refused = 0;
    let mut read = 0;
    for seed in Campaign::new(cases, 8.0).seeds() {
        let (originals, folder) = (Arc::clone(&originals), Arc::clone(&folder));
        let case = move || {
            let mut mutator = Mutator::new(seed);
            let original = mutator.choice(&originals).unwrap();
            let path = folder.path().join(format!("{seed}-{}", original.name));
            std::fs::write(&path, mutator.bytes(&original.bytes)).unwrap();
            let result = (original.read)(&path);
            std::fs::remove_file(&path).unwrap();
            (result, path.display().to_string())
        };
        match watched(LIMIT, case) {
            Ok((Ok(()), _)) => read += 1,
            Ok((Err(message), name)) => {
                assert!(message.contains(&name), "seed {seed}: {message}");
                refused += 1;
            }
            Err(failure) => panic!("seed {seed}: {failure}"),
        }
    }
    // Mutants must be neither all whole nor all beyond recognition.
    if read + refused > 100 {
        assert!(refused > 5 && read > 5, "{read} read and {refused} refused");
    }
}

#[test]
fn grids() {
    let endings = ["fits", "npy", "npz", "h5", "nc"];
    let readers = endings.map(|ending| (ending, grid as Reader));
    read_mutants(originals("emitree-io/tests/reference/grids", &readers), 1500);
}

#[test]
fn steps_and_meshes() {
    let endings = ["fits", "npz", "nc", "vtk", "vti", "vtr"];
    let readers = endings.map(|ending| (ending, part as Reader));
    let mut files = originals("emitree-io/tests/reference/steps", &readers);
    files.extend(originals("emitree-io/tests/reference/vtk", &readers));
    read_mutants(files, 800);
}

#[test]
fn tables_of_functions() {
    let endings = ["csv", "ecsv", "fits", "npz"];
    let readers = endings.map(|ending| (ending, lookup as Reader));
    read_mutants(originals("emitree-io/tests/reference/tables", &readers), 800);
}

#[test]
fn saved_trees() {
    let peak = FromFn(|[x, y, z]: [f64; 3], _| (-(x * x + y * y + 2.0 * z * z)).exp());
    let bounds = WorldBox::new([-4.0; 3], [4.0; 3]).unwrap();
    let options = WorldTreeOptions::new(0.1);
    let built = build_world_tree(&peak, bounds, &options).unwrap();
    let file = TreeFile::new(built, options.tolerance).with_units(Some("R_E"), "m-2 s-1");
    let mut bytes = file.encode().unwrap();
    // A reader that finds the wrong sum stops there: most mutants are to get past it.
    let mut at = 0;
    while at + 8 <= bytes.len() {
        if [&b"CHECKSUM"[..], b"DATASUM "].contains(&&bytes[at..at + 8]) {
            bytes[at..at + 80].copy_from_slice(format!("{:80}", "COMMENT").as_bytes());
        }
        at += 80;
    }
    read_mutants(vec![Original { name: "tree.fits".into(), bytes, read: tree }], 300);
}

#[test]
fn responses_and_kernels() {
    let readers: [(&str, Reader); 3] = [("arf", area), ("rmf", matrix), ("rsp", matrix)];
    let mut files = originals("emitree-instrument/tests/reference", &readers);
    let images = originals("emitree-io/tests/reference/grids", &[("fits", kernel)]);
    files.extend(images.into_iter().filter(|file| file.name.starts_with("flat")));
    files.extend(originals("../examples/data", &[("txt", table as Reader)]));
    read_mutants(files, 1000);
}
