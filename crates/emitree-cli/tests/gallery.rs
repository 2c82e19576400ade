//! The scenes of `examples` and the pictures of `docs/gallery.md`.

use crate::support::{Folder, HOLMSTROM, decode_png, pixels};
use emitree_io::{PixelLayout, Scene};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The scenes whose images are pure numbers, or in units that the scene does not state.
const WITHOUT_UNIT: [&str; 5] = ["helix", "holmstrom", "k_corona", "k_corona_polarised", "knot"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The scenes of the folder `examples`, by name.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn scenes() -> Vec<(String, PathBuf)> {
    let entries = std::fs::read_dir(root().join("examples")).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let scenes = paths.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    let name = |path: &Path| path.file_stem().unwrap().to_str().unwrap().to_owned();
    let mut scenes: Vec<_> = scenes.map(|path| (name(&path), path)).collect();
    scenes.sort();
    scenes
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn gallery() -> String {
    std::fs::read_to_string(root().join("docs/gallery.md")).unwrap()
}

/// Options that make the scene small and quick.
fn reduced(scene: &Scene) -> Vec<String> {
    const LONGEST_EDGE: usize = 48;
    let reduce = |pixels: usize| (LONGEST_EDGE * pixels).div_ceil(scene.width.max(scene.height));
    let mut options = match scene.camera.description().pixels {
        PixelLayout::Healpix => vec!["--set=image.nside=8".to_owned()],
        PixelLayout::Rectangle => vec![
            format!("--width={}", reduce(scene.width)),
            format!("--height={}", reduce(scene.height)),
        ],
    };
    options.push(match scene.render.method.name() {
        "paper" => "--finest-level=6".to_owned(),
        _ => "--tolerance=0.05".to_owned(),
    });
    options
}

/// Renders a scene of the folder `examples` at a reduced size, and checks all its files.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn check(name: &str, path: &Path) {
    let scene = Scene::open(path, &[]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_emitree"));
    command.arg("render").arg(path).args(reduced(&scene)).current_dir(&folder);
    command.args(["-o", "a.npy", "-o", "a.png", "--annotate", "--report", "r.json"]);
    let run = command.output().unwrap();
    let texts = [run.stdout, run.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(run.status.code(), Some(0), "{name}:\n{}\n{}", texts[0], texts[1]);

    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let image = pixels(&read("a.npy"));
    let inside = image.iter().filter(|pixel| pixel.is_finite());
    if scene.camera.description().name == "fisheye" {
        // A disc is π/4 of its square.
        assert!(inside.clone().count() * 4 > image.len() * 3, "{name}: a disc with holes");
        assert!(image.iter().all(|pixel| !pixel.is_infinite()), "{name}");
    } else {
        assert_eq!(inside.clone().count(), image.len(), "{name}: pixels that are no numbers");
    }
    let largest = inside.copied().fold(f64::NEG_INFINITY, f64::max);
    assert!(largest > 0.0, "{name}: the image is 0");

    let report: serde_json::Value = serde_json::from_slice(&read("r.json")).unwrap();
    assert_eq!(report["converged"], true, "{name}");
    assert_eq!(report["image"]["unit"], scene.image_unit(), "{name}");
    assert_eq!(scene.image_unit().is_empty(), WITHOUT_UNIT.contains(&name), "{name}");
    let (width, height, _) = decode_png(&read("a.png"));
    assert!(width > 300 && height > 100, "{name}: {width} x {height}");
}

/// Renders every third scene, from `first` on: three tests, so that none takes long.
fn check_every_third(first: usize) {
    let scenes = scenes();
    assert!(scenes.len() >= 14, "{scenes:?}");
    for (name, path) in scenes.into_iter().skip(first).step_by(3) {
        check(&name, &path);
    }
}

#[test]
fn every_first_of_three_examples_becomes_a_picture() {
    check_every_third(0);
}

#[test]
fn every_second_of_three_examples_becomes_a_picture() {
    check_every_third(1);
}

#[test]
fn every_last_of_three_examples_becomes_a_picture() {
    check_every_third(2);
}

#[test]
fn every_example_begins_with_a_description() {
    for (name, path) in scenes() {
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.lines().take(2).all(|line| line.starts_with("# ")), "{name}");
    }
}

#[test]
fn the_gallery_has_every_model_and_every_picture() {
    let gallery = gallery();
    let models = Folder::with_scene("").emitree("models");
    models.succeeds();
    let names: Vec<&str> = models
        .stdout
        .lines()
        .filter(|line| line.starts_with(char::is_lowercase))
        .filter_map(|line| line.split_once(": ").map(|(name, _)| name))
        .collect();
    assert!(names.len() >= 14, "{}", models.stdout);
    for name in names {
        assert!(gallery.contains(&format!("`{name}`")), "no `{name}` in the gallery");
    }
    for (name, _) in scenes() {
        assert!(gallery.contains(&format!("(../examples/{name}.toml)")), "no scene {name}");
    }
    let pictures: Vec<&str> = gallery
        .split("](")
        .filter_map(|rest| rest.split_once(')').map(|(target, _)| target))
        .filter(|target| target.ends_with(".png"))
        .collect();
    assert!(pictures.len() >= 14, "{pictures:?}");
    for picture in pictures {
        let bytes = std::fs::read(root().join("docs").join(picture)).unwrap();
        assert!(bytes.len() < 150_000, "{picture} has {} bytes", bytes.len());
        let (width, height, _) = decode_png(&bytes);
        assert!(width > 300 && height > 100, "{picture}: {width} x {height}");
    }
}

/// The text of the page for each of its scenes: the section, its command and the evaluations.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn costs(gallery: &str) -> Vec<(&str, String, u64)> {
    let sections = gallery.split("\n## ").skip(1).map(|section| {
        let command = section.split_once("```sh\nemitree ").unwrap().1.split_once("```").unwrap().0;
        let words = section.split_once(" evaluations, estimated error ").unwrap().0;
        let evaluations = words.rsplit(' ').next().unwrap().replace(',', "");
        let heading = section.lines().next().unwrap();
        (heading, command.replace("\\\n", " "), evaluations.parse().unwrap())
    });
    sections.collect()
}

/// Renders every second of the scenes that cost least, from the given one on, as the page says: `cargo xtask
/// gallery` renders all, which takes minutes.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn check_costs_of_every_second(first: usize) {
    const CHEAP: u64 = 20_000;
    let gallery = gallery();
    let cheap: Vec<_> = costs(&gallery).into_iter().filter(|cost| cost.2 < CHEAP).collect();
    assert!(cheap.len() >= 6, "{cheap:?}");
    for (heading, command, evaluations) in cheap.into_iter().skip(first).step_by(2) {
        let folder = tempfile::tempdir().unwrap();
        let mut words = command.split_whitespace().skip(1);
        let scene = words.next().unwrap();
        // With the options of the page, so that a method that it names is the one that is compared.
        let mut program = Command::new(env!("CARGO_BIN_EXE_emitree"));
        program.current_dir(&folder).arg("render").arg(root().join(scene));
        program.args(words.map(|word| word.replace("docs/images/gallery/", "")));
        program.args(["--report", "r.json"]);
        assert!(program.output().unwrap().status.success(), "{heading}");
        let report = std::fs::read(folder.path().join("r.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        let hint = "cargo xtask gallery writes what it costs now";
        assert_eq!(report["evaluations"], evaluations, "{heading}: {hint}");
    }
}

#[test]
fn the_gallery_says_what_one_half_of_its_scenes_cost() {
    check_costs_of_every_second(0);
}

#[test]
fn the_gallery_says_what_the_other_half_of_its_scenes_cost() {
    check_costs_of_every_second(1);
}

#[test]
fn annotations_are_around_the_pixels() {
    let folder = Folder::with_scene(HOLMSTROM);
    folder.emitree("render scene.toml -o bare.png --quiet").succeeds();
    let options = "--annotate --error-map error.png --quiet";
    folder.emitree(&format!("render scene.toml -o linear.png {options}")).succeeds();
    folder.emitree("render scene.toml -o log.png --annotate --log --quiet").succeeds();
    let size = |name: &str| {
        let (width, height, _) = decode_png(&folder.bytes(name));
        [width, height]
    };
    assert_eq!(size("bare.png"), [64, 64]);
    for name in ["linear.png", "log.png", "error.png"] {
        assert!(size(name)[0] > 700 && size(name)[1] > 650, "{name}: {:?}", size(name));
    }
    assert_ne!(folder.bytes("linear.png"), folder.bytes("log.png"));
}

#[test]
fn annotations_without_a_picture_are_refused() {
    let folder = Folder::with_scene(HOLMSTROM);
    let run = folder.emitree("render scene.toml -o a.npy --annotate");
    run.fails_with(2);
    let expected = "--annotate: no output is a picture: expected one that ends in .png";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
    let run = folder.emitree("render scene.toml -o a.png --log");
    run.fails_with(2);
    assert!(run.stderr.contains("--annotate"), "{}", run.stderr);
    folder.holds(&["scene.toml"]);
}
