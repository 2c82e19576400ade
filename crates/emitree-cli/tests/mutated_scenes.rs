//! Scenes with something wrong in them, and views of nothing, everything or the inside of a body: each
//! ends with an exit code of the contract, in time, and leaves no half-written file.
//!
//! `cargo xtask fuzz` tests more of them. The scenes of the folder `scenes` are what was found.

#![allow(clippy::panic, clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree_problems::mutation::{Campaign, Mutator};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The longest that a small image with a few thousand evaluations may take on a busy machine.
const LIMIT: Duration = Duration::from_secs(40);
/// What every mutant is reduced to, so that a campaign has many cases.
const SMALL: [&str; 4] = ["--threads=1", "--quiet", "--report=report.json", "-o=image.npy"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The texts of all scenes of a folder, in the order of their names.
fn scenes(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    paths.sort();
    paths.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect()
}

/// Renders a scene; the exit code, which is one of the contract, and the messages.
fn render(folder: &TempDir, case: &str, scene: &str, options: &[&str]) -> (i32, String) {
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_emitree"));
    command.args(["render", "scene.toml"]).args(SMALL).args(options).current_dir(folder);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    // A file: a pipe would not be emptied while the program runs.
    let messages = folder.path().join("messages.txt");
    command.stderr(std::fs::File::create(&messages).unwrap());
    let mut child = command.spawn().unwrap();
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > LIMIT {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{case}: it has not ended in {LIMIT:?}:\n{scene}\n{options:?}");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let said = String::from_utf8(std::fs::read(&messages).unwrap()).unwrap();
    let code = status.code().unwrap_or(-1);
    assert!([0, 2, 3, 4].contains(&code), "{case}: {status}\n{said}\n{scene}\n{options:?}");
    let names = ["image.npy", "report.json"].map(|name| folder.path().join(name).exists());
    assert_eq!(names, [code == 0 || code == 4; 2], "{case}: {status}\n{said}\n{scene}");
    for name in ["image.npy", "report.json"] {
        let _ = std::fs::remove_file(folder.path().join(name));
    }
    let left = std::fs::read_dir(folder).unwrap().flatten();
    let left: Vec<_> = left.filter(|e| e.path().extension().is_some_and(|e| e == "part")).collect();
    assert!(left.is_empty(), "{case}: {left:?}");
    if code != 0 && code != 4 {
        assert!(!said.is_empty(), "{case}: nothing was said:\n{scene}");
    }
    (code, said)
}

/// A folder with the data that the examples read.
fn folder_with_data() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    for entry in std::fs::read_dir(root().join("examples/data")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, data.join(path.file_name().unwrap())).unwrap();
    }
    folder
}

#[test]
fn mutants_of_the_examples() {
    let originals = scenes(&root().join("examples"));
    let folder = folder_with_data();
    for seed in Campaign::new(60, 6.0).seeds() {
        let mut mutator = Mutator::new(seed);
        let original = mutator.choice(&originals).unwrap();
        let scene = mutator.scene(original);
        // One size and budget for all: the examples are larger than a test can be.
        let sky = scene.contains("nside");
        let size: &[&str] =
            if sky { &["--set=image.nside=2"] } else { &["--width=7", "--height=5"] };
        let options = [size, &["--max-evaluations=2000"]].concat();
        let (code, said) = render(&folder, &format!("seed {seed}"), &scene, &options);
        // The message about a wrong scene has its place.
        if code == 2 && said.contains('×') {
            let has_place = said.contains("scene.toml") || said.contains("option --");
            assert!(has_place, "seed {seed}: {said}\n{scene}");
        }
    }
}

#[test]
fn random_views() {
    let folder = tempfile::tempdir().unwrap();
    let mut ended = [0; 5];
    for seed in Campaign::new(80, 6.0).seeds() {
        let scene = Mutator::new(seed).view();
        let (code, _) = render(&folder, &format!("seed {seed}"), &scene, &[]);
        ended[usize::try_from(code).unwrap()] += 1;
    }
    // Most of these views can be rendered.
    assert!(2 * (ended[0] + ended[4]) >= ended[2], "{ended:?}");
}

/// Budgets in which samples that cost nothing once were not counted.
#[test]
fn every_budget_ends() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = scenes(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes"));
    for budget in [729, 1000, 2000] {
        for scene in &scenes {
            let option = format!("--max-evaluations={budget}");
            let mut options = vec![option.as_str(), "--tolerance=0.01"];
            if !scene.contains("nside") {
                options.extend(["--width=16", "--height=16"]);
            }
            render(&folder, "a known scene", scene, &options);
        }
    }
}
